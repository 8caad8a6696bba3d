"""The command that shows what each mechanism is worth: ablation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mechstyle.cli.console import EXIT_BAD_INPUT, command, escape, out, print_json, table, telling
from mechstyle.cli.options import DROP_TEST, MACHINE, STYLE, Device, Json, Settings, Vertices, recipe_options
from mechstyle.records.mesh import STANDARD_VERTICES

if TYPE_CHECKING:
    from mechstyle.study.ablation import Ablation
    from mechstyle.study.cells import Row

app = typer.Typer()


@app.command("ablation")
@command
@recipe_options("iterations", "seed", "material", "height", "orientations", "poses", "loads", begins=False, others=True)
def ablation_command(
    models: Annotated[list[str], typer.Argument(metavar="MODEL...", help="Files (STL, OBJ, PLY, GLB, 3MF) or gallery:NAME.")],
    settings: Settings,
    prompts: Annotated[
        list[str] | None, typer.Option("--prompt", "-p", help="A style, in words. May be given several times.", rich_help_panel=STYLE)
    ] = None,
    conditions: Annotated[
        list[str] | None,
        typer.Option(
            "--condition",
            help="drop: the fall alone; load: also the load of a model's use, or of --load, at 0.85 of what the plain part carries; deep: "
            "relief half the wall deep. By default drop. May be given several times.",
            rich_help_panel=DROP_TEST,
        ),
    ] = None,
    arms: Annotated[
        list[str] | None,
        typer.Option("--arm", help="freestyle, static, finish-first or masks; by default all. May be given several times."),
    ] = None,
    jobs: Annotated[int, typer.Option(min=1, max=256, help="Processes side by side.", rich_help_panel=MACHINE)] = 1,
    vertices: Vertices = STANDARD_VERTICES,
    device: Device = "auto",
    folder: Annotated[Path, typer.Option("--out", help="Folder for rows and runs; the same command goes on where it stopped.")] = Path(
        "ablation"
    ),
    as_json: Json = False,
) -> None:
    """Stylize parts with mechanisms taken away, and count what each is worth."""
    from mechstyle.study.ablation import ablation  # noqa: PLC0415 — physics is loaded when something is run
    from mechstyle.study.grids import ARMS  # noqa: PLC0415

    wanted, under = prompts or ["brick"], conditions or ["drop"]
    with telling(len(models) * len(wanted) * len(under) * len(arms or ARMS), quiet=as_json) as teller:
        teller.stage("running")
        found = ablation(
            models, wanted, folder, conditions=under, arms=arms or list(ARMS), vertices=vertices, device=device, jobs=jobs,
            tell=lambda row: teller.step(escape(brief(row))), **settings,
        )  # fmt: skip
    files = found.save(folder)
    if as_json:
        print_json({"rows": list(found.rows), "files": files})
    else:
        _print(found, files)
    if all(row.status == "refused" for row in found.rows):
        raise SystemExit(EXIT_BAD_INPUT)


def brief(row: Row) -> str:
    """One run in a line: its part, style, condition and arm, and what came of it."""
    return f"{row.part} as {row.prompt!r}, {row.condition}, {row.arm}: {row.refused or row.outcome}"


def _print(found: Ablation, files: dict[str, str]) -> None:
    """The counts, what did not run, and where the files are."""
    headings, *lines = found.summary()
    rows = table(*headings)
    for line in lines:
        rows.add_row(*line)
    out.print(rows)
    for sentence in found.against_the_twin():
        out.print(escape(sentence))
    for row in found.rows:
        if row.status != "done":
            out.print(f"[yellow]{row.status}:[/] {escape(brief(row))}")
    for what, path in files.items():
        out.print(f"{what}: {escape(path)}")
