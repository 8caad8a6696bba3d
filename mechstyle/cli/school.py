"""Commands for a class: class prepare, class collect."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechstyle.cli.console import command, escape, in_colour, out, print_json, table, telling
from mechstyle.cli.options import Device, Json, Settings, Vertices, recipe_options
from mechstyle.records.written import length_of

app = typer.Typer()
class_app = typer.Typer(help="Prepare parts and styles for a class, and collect its reports.")
app.add_typer(class_app, name="class")

IN_CLASS = 3_000
"""Vertices, so that a run takes about a minute on two cores."""


@class_app.command("prepare")
@command
@recipe_options("iterations", "material", "height", "schedule", "nearly_flat", begins=False, others=True)
def prepare_command(
    models: Annotated[list[str], typer.Argument(metavar="MODEL...", help="Files (STL, OBJ, PLY, GLB, 3MF) or gallery:NAME.")],
    settings: Settings,
    prompts: Annotated[list[str], typer.Option("--prompt", "-p", help="A style, in words. May be given several times.")],
    folder: Annotated[Path, typer.Option("--out", help="Folder for the list of commands and the prepared runs.")] = Path("class"),
    vertices: Vertices = IN_CLASS,
    device: Device = "auto",
    as_json: Json = False,
) -> None:
    """Mesh every part for every style and drop every plain part, so that pupils wait for their own drops only."""
    from mechstyle.study.classroom import prepare  # noqa: PLC0415 — physics is loaded when something is run

    with telling(len(models) * len(prompts), quiet=as_json) as teller:
        tasks = prepare(models, prompts, settings, vertices=vertices, folder=folder, device=device, stage=teller.stage)
    page = folder / "commands.md"
    if as_json:
        print_json({"commands": [task.command for task in tasks], "files": {"commands": str(page)}})
        return
    for task in tasks:
        out.print(escape(task.command))
    out.print(f"[dim]the same as a page: {escape(str(page))}[/]")


@class_app.command("collect")
@command
def collect_command(
    reports: Annotated[list[Path], typer.Argument(metavar="REPORT...", help="Files of `mechstyle report`, named after their pupils.")],
    height: Annotated[str, typer.Option(help='The fall that counts, such as "1.5 m".')] = "1.5 m",
    path: Annotated[Path | None, typer.Option("--out", help="Write the table as well: .md or .csv.")] = None,
    as_json: Json = False,
) -> None:
    """Make one table of the reports of a class: who keeps most style and still passes?"""
    from mechstyle.study.classroom import as_file, collect  # noqa: PLC0415 — loaded when wanted

    handed = collect(reports, length_of(height))
    files = {} if path is None else {"table": str(as_file(handed, path))}
    if as_json:
        headings, *lines = handed.lines
        print_json({"rows": [dict(zip(headings, line, strict=True)) for line in lines], "refused": handed.refused, "files": files})
        return
    headings, *lines = handed.lines
    shown = table(*headings)
    for line in lines:
        shown.add_row(*map(in_colour, line))
    out.print(shown)
    for sentence in handed.refused:
        out.print(f"[yellow]refused:[/] {escape(sentence)}")
    for file in files.values():
        out.print(escape(file))
