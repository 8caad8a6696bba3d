"""Run many cells on one machine or many, and make a page of them; what was run before is only read.

python -m benchmarks.study formative | evaluation | ablation | published | page … --help     (in the repository)
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from mechstyle.cli.console import EXIT_BAD_INPUT, command, escape, out, print_json, progress_shown, table
from mechstyle.cli.options import MACHINE, READ_AS, Device, Json, Settings, Vertices, recipe_options
from mechstyle.records.mesh import STANDARD_VERTICES

if TYPE_CHECKING:
    from benchmarks.study.cells import Row
    from benchmarks.study.grids import Factors

app = typer.Typer(no_args_is_help=True, help="Run many cells and make a page of them; what was run before is only read.")

CROSSED = "What is crossed"


class SeveralWords(TyperCommand):
    """A command whose options for lists take all the words that follow: --models pen_holder wall_hook."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Repeat the option before each of its words."""
        lists = {flag for parameter in self.params if parameter.multiple for flag in parameter.opts}
        spread, flag = list[str](), ""
        for number, word in enumerate(args):
            if word.startswith("--"):
                flag = word if word in lists else ""
                spread.append(word)
            else:
                spread += [flag, word] if flag and args[number - 1] != flag else [word]
        return super().parse_args(ctx, spread)


def _crossed(option: str, words: str) -> Any:
    """An option for a list that is crossed with the others."""
    return typer.Option(option, help=words, rich_help_panel=CROSSED)


ASKED = "drop: the fall alone; load: also the load of a model's use at 0.85 of what the plain part carries; deep: relief half the wall deep"
Words = list[str] | None
Models = Annotated[Words, _crossed("--models", f"Gallery models or files, one after the other; by default all of the gallery. {READ_AS}")]
Styles = Annotated[Words, _crossed("--styles", "Prompts; by default the six of the published study.")]
Controls = Annotated[Words, _crossed("--controls", "By default linear, exponential and frozen.")]
Schedules = Annotated[Words, _crossed("--schedules", "By default every, exponential, geometry and stress.")]
OF_ARMS = "freestyle, static, one-factor, finish-first, masks, strengthened; by default all but the last."
Arms = Annotated[Words, _crossed("--arms", OF_ARMS)]
Conditions = Annotated[Words, _crossed("--conditions", f"{ASKED}. By default all.")]
Seeds = Annotated[list[int] | None, _crossed("--seeds", "Seeds of the style; by default 0.")]
Out = Annotated[Path, typer.Option("--out", help="Folder for rows and runs; the same command goes on where it stopped.")]
Jobs = Annotated[int, typer.Option(min=1, max=256, help="Processes side by side on this machine.", rich_help_panel=MACHINE)]
Scheduler = Annotated[
    str, typer.Option(help="Address or file of a Dask scheduler, whose workers then run the cells.", rich_help_panel=MACHINE)
]
OnlyPart = Annotated[str, typer.Option("--only", help="One of calibration, sensitivity, free, ways; by default all in this order.")]
Tetrahedra = Annotated[int, typer.Option(min=500, max=400_000, help="About how many a part is filled with.")]
TETRAHEDRA = 28_000
"""Of a part, on average, in the published study."""
Iterations = Annotated[int, typer.Option(min=1, help="Stylization iterations.")]
shared = recipe_options("iterations", "material", "height", "tolerance", "orientations", "criterion", begins=False, others=True)


@app.command("formative", cls=SeveralWords)
@command
@shared
def formative_command(
    settings: Settings, models: Models = None, styles: Styles = None, seeds: Seeds = None, folder: Out = Path("study-formative"),
    jobs: Jobs = 1, scheduler: Scheduler = "", vertices: Vertices = STANDARD_VERTICES, device: Device = "auto", as_json: Json = False,
) -> None:  # fmt: skip
    """How often a part passes with a style alone: every model in every style, without feedback."""
    crossed = {"models": models, "styles": styles, "seeds": seeds}
    _carried_out("formative", _factors(crossed, settings, vertices, device), folder, jobs, scheduler, as_json=as_json)


@app.command("evaluation", cls=SeveralWords)
@command
@shared
def evaluation_command(
    settings: Settings, models: Models = None, styles: Styles = None, controls: Controls = None, schedules: Schedules = None,
    seeds: Seeds = None, folder: Out = Path("study-evaluation"), jobs: Jobs = 1, scheduler: Scheduler = "",
    vertices: Vertices = STANDARD_VERTICES, device: Device = "auto", as_json: Json = False,
) -> None:  # fmt: skip
    """Every control with every schedule, on every model in every style, beside the style alone."""
    crossed = {"models": models, "styles": styles, "seeds": seeds, "controls": controls, "schedules": schedules}
    _carried_out("evaluation", _factors(crossed, settings, vertices, device), folder, jobs, scheduler, as_json=as_json)


@app.command("ablation", cls=SeveralWords)
@command
@shared
def ablation_study_command(
    settings: Settings, models: Models = None, styles: Styles = None, arms: Arms = None, conditions: Conditions = None, seeds: Seeds = None,
    folder: Out = Path("study-ablation"), jobs: Jobs = 1, scheduler: Scheduler = "", vertices: Vertices = STANDARD_VERTICES,
    device: Device = "auto", as_json: Json = False,
) -> None:  # fmt: skip
    """What each mechanism is worth: arms with some taken away, dropped, under the load of their use, and with deep relief."""
    crossed = {"models": models, "styles": styles, "seeds": seeds, "arms": arms, "conditions": conditions}
    _carried_out("ablation", _factors(crossed, settings, vertices, device), folder, jobs, scheduler, as_json=as_json)


@app.command("published", cls=SeveralWords)
@command
def published_command(
    models: Models = None, styles: Styles = None, folder: Out = Path("study-published"), part: OnlyPart = "", jobs: Jobs = 1,
    scheduler: Scheduler = "", vertices: Vertices = STANDARD_VERTICES, tetrahedra: Tetrahedra = TETRAHEDRA, iterations: Iterations = 200,
    device: Device = "auto", as_json: Json = False,
) -> None:  # fmt: skip
    """The published study by its own rule: calibration of the floor, what moves the share, the formative study, the twelve ways."""
    from benchmarks.study.published import PARTS, factors_of  # noqa: PLC0415 — physics is loaded when something is run

    for name in (part,) if part else PARTS:
        factors = factors_of(name, models, styles, vertices=vertices, tetrahedra=tetrahedra, iterations=iterations, device=device)
        _carried_out(PARTS[name].study, factors, folder / name, jobs, scheduler, as_json=as_json)


@app.command("page")
@command
def page_command(
    sources: Annotated[list[Path], typer.Argument(metavar="SOURCE...", help="Folders of studies, or tables that were made of them.")],
    page: Annotated[Path, typer.Option("--out", help="Page to write; figures and table go beside it.")] = Path("study.md"),
    words: Annotated[str, typer.Option("--note", help="A sentence on where the runs come from, for the top of the page.")] = "",
    as_json: Json = False,
) -> None:
    """Make a page of studies: counts with intervals, figures, and the table it is made from."""
    from benchmarks.study.cells import read_table  # noqa: PLC0415
    from benchmarks.study.page import write_page  # noqa: PLC0415 — figures are loaded when wanted

    files = write_page([row for source in sources for row in read_table(source)], page, note=words)
    if as_json:
        print_json({"files": files})
    else:
        _print_rest((), files)


def _factors(crossed: dict[str, Any], settings: Settings, vertices: int, device: str) -> Factors:
    """What was asked for; what was not is left to the study."""
    from benchmarks.study.grids import Factors  # noqa: PLC0415 — physics is loaded when something is run

    own = {name: settings.pop(name) for name in ("iterations",) if name in settings}
    given = {name: value for name, value in crossed.items() if value is not None}
    return Factors(**given, **own, vertices=vertices, device=device, settings=settings)


def _carried_out(study: str, factors: Factors, folder: Path, jobs: int, scheduler: str, *, as_json: bool) -> None:
    """Walk over the cells, then keep the table and print what came of them."""
    from benchmarks.study.cells import write_table  # noqa: PLC0415
    from benchmarks.study.figures import wilson  # noqa: PLC0415
    from benchmarks.study.grids import cells_of  # noqa: PLC0415 — as above
    from benchmarks.study.walk import walk  # noqa: PLC0415

    cells = cells_of(study, factors)
    with progress_shown(len(cells), quiet=as_json) as teller:
        teller.stage("running")
        rows = walk(cells, folder, jobs=jobs, scheduler=scheduler, tell=lambda row: teller.step(escape(brief(row))))
    files = {"rows": str(folder / "rows"), "table": str(write_table(rows, folder / "table"))}
    if as_json:
        print_json({"rows": rows, "files": files})
    else:
        counts = table("condition", "arm", "runs", "passes", "95 % interval", "sure", "kept", "CPU s")
        for condition, arm in dict.fromkeys((row.condition, row.arm) for row in rows):
            done = [row for row in rows if (row.condition, row.arm, row.status) == (condition, arm, "done")]
            if done:
                passes, sure = sum(row.passes for row in done), sum(row.sure for row in done)
                low, high = wilson(passes, len(done))
                kept, seconds = median(row.kept for row in done), median(row.cpu_seconds for row in done)
                figures = (str(len(done)), str(passes), f"{low:.0%} to {high:.0%}", str(sure), f"{kept:.2f}", f"{seconds:.0f}")
                counts.add_row(condition, arm, *figures)
        out.print(counts)
        _print_rest(rows, files)
    if all(row.status == "refused" for row in rows):
        raise SystemExit(EXIT_BAD_INPUT)


def _print_rest(rows: Sequence[Row], files: dict[str, str]) -> None:
    """What did not run, and where the files are."""
    for row in rows:
        if row.status != "done":
            out.print(f"[yellow]{row.status}:[/] {escape(brief(row))}")
    for what, path in files.items():
        out.print(f"{what}: {escape(path)}")


def brief(row: Row) -> str:
    """One run in a line: its part, style, condition and arm, and what came of it."""
    return f"{row.part} as {row.prompt!r}, {row.condition}, {row.arm}: {row.refused or row.outcome}"


if __name__ == "__main__":
    app()
