"""Commands that style a part: run, freestyle, branch."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mechstyle.cli.console import command, err, escape, out, print_json, progress_shown, report_verdict
from mechstyle.cli.options import (
    DEFAULTS_MAY_CHANGE,
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
from mechstyle.records import sentences
from mechstyle.records.landings import STANDARDS
from mechstyle.records.mesh import QUICK_VERTICES, STANDARD_VERTICES
from mechstyle.records.recipe import OF_FEEDBACK, OPTIONS, Recipe

if TYPE_CHECKING:
    from mechstyle.simulation.estimate import Estimate
    from mechstyle.simulation.part import Model as Opened

AUTO = "auto"
"""In place of an amplitude: the deepest that passes."""
FREE = tuple(name for name in OPTIONS if name not in OF_FEEDBACK)

app = typer.Typer()


def read_model(model: str | Opened, reading: Settings, *, quiet: bool) -> tuple[Any, str]:
    """The mesh and the name of a model given on the command line, or at hand; its size and repairs are reported on stderr."""
    from mechstyle.gallery import load  # noqa: PLC0415 — geometry is loaded when a model is wanted

    mesh = load(model, **reading) if isinstance(model, str) else model
    if not quiet:
        for note in mesh.notes:
            err.print(f"[dim]{escape(mesh.origin.model)}: {escape(note)}[/]")
    return mesh, mesh.name


USUAL_TESTS = 5
"""Tests that a schedule has besides the last, in the middle of the runs of docs/why-these-defaults.md."""


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
) -> Any:
    """Run a stylization with progress; the finished run, its part exported and pictured."""
    from mechstyle.fea.drop import resolve_device  # noqa: PLC0415 — physics is loaded when something is run
    from mechstyle.runs.recipes import FREESTYLE, QUICK, draft, expected, idle  # noqa: PLC0415
    from mechstyle.runs.run import started  # noqa: PLC0415
    from mechstyle.styling.prompt import reading_of  # noqa: PLC0415

    if vertices is None:
        vertices = QUICK_VERTICES if quick else STANDARD_VERTICES
    settings = {**QUICK, **settings} if quick else settings
    deep = settings.get("amplitude") == AUTO
    wanted = draft(**{**settings, "amplitude": None} if deep else settings, freestyle=freestyle)
    device = resolve_device(device)
    if not as_json and not wanted.style.stylizer and wanted.style.guidance == "offline":
        read = reading_of(wanted)
        for note in (f"read as {read.words}", *read.notes):
            err.print(f"[dim]prompt: {escape(note)}[/]")
    if not as_json:
        for warning in (*expected(wanted), *idle(settings, wanted)):
            err.print(f"[yellow]warning:[/] {escape(warning)}")
    mesh, name = read_model(model, reading, quiet=as_json)
    if not as_json and not deep and device == "cpu":
        err.print(f"[dim]{escape(foretold(wanted, vertices).words)}[/]")
    limited: Sequence[str] = ()
    with progress_shown(wanted.schedule.iterations, quiet=as_json) as teller:
        if deep:
            tried = {**FREESTYLE, **settings} if freestyle else settings
            wanted, *limited = at_its_deepest(wanted, mesh, tried, vertices, device, folder, teller)
        run = started(
            wanted, mesh, vertices=vertices, out=folder, name=name, device=device, stage=teller.stage, warn=teller.warn, beside=False
        )
        if wanted.delivery.strengthen and not as_json:
            err.print(f"[dim]part: {escape(run.part.notes[-1])}[/]")
        if not as_json and device == "cpu" and not run.history:
            from mechstyle.simulation.estimate import before_the_first_fall  # noqa: PLC0415

            known = before_the_first_fall(run.simulator(run.recipe))
            err.print(f"[dim]{escape(sentences.measured_out(known.falls, known.seconds))}[/]")
        return finish(run, teller, limited)


def foretold(wanted: Recipe, vertices: int) -> Estimate:
    """The falls and the time of a run that has not begun, on this machine's processor."""
    from mechstyle.simulation.estimate import estimated  # noqa: PLC0415 — physics is loaded when something is run

    tests = 1 + (wanted.restraint.guarantee and wanted.schedule.when == "never") + (wanted.schedule.when != "never") * USUAL_TESTS
    return estimated(
        vertices, tests, height=wanted.test.height, iterations=wanted.schedule.iterations, orientations=wanted.test.orientations,
        nearly_flat=wanted.test.nearly_flat, hardest_only=wanted.test.hardest_only, rough=wanted.test.rough,
        element=wanted.test.element, window=wanted.test.window,
    )  # fmt: skip


def at_its_deepest(
    wanted: Recipe, mesh: Any, settings: Settings, vertices: int, device: str, folder: Path | None, teller: Any
) -> tuple[Recipe, str]:
    """A recipe with the deepest relief that passes, found by trials in a folder beside the run's, and what limits it, in words."""
    from mechstyle.runs.deepest import deepest  # noqa: PLC0415 — physics is loaded when something is run
    from mechstyle.runs.folders import default_folder  # noqa: PLC0415

    beside = folder or default_folder(wanted)
    trials = beside.with_name(f"{beside.name}-depths")
    found = deepest(mesh, **settings, vertices=vertices, device=device, stage=teller.stage, warn=teller.warn, out=trials)
    err.print(f"[dim]amplitude: {escape(found.words)}[/]")
    return wanted.with_settings(amplitude=found.amplitude), f"amplitude {AUTO}: {found.words}"


def finish(run: Any, teller: Any, known: Iterable[str] = ()) -> Any:
    """Carry a run on to its end, then export and picture the part; `known` is what its user should know besides, a sentence each."""
    teller.stage("simulating the unstylized part")
    run.go(teller.event, teller.fraction)
    teller.stage("writing files")
    stem = f"{run.record.stem}-{run.lane}"
    model = run.store.root / f"{stem}.3mf"
    written = run.exported(model)
    notes = (*known, *written.quality.warnings, written.printing.words)
    run.add_files({"model": model, "picture": run.show().save(run.store.root / f"{stem}.png")}, notes)
    return run


def report(run: Any, *, as_json: bool) -> None:
    """Print what a run came to; its verdict stands last."""
    summary = run.summary
    if as_json:
        print_json(summary)
        return
    for note in summary.notes:
        out.print(f"[dim]note: {escape(note)}[/]")
    if run.recipe.test.layers_judged:
        out.print(escape(run.recipe.test.layers_judged))
    if run.recipe.test.after_standard:
        out.print(f"{escape(run.recipe.test.after_standard)}. {escape(STANDARDS[run.recipe.test.standard].departs)}")
    if run.part.mass_gained:
        out.print(f"the plain part is the thickened one, {run.part.mass_gained:+.1f} g")
    if summary.level_share is not None:
        out.print(f"{summary.level_share:.0%} of its base touches the floor")
    out.print(f"the mesh follows {summary.carried:.0%} of the relief ({escape(summary.meshing)})")
    out.print("seconds: " + ", ".join(f"{stage} {value:.1f}" for stage, value in summary.seconds.items()))
    for what, path in summary.files.items():
        out.print(f"{what}: {escape(path)}")
    kept = f"style kept {summary.kept:.0%}; style loss {summary.style_loss_ratio:.1%} of its start"
    out.print(f"{kept}; {len(summary.simulations)} simulations\n")
    report_verdict(run.verdict)


@app.command("run", epilog=DEFAULTS_MAY_CHANGE)
@command
@reads_a_part
@recipe_options(*OPTIONS, others=True)
def run_command(
    model: Model,
    settings: Settings,
    reading: Settings,
    quick: Quick = False,
    vertices: RunVertices = None,
    device: Device = "auto",
    folder: Folder = None,
    as_json: Json = False,
) -> None:
    """Style a part while a drop test watches its strength."""
    run = carry_out(model, settings, vertices, reading, device, folder, freestyle=False, quick=quick, as_json=as_json)
    report(run, as_json=as_json)


@app.command("freestyle", epilog=DEFAULTS_MAY_CHANGE)
@command
@reads_a_part
@recipe_options(*FREE, others=True)
def freestyle_command(
    model: Model,
    settings: Settings,
    reading: Settings,
    quick: Quick = False,
    vertices: RunVertices = None,
    device: Device = "auto",
    folder: Folder = None,
    as_json: Json = False,
) -> None:
    """Style a part without feedback; one drop test at the end."""
    run = carry_out(model, settings, vertices, reading, device, folder, freestyle=True, quick=quick, as_json=as_json)
    report(run, as_json=as_json)


@app.command("branch")
@command
@recipe_options(*(name for name in OPTIONS if name != "strengthen"), begins=False, others=True)
def branch_command(
    address: Annotated[str, typer.Argument(metavar="DIR@ITERATION", help="Where to branch: DIR@120 or DIR@lane:120.")],
    settings: Settings,
    lane: Annotated[str, typer.Option(help="Name of the new lane.")] = "",
    device: Device = "auto",
    as_json: Json = False,
) -> None:
    """Go on from a checkpoint with other settings, in a new lane of the same run directory."""
    from mechstyle.loop.store import parse_address  # noqa: PLC0415
    from mechstyle.runs.run import Run  # noqa: PLC0415 — physics is loaded when something is run

    root, origin, iteration = parse_address(address)
    run = Run.open(f"{root}@{origin}", device).branch(iteration, lane=lane, **settings)
    with progress_shown(run.recipe.schedule.iterations, quiet=as_json) as teller:
        finish(run, teller)
    report(run, as_json=as_json)
