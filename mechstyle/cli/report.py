"""The command that writes a report to give away."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechstyle.cli.console import command, escape, out, print_json
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
