"""Commands that look after run directories: rerun, gc."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from mechstyle.cli.console import command, escape, out, print_json, telling
from mechstyle.cli.options import Device, Json
from mechstyle.loop.store import Store, parse_address

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
    with telling(run.recipe.schedule.iterations, quiet=as_json) as teller:
        found = rerun(run, folder or root.with_name(f"{root.name}-again"), teller.event)
    if as_json:
        print_json({**{name: getattr(found, name) for name in found.__struct_fields__}, "equal": found.equal})
    else:
        out.print(escape(found.words))
        for one in found.differences:
            stress = f"{one.test}: {one.before:.6g} MPa, again {one.again:.6g} MPa"
            out.print(f"  iteration {one.iteration}: {one.verdict}, again {one.verdict_again}; {escape(stress)}")
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
