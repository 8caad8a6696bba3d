"""Commands that look into run directories: log, show, export."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mechstyle.cli.console import command, err, escape, out, print_json, table, verdict_text
from mechstyle.cli.options import Json
from mechstyle.errors import BadInput, unknown
from mechstyle.loop.store import Store, parse_address
from mechstyle.records import sentences

if TYPE_CHECKING:
    from mechstyle.loop.history import LaneSummary
    from mechstyle.runs.export import Exported

app = typer.Typer()

Address = Annotated[
    str, typer.Argument(metavar="DIR@ITERATION", help="A run directory and an iteration: DIR@120, DIR@lane:120; DIR for the last.")
]


FORMATS = ("3mf", "glb", "obj", "ply", "stl")

OF_PRINTING = partial(typer.Option, rich_help_panel="Printing in colour (3MF)")


@app.command("log")
@command
def log_command(
    address: Annotated[str, typer.Argument(metavar="DIR", help="A run directory: DIR, or DIR@lane for one lane.")], as_json: Json = False
) -> None:
    """List the lanes of a run directory and what was simulated in each, and why."""
    from mechstyle.loop.history import LaneSummary  # noqa: PLC0415 — loaded when wanted

    directory, wanted, iteration = parse_address(address)
    if iteration is not None:
        raise BadInput(f"{address} names an iteration, but a log lists whole lanes: give {directory}@{wanted} or {directory}")
    store = Store.open(directory)
    named = (wanted,) if directory != Path(address) else store.lanes()
    lanes = [LaneSummary.of(store, name, store.history(name)) for name in named]
    if as_json:
        print_json({"directory": str(directory), "lanes": lanes})
        return
    for lane in lanes:
        rows = table("iteration", "outcome", "in the worst test", "reason", title=lane_title(lane))
        for line in lane.simulations:
            outcome = verdict_text(line.outcome, sure=line.sure)
            figures = "–" if line.stress is None else f"{line.stress:.1f} of {line.limit:.1f} MPa"
            if line.permanent_set is not None and line.allowed is not None:
                figures = f"{sentences.bend(line.permanent_set)} of {sentences.bend(line.allowed)}"
            rows.add_row(str(line.iteration), outcome, figures, escape(line.reason))
        out.print(rows)
        out.print()


def lane_title(lane: LaneSummary) -> str:
    """Title of a lane's table: name, prompt, settings and where it stands."""
    recipe = lane.recipe
    state = "finished" if lane.finished else f"stands at iteration {lane.iteration} of {recipe.schedule.iterations}"
    fork = "" if lane.forked_at is None else f", branched at {lane.forked_at}"
    how = f"{recipe.test.material.name}, {recipe.restraint.control} control, {recipe.schedule.when} schedule"
    return f"[bold]{lane.lane}[/]: “{escape(recipe.style.prompt)}” in {how}; {state}{fork}"


@app.command("show")
@command
def show_command(
    address: Address,
    picture: Annotated[Path | None, typer.Option("--out", help="PNG to write; by default beside the run's objects.")] = None,
    fields: Annotated[
        list[str] | None,
        typer.Option(
            "--field",
            help="Show this instead of stress and mask: stays_bent, demand, contact, thickness, stress_NAME of a test, …;"
            " may be given several times.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Picture of a checkpoint: styled, stress of the test that decides, mask, or other fields, side by side."""
    from mechstyle.runs.run import Run  # noqa: PLC0415 — loaded when wanted

    root, lane, iteration = parse_address(address)
    run = Run.open(f"{root}@{lane}", "cpu")
    state = run.checkpoint(iteration)
    which = "".join(f"-{name}" for name in fields or ())
    path = run.show(iteration, fields=fields or ()).save(picture or root / f"{run.record.stem}-{lane}-{state.iteration}{which}.png")
    if as_json:
        document = {name: getattr(state, name) for name in ("iteration", "reason", "verdict", "style_loss", "simulated_at")}
        print_json({**document, "lane": lane, "files": {"picture": str(path)}})
        return
    row = None if state.verdict is None else state.verdict.deciding
    if state.verdict is not None:
        figures = "" if row is None else f"  {escape(sentences.figures(row))}"
        out.print(f"{verdict_text(state.verdict.outcome, sure=state.verdict.sure)}{figures}")
    out.print(escape(str(path)))


def chosen_format(form: str | None, path: Path | None) -> str:
    """The format that was named, or that of the file; BadInput if there is no such format or the two contradict each other."""
    suffix = "" if path is None else path.suffix.lower().lstrip(".")
    named = (form or suffix or "3mf").lower().lstrip(".")
    if named not in FORMATS:
        raise unknown("format", named, FORMATS)
    if path is not None and suffix and named != suffix:
        other = path.with_suffix(f".{named}").name
        raise BadInput(f"--format {named} contradicts --out {path}: leave --format out, or call the file {other}")
    return named


@app.command("export")
@command
def export_command(
    address: Address,
    form: Annotated[
        str | None, typer.Option("--format", "-f", help=f"One of {', '.join(FORMATS)}; that of the file, else 3mf, by default.")
    ] = None,
    path: Annotated[Path | None, typer.Option("--out", help="File to write; by default in the run directory.")] = None,
    fields: Annotated[
        bool,
        typer.Option("--fields", help="With stress, demand and all other known fields at its vertices, for Blender, ParaView: GLB, PLY."),
    ] = False,
    slicer: Annotated[str, OF_PRINTING(help="Whose 3MF it is: standard or prusa (one strict file), bambu or orca (another).")] = "standard",
    palette: Annotated[str, OF_PRINTING(help='Filaments in the printer, slot 1 first: "#111111, #f4f1e8".')] = "",
    colours: Annotated[int | None, OF_PRINTING(help="How many filaments to choose instead, 1 to 16; the prompt's, or 2.")] = None,
    bands: Annotated[bool, OF_PRINTING("--bands", help="Filaments one above the other: as good as no changes.")] = False,
    bodies: Annotated[bool, OF_PRINTING("--bodies", help="A styled shell and the rest as two bodies, unpainted.")] = False,
    as_json: Json = False,
) -> None:
    """Write the surface of a checkpoint to a file, with its colours where the format can hold them, and say what to look at."""
    from mechstyle.runs.export import sidecar  # noqa: PLC0415 — loaded when wanted
    from mechstyle.runs.printing import Printing  # noqa: PLC0415
    from mechstyle.runs.run import Run  # noqa: PLC0415

    chosen = chosen_format(form, path)
    root, lane, iteration = parse_address(address)
    run = Run.open(f"{root}@{lane}", "cpu")
    number = run.store.find(iteration, lane).iteration
    place = path or root / f"{run.record.stem}-{lane}-{number}.{chosen}"
    printing = Printing(slicer=slicer, palette=palette, colours=colours, bands=bands, bodies=bodies)
    replaced = path is None and place.exists()
    written = run.exported(place, iteration, fields=fields, printing=printing)
    if replaced and not as_json:
        err.print(f"[dim]{escape(str(place))} was there and is replaced; --out writes to another file[/]")
    if as_json:
        print_json({"export": written, "files": {"model": str(place), "quality": str(sidecar(place))}})
        return
    report_export(place, written)


def report_export(place: Path, written: Exported) -> None:
    """Print what was written, and what is known of that very surface."""
    q, verdict = written.quality, written.verdict
    rows = table(str(place), "before", "written")
    rows.add_row("outcome", "", "not simulated" if verdict is None else verdict_text(verdict.outcome, sure=verdict.sure))
    if verdict is not None and verdict.deciding is not None:
        rows.add_row("worst test", "", escape(sentences.figures(verdict.deciding)))
    rows.add_row("folded faces", "", str(q.folds))
    rows.add_row("crossing pairs of faces", str(q.crossings_before), str(q.crossings))
    rows.add_row("thinnest wall two lines wide, mm", f"{q.thinnest_before:.2f}", f"{q.thinnest:.2f}")
    rows.add_row("1 % of the surface is thinner than, mm", f"{q.thin_before:.2f}", f"{q.thin:.2f}")
    rows.add_row("mass as printed, g", f"{q.mass - q.mass_change:.1f}", f"{q.mass:.1f} ({q.volume_change:+.1%})")
    out.print(rows)
    if (plan := written.printing) is not None:  # what the print costs, which filaments the file names, and what would cost less
        out.print(f"{plan.cost.words} [dim](estimate, of a changer with one nozzle: docs/printing.md)[/]")
        slots = ", ".join(f"[{colour}]██[/] {slot} {colour}" for slot, colour in enumerate(plan.palette, 1))
        out.print(f"filaments: {slots}")
        if plan.merged:
            out.print(f"[dim]{plan.merged} islands of colour narrower than two lines of plastic went to their neighbours[/]")
        for offer in plan.offers:
            bands = len(offer.palette) == len(plan.palette)
            how = "--bands" if bands else f'--palette "{",".join(offer.palette)}"'
            count = f"about {offer.changes}" if bands else offer.changes  # what the teeth of a border meet is a matter of luck
            out.print(f"[dim]fewer changes:[/] {count} with {how}")
    for warning in written.warnings:
        out.print(f"[yellow]warning:[/] {escape(warning)}")
