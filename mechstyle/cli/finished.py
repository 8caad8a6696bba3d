"""Commands on finished runs: rerun, gc, orient, report, film."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from mechstyle.cli.console import command, escape, out, print_json, progress_shown, table
from mechstyle.cli.options import Device, Json
from mechstyle.errors import BadInput
from mechstyle.gallery import PREFIX
from mechstyle.loop.store import Store, parse_address
from mechstyle.records import sentences

app = typer.Typer()

EXIT_DIFFERS = 1


@app.command("rerun")
@command
def rerun_command(
    address: Annotated[str, typer.Argument(metavar="DIR", help="A run directory: DIR, or DIR@lane.")],
    folder: Annotated[Path | None, typer.Option("--out", help="Where the repetition goes; DIR-again by default.")] = None,
    device: Device = "cpu",
    as_json: Json = False,
) -> None:
    """Repeat a run from its recipe and its own tetrahedra, and say whether it comes to the same; exit code 1 if it does not."""
    from mechstyle.runs.rerun import rerun  # noqa: PLC0415 — physics is loaded when something is run
    from mechstyle.runs.run import Run  # noqa: PLC0415

    run = Run.open(address, device)
    root = run.store.root.resolve()
    with progress_shown(run.recipe.schedule.iterations, quiet=as_json) as teller:
        found = rerun(run, folder or root.with_name(f"{root.name}-again"), teller.event)
    if as_json:
        print_json({**{name: getattr(found, name) for name in found.__struct_fields__}, "equal": found.equal})
    else:
        out.print(escape(found.words))
        for one in found.differences:
            unit = "MPa" if one.test == "published rule" else "mm"
            figures = f"{one.test}: {one.before:.6g} {unit}, again {one.again:.6g} {unit}"
            out.print(f"  iteration {one.iteration}: {one.verdict}, again {one.verdict_again}; {escape(figures)}")
        out.print(f"[dim]the repetition is in {escape(found.folder)}[/]")
    if not found.equal:
        raise SystemExit(EXIT_DIFFERS)


@app.command("gc")
@command
def gc_command(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="A run directory.")],
    remove: Annotated[bool, typer.Option("--remove", help="Remove it; without this it is only listed.")] = False,
    as_json: Json = False,
) -> None:
    """List what no lane of a run directory reaches, and remove it if asked to."""
    from mechstyle.loop.garbage import collect, garbage  # noqa: PLC0415 — loaded when wanted

    root, _, _ = parse_address(str(directory))
    store = Store.open(root)
    found = collect(store) if remove else garbage(store)
    counts = {"objects": len(found.objects), "results": len(found.memo), "scraps": len(found.scraps)}
    if as_json:
        print_json({"directory": str(root), **counts, "bytes": found.size, "kept_bytes": found.kept, "removed": remove})
        return
    what = ", ".join(f"{count} {name}" for name, count in counts.items())
    done = "removed" if remove else "could go"
    out.print(f"{what}: {found.size / 1e6:.1f} MB {done}, {found.kept / 1e6:.1f} MB {'left' if remove else 'would stay'}")
    if not remove and found.files:
        out.print(f"[dim]remove it with: mechstyle gc {escape(shlex.quote(str(root)))} --remove[/]")


@app.command("orient")
@command
def orient_command(
    address: Annotated[str, typer.Argument(metavar="DIR@ITERATION", help="A run directory: DIR, DIR@120 or DIR@lane:120.")],
    count: Annotated[int, typer.Option(help="Ways up to compare, at most.")] = 6,
    device: Device = "auto",
    as_json: Json = False,
) -> None:
    """Rank ways up to print a part by what stays bent of it with such layers, by overhang and by height."""
    from mechstyle.runs.orient import ALIKE, LITTLE, ways_up  # noqa: PLC0415 — loaded when wanted
    from mechstyle.runs.run import Run  # noqa: PLC0415

    if address.startswith(PREFIX) or Path(address).is_file():
        first = f"`mechstyle run {address} --prompt … --out DIR` first, then `mechstyle orient DIR`"
        raise BadInput(f"{address} is a model, and ways up are ranked by the drop tests of a run: {first}")
    root, lane, iteration = parse_address(address)
    run = Run.open(f"{root}@{lane}", device)
    with progress_shown(1, quiet=as_json) as teller:
        found = ways_up(run, iteration, count=count, stage=teller.stage, progress=teller.fraction)
    if as_json:
        print_json(found)
        return
    rows = table("way up", "up", "stays bent", "of what is allowed", "overhang, cm²", "height, mm", "on the bed, cm²")
    for way in found.ways:
        bent = "not known" if way.permanent_set is None else sentences.bend(way.permanent_set)
        used = "–" if way.used is None else f"{way.used:.0%}"
        up = ", ".join(f"{round(part, 2) + 0.0:g}" for part in way.up)
        rows.add_row(way.name, up, bent, used, f"{way.overhang / 100:.1f}", f"{way.height:.1f}", f"{way.base / 100:.1f}")
    out.print(rows)
    out.print(f"\n{escape(found.layers)}")
    alike = f"below {LITTLE + ALIKE:.0%} of what is allowed all count as alike, above it those in one tenth"
    then = f"then less overhang comes first, then less height; {found.drops} drop tests were run or recalled"
    out.print(f"[dim]{alike}; {then}. The part lands as before, only its layers lie otherwise.[/]")


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
    with progress_shown(1, quiet=as_json) as teller:
        teller.stage("filming")
        written = film(runs, path, plain=plain, frames=frames, size=size, progress=teller.fraction)
    if as_json:
        print_json({"lanes": [run.lane for run in runs], "files": {"film": str(written)}})
        return
    out.print(escape(str(written)))
