"""Commands that style a part: run, freestyle, branch."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mechstyle.cli.console import command, err, escape, out, print_json, progress_shown, report_verdict, say_once, warn_once
from mechstyle.cli.options import (
    DEFAULTS_MAY_CHANGE,
    Details,
    Device,
    Folder,
    Json,
    Model,
    Quick,
    RunVertices,
    Settings,
    reads_a_part,
    recipe_options,
)
from mechstyle.records.landings import STANDARDS
from mechstyle.records.mesh import QUICK_VERTICES, STANDARD_VERTICES, check_vertices
from mechstyle.records.recipe import OF_FEEDBACK, OPTIONS

if TYPE_CHECKING:
    from mechstyle.runs.summary import Summary
    from mechstyle.simulation.part import Model as Opened

FREE = tuple(name for name in OPTIONS if name not in OF_FEEDBACK)

app = typer.Typer()


def read_model(model: str | Opened, reading: Settings, *, quiet: bool) -> tuple[Any, str]:
    """The mesh and the name of a model given on the command line, or at hand; its size and repairs are reported on stderr."""
    from mechstyle.gallery import PREFIX, load  # noqa: PLC0415 — geometry is loaded when a model is wanted

    if isinstance(model, str) and not quiet and not model.startswith(PREFIX):
        err.print(f"[dim]reading {escape(model)}[/]")
    mesh = load(model, **reading) if isinstance(model, str) else model
    if not quiet:
        for note in mesh.notes:
            err.print(f"[dim]{escape(mesh.origin.model)}: {escape(note)}[/]")
    return mesh, mesh.name


def carry_out(
    model: str | Opened,
    settings: Settings,
    vertices: int | None,
    reading: Settings,
    device: str,
    folder: Path | None,
    *,
    freestyle: bool,
    as_json: bool,
    quick: bool = False,
    said: set[str] | None = None,
) -> Any:
    """Run a stylization with progress; the finished run, its part exported and pictured. What was said of it is added to `said`."""
    from mechstyle.fea.drop import resolve_device  # noqa: PLC0415 — physics is loaded when something is run
    from mechstyle.runs.recipes import expected, idle, recipe_for  # noqa: PLC0415
    from mechstyle.runs.run import Draft  # noqa: PLC0415
    from mechstyle.simulation.estimate import estimated  # noqa: PLC0415
    from mechstyle.styling.prompt import reading_of  # noqa: PLC0415

    vertices = (QUICK_VERTICES if quick else STANDARD_VERTICES) if vertices is None else check_vertices(vertices)
    wanted = recipe_for(**settings, freestyle=freestyle)
    device = resolve_device(device)
    said = set() if said is None else said
    read = None if wanted.style.stylizer or wanted.style.guidance != "offline" else reading_of(wanted)
    if not as_json:
        warn_once((*expected(wanted), *idle(settings, wanted)), said)
        say_once(() if read is None else (f"prompt read as {read.words}", *read.notes), said)
    mesh, name = read_model(model, reading, quiet=as_json)
    if not as_json and device == "cpu":
        err.print(f"[dim]{escape(estimated(wanted, vertices).words)}[/]")
    with progress_shown(wanted.schedule.iterations, quiet=as_json, said=said) as teller:
        with nullcontext() if folder is None else _interruptible(folder):
            asked = Draft(wanted, mesh, vertices, name, folder, device, beside=False)
            run = asked.ready(stage=teller.stage, warn=teller.warn, shown=teller.shown).begin()
        return finish(run, teller)


def finish(run: Any, teller: Any) -> Any:
    """Carry a run on to its end, then export and picture the part."""
    from mechstyle.simulation.part import bounds_for  # noqa: PLC0415 — physics is loaded when something is run

    teller.say((*run.part.notes, *bounds_for(run.part, run.recipe)[1]))
    teller.stage("simulating the unstylized part")
    with _interruptible(run.store.root):
        run.go(teller.event, teller.fraction)
    teller.stage("writing files")
    stem = f"{run.record.stem}-{run.lane}"
    model = run.store.root / f"{stem}.3mf"
    written = run.exported(model)
    notes = (*written.quality.warnings, written.printing.words)
    teller.said.add(written.printing.words)  # `export` says it, with what would cost less
    run.add_files({"model": model, "picture": run.show().save(run.store.root / f"{stem}.png")}, notes)
    return run


@contextmanager
def _interruptible(folder: Path) -> Iterator[None]:
    """Have who ends a run know what is left of it in its folder."""
    from mechstyle.loop.store import Store  # noqa: PLC0415

    try:
        yield
    except KeyboardInterrupt as interrupt:
        store = Store(folder)
        kept = "what was checkpointed is kept, and the same command goes on from there"
        begun = "main" in store.lanes() and bool(store.history("main"))
        raise KeyboardInterrupt(f"interrupted; {kept if begun else 'nothing was saved yet'}") from interrupt


NOTES = 3
"""Most notes below a result; the others stand in --details."""
ENOUGH = 0.9
"""Share of the base on the floor, and of the relief that the mesh follows, from which on nothing is said of either."""


def report(run: Any, *, as_json: bool, details: bool = False, said: Collection[str] = ()) -> None:
    """Print what a run came to: its verdict, what is left of the style, and the notes that were not said while it ran."""
    summary, test = run.summary, run.recipe.test
    if as_json:
        print_json(summary)
        return
    if details:
        _report_details(summary)
    elif "model" in summary.files:
        out.print(f"3MF: {escape(summary.files['model'])}")
    report_verdict(run.verdict, details=details)
    out.print(f"style kept {summary.kept:.0%}")
    if test.layers_judged:
        out.print(escape(test.layers_judged))
    if test.after_standard:
        out.print(f"{escape(test.after_standard)}. {escape(STANDARDS[test.standard].departs)}")
    if run.part.mass_gained:
        out.print(f"the plain part is the thickened one, {run.part.mass_gained:+.1f} g")
    notes = list(dict.fromkeys(note for note in (*_shortcomings(summary), *summary.notes) if note not in said))
    shown = notes if details or len(notes) <= NOTES else notes[: NOTES - 1]
    for note in shown:
        out.print(f"[dim]note: {escape(note)}[/]")
    if len(shown) < len(notes):
        out.print(f"[dim]{len(notes) - len(shown)} more notes with --details[/]")


def _shortcomings(summary: Summary) -> Iterator[str]:
    """What the mesh or the base of the tested part lacks."""
    if summary.level_share is not None and summary.level_share < ENOUGH:
        yield f"only {summary.level_share:.0%} of its base touches the floor"
    if summary.carried < ENOUGH:
        yield f"the mesh follows only {summary.carried:.0%} of the relief"


def _report_details(summary: Summary) -> None:
    """Print figures that few need."""
    if summary.level_share is not None:
        out.print(f"{summary.level_share:.0%} of its base touches the floor")
    out.print(f"the mesh follows {summary.carried:.0%} of the relief ({escape(summary.meshing)})")
    out.print(f"style loss {summary.style_loss_ratio:.1%} of its start")
    out.print(f"simulations: {len(summary.simulations)}")
    out.print("seconds: " + ", ".join(f"{stage} {value:.1f}" for stage, value in summary.seconds.items()))
    for what, path in summary.files.items():
        out.print(f"{what}: {escape(path)}")


@app.command("run", epilog=DEFAULTS_MAY_CHANGE)
@command
@reads_a_part
@recipe_options(*OPTIONS, others=True, short=True)
def run_command(
    model: Model,
    settings: Settings,
    reading: Settings,
    quick: Quick = False,
    vertices: RunVertices = None,
    device: Device = "auto",
    folder: Folder = None,
    details: Details = False,
    as_json: Json = False,
) -> None:
    """Style a part while a drop test watches its strength."""
    said = set[str]()
    run = carry_out(model, settings, vertices, reading, device, folder, freestyle=False, quick=quick, as_json=as_json, said=said)
    report(run, as_json=as_json, details=details, said=said)


@app.command("freestyle", epilog=DEFAULTS_MAY_CHANGE)
@command
@reads_a_part
@recipe_options(*FREE, others=True, short=True)
def freestyle_command(
    model: Model,
    settings: Settings,
    reading: Settings,
    quick: Quick = False,
    vertices: RunVertices = None,
    device: Device = "auto",
    folder: Folder = None,
    details: Details = False,
    as_json: Json = False,
) -> None:
    """Style a part without feedback; one drop test at the end."""
    said = set[str]()
    run = carry_out(model, settings, vertices, reading, device, folder, freestyle=True, quick=quick, as_json=as_json, said=said)
    report(run, as_json=as_json, details=details, said=said)


@app.command("branch")
@command
@recipe_options(*(name for name in OPTIONS if name != "strengthen"), begins=False, others=True)
def branch_command(
    address: Annotated[str, typer.Argument(metavar="DIR@ITERATION", help="Where to branch: DIR@120 or DIR@lane:120.")],
    settings: Settings,
    lane: Annotated[str, typer.Option(help="Name of the new lane.")] = "",
    device: Device = "auto",
    details: Details = False,
    as_json: Json = False,
) -> None:
    """Go on from a checkpoint with other settings, in a new lane of the same run directory."""
    from mechstyle.loop.store import parse_address  # noqa: PLC0415
    from mechstyle.runs.recipes import idle  # noqa: PLC0415 — physics is loaded when something is run
    from mechstyle.runs.run import Run  # noqa: PLC0415

    root, origin, iteration = parse_address(address)
    run, said = Run.open(f"{root}@{origin}", device).branch(iteration, lane=lane, **settings), set[str]()
    with progress_shown(run.recipe.schedule.iterations, quiet=as_json, said=said) as teller:
        teller.warn(idle(settings, run.recipe))
        finish(run, teller)
    report(run, as_json=as_json, details=details, said=said)
