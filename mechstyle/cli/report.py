"""Commands that write what one gives away or projects: report, film."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechstyle.cli.console import command, escape, out, print_json, telling
from mechstyle.cli.options import Json

app = typer.Typer()


@app.command("report")
@command
def report_command(
    address: Annotated[str, typer.Argument(metavar="DIR", help="A run directory: DIR, or DIR@lane.")],
    path: Annotated[Path | None, typer.Option("--out", help="HTML file to write; by default in the run directory.")] = None,
    impact: Annotated[
        bool, typer.Option("--impact", help="Drop the part once more, flat and in its hardest other landing, to play both in the report.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Write a report as one HTML file that opens offline: verdict, replay, timeline, settings, how to make it again."""
    from mechstyle.runs.run import Run  # noqa: PLC0415 — loaded when wanted

    run = Run.open(address, "cpu")
    written = run.report(path or run.store.root / f"{run.record.stem}-{run.lane}.html", impact=impact)
    if as_json:
        print_json({"lane": run.lane, "files": {"report": str(written)}})
        return
    out.print(escape(str(written)))


@app.command("film")
@command
def film_command(
    addresses: Annotated[list[str], typer.Argument(metavar="DIR...", help="Finished runs of one part: DIR, or DIR@lane; up to four.")],
    path: Annotated[Path, typer.Option("--out", help="GIF file to write.")] = Path("fall.gif"),
    plain: Annotated[bool, typer.Option(help="Let the part without a style fall first.")] = True,
    frames: Annotated[int, typer.Option(help="Moments from first touch on, 8 to 120.")] = 36,
    size: Annotated[int, typer.Option(help="Width of each picture [pixels], 160 to 800.")] = 360,
    as_json: Json = False,
) -> None:
    """Film the flat fall of one or more runs next to each other, in slow motion with rising stress, as a GIF to project."""
    from mechstyle.runs.film import film  # noqa: PLC0415 — loaded when wanted
    from mechstyle.runs.run import Run  # noqa: PLC0415

    runs = [Run.open(address, "cpu") for address in addresses]
    with telling(1, quiet=as_json) as teller:
        teller.stage("filming")
        written = film(runs, path, plain=plain, frames=frames, size=size, progress=teller.fraction)
    if as_json:
        print_json({"lanes": [run.lane for run in runs], "files": {"film": str(written)}})
        return
    out.print(escape(str(written)))
