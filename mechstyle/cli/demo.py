"""Commands that stylize a part freely and with feedback, side by side: demo, application."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mechstyle.cli.console import command, err, escape, out, print_json, table, verdict_text
from mechstyle.cli.options import OPTIONS, Device, Json, Settings, Vertices, recipe_options
from mechstyle.cli.run import carry_out
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.records.recipe import described

if TYPE_CHECKING:
    from mechstyle.study.applications import Pair

app = typer.Typer()

DEMO_MODEL, DEMO_VERTICES = "gallery:tealight_holder", 3_000
"""Small and solid, and so few vertices, that the demo takes minutes on a laptop: with 25 000 it takes ten times as long."""


@app.command("demo")
@command
def demo_command(
    folder: Annotated[Path, typer.Option("--out", help="Where the runs, pictures and 3MF files go.")] = Path("demo-out"),
    model: Annotated[str, typer.Option(help="What to style.")] = DEMO_MODEL,
    prompt: Annotated[str, typer.Option(*OPTIONS["prompt"].flags, help=described("prompt"))] = "brick",
    device: Device = "auto",
    vertices: Vertices = DEMO_VERTICES,
    as_json: Json = False,
) -> None:
    """Style the gallery's tealight holder as brick, freely and with feedback, and compare the verdicts."""
    tell(both_ways(model, {"prompt": prompt}, vertices, device, folder, as_json=as_json), folder, as_json=as_json)


@app.command("application")
@command
@recipe_options("iterations", "orientations")
def application_command(
    name: Annotated[str, typer.Argument(metavar="[NAME]", help="Which; without it they are listed.")] = "",
    *,
    settings: Settings,
    folder: Annotated[Path | None, typer.Option("--out", help="Folder for runs, picture and table; applications/NAME by default.")] = None,
    vertices: Vertices = STANDARD_VERTICES,
    device: Device = "auto",
    as_json: Json = False,
) -> None:
    """Carry out an application of the published method, freely and with feedback, and compare the verdicts."""
    from mechstyle.study.applications import APPLICATIONS, application_named  # noqa: PLC0415 — physics is loaded when something is run

    if not name:
        rows = table("application", "model", "style", "what it asks for")
        for key, known in APPLICATIONS.items():
            rows.add_row(key, f"gallery:{known.model}", f"“{known.prompt}”", known.about)
        print_json({"applications": dict(APPLICATIONS)}) if as_json else out.print(rows)
        return
    chosen, where = application_named(name), folder or Path("applications") / name
    settings |= {"prompt": chosen.prompt, "protect": list(chosen.protect)}
    pair = both_ways(f"gallery:{chosen.model}", settings, vertices, device, where, as_json=as_json)
    tell(pair, where, as_json=as_json)


def both_ways(model: str, settings: Settings, vertices: int, device: str, folder: Path, *, as_json: bool) -> Pair:
    """Run a part freely and with feedback, with progress."""
    from mechstyle.study.applications import Pair  # noqa: PLC0415 — as above

    runs = []
    for label, freestyle in (("Freestyle", True), ("MechStyle", False)):
        if not as_json:
            err.print(f"[bold]{label}[/]: {escape(model)} as “{escape(settings['prompt'])}”")
        where = folder / label.lower()
        runs.append(carry_out(model, settings, vertices, None, "", device, where, freestyle=freestyle, as_json=as_json))
    return Pair(*runs)


def tell(pair: Pair, folder: Path, *, as_json: bool) -> None:
    """Write and print what the two runs came to."""
    from mechstyle.study.applications import COLUMNS  # noqa: PLC0415 — as above

    files = pair.save(folder)
    if as_json:
        print_json({"freestyle": pair.free.summary, "mechstyle": pair.fed.summary, "files": files})
        return
    rows = table(*COLUMNS)
    for label, verdict, *figures in pair.rows():
        outcome, _, close = verdict.partition(", ")
        rows.add_row(label, verdict_text(outcome, marginal=bool(close)), *figures)
    out.print(rows)
    for label, run in (("Freestyle", pair.free), ("MechStyle", pair.fed)):
        out.print(f"\n{label}: {escape(run.summary.words)}")
        out.print(f"  3MF: {escape(run.summary.files['model'])}")
        for note in run.summary.notes:
            out.print(f"  [dim]note: {escape(note)}[/]")
    out.print(f"\npicture: {escape(files['comparison'])}\ntable: {escape(files['table'])}")
