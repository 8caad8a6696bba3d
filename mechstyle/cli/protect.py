"""The command that shows what protected regions hold: protect."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechstyle.cli.console import command, escape, out, print_json, telling
from mechstyle.cli.options import Json, Model, Settings, Vertices, reads_a_part, recipe_options
from mechstyle.cli.run import read_model
from mechstyle.errors import BadInput
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.records.regions import KINDS

app = typer.Typer()


@app.command("protect")
@command
@reads_a_part
@recipe_options("protect")
def protect_command(
    model: Model,
    settings: Settings,
    reading: Settings,
    vertices: Vertices = STANDARD_VERTICES,
    picture: Annotated[Path | None, typer.Option("--out", help="PNG to write; by default in the current folder.")] = None,
    as_json: Json = False,
) -> None:
    """Picture of what protected regions hold, before anything is styled."""
    from mechstyle.runs.protection import protect as looked_at  # noqa: PLC0415 — loaded when wanted

    if not settings:
        raise BadInput(f"say what to protect with --protect, once or more; it can be: {', '.join(KINDS.values())}")
    mesh, name = read_model(model, reading, quiet=as_json)
    with telling(1, quiet=as_json) as teller:
        found = looked_at(mesh, settings["protect"], vertices=vertices, stage=teller.stage)
        path = found.show().save(picture or Path(f"{name}-protected.png"))
    if as_json:
        print_json({"share": found.share, "notes": found.protection.notes, "files": {"picture": str(path)}})
        return
    for note in found.protection.notes:
        out.print(escape(note))
    out.print(f"picture: {escape(str(path))}")
