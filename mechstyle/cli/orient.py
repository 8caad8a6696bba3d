"""The command that ranks ways up to print a part: orient."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mechstyle.cli.console import command, escape, out, print_json, table, telling
from mechstyle.cli.options import Device, Json
from mechstyle.errors import BadInput
from mechstyle.gallery import PREFIX
from mechstyle.loop.store import parse_address

if TYPE_CHECKING:
    from mechstyle.runs.orient import WaysUp

app = typer.Typer()


@app.command("orient")
@command
def orient_command(
    address: Annotated[str, typer.Argument(metavar="DIR@ITERATION", help="A run directory: DIR, DIR@120 or DIR@lane:120.")],
    count: Annotated[int, typer.Option(help="Ways up to compare, at most.")] = 6,
    device: Device = "auto",
    as_json: Json = False,
) -> None:
    """Rank ways up to print a part by what its layers bear in the drop and under loads, by overhang and by height."""
    from mechstyle.runs.orient import ways_up  # noqa: PLC0415 — loaded when wanted
    from mechstyle.runs.run import Run  # noqa: PLC0415

    if address.startswith(PREFIX) or Path(address).is_file():
        first = f"`mechstyle run {address} --prompt … --out DIR` first, then `mechstyle orient DIR`"
        raise BadInput(f"{address} is a model, and ways up are ranked by the drop tests of a run: {first}")
    root, lane, iteration = parse_address(address)
    run = Run.open(f"{root}@{lane}", device)
    with telling(1, quiet=as_json) as teller:
        found = ways_up(run, iteration, count=count, stage=teller.stage, progress=teller.fraction)
    if as_json:
        print_json(found)
    else:
        report_ways(found)


def report_ways(found: WaysUp) -> None:
    """Print a table, the best way up first, and what is behind it."""
    rows = table("way up", "up", "stress, MPa", "of", "overhang, cm²", "height, mm", "on the bed, cm²")
    for way in found.ways:
        stress = "not known" if way.stress is None else f"{way.stress:.1f}"
        up = ", ".join(f"{round(part, 2) + 0.0:g}" for part in way.up)
        rows.add_row(way.name, up, stress, f"{way.limit:.1f}", f"{way.overhang / 100:.1f}", f"{way.height:.1f}", f"{way.base / 100:.1f}")
    out.print(rows)
    out.print(f"\n{escape(found.layers)}")
    alike = "stresses within a twentieth of the limit count as alike; then less overhang, then less height comes first"
    out.print(f"[dim]{alike}; the part lands as before, only its layers lie otherwise; {found.drops} drop tests were run or recalled[/]")
