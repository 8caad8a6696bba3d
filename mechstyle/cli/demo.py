"""Commands for lessons: demo, class prepare, class collect."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mechstyle.cli.console import command, err, escape, headline, in_colour, out, print_json, progress_shown, table
from mechstyle.cli.options import TYPED, Device, Json, Settings, Vertices, recipe_options
from mechstyle.cli.run import carry_out
from mechstyle.errors import BadInput
from mechstyle.records import sentences
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.records.recipe import described
from mechstyle.records.written import length_of

if TYPE_CHECKING:
    from mechstyle.runs.run import Run
    from mechstyle.simulation.part import Model as Opened

app = typer.Typer()


@app.command("demo")
@command
@recipe_options("height", "tolerance")
def demo_command(
    *,
    settings: Settings,
    folder: Annotated[Path, typer.Option("--out", help="Where the runs, pictures and 3MF files go.")] = Path("demo-out"),
    model: Annotated[str, typer.Option(help="What to style, a file or gallery:NAME.", show_default="the lessons' trophy")] = "",
    prompt: Annotated[str, typer.Option(*TYPED["prompt"].flags, help=described("prompt"))] = "brick",
    device: Device = "auto",
    vertices: Vertices = STANDARD_VERTICES,
    as_json: Json = False,
) -> None:
    """Style the trophy of the lessons as brick, freely and with feedback, and compare what stays bent."""
    from mechstyle import teaching  # noqa: PLC0415 — physics is loaded when something is run

    if not model and vertices != STANDARD_VERTICES:
        raise BadInput("--vertices is for a part of your own, because the trophy is meshed already: name one with --model, or leave it out")
    asked, part = {**({} if model else teaching.STYLE), "prompt": prompt, **settings}, model or teaching.trophy()
    tell(both_ways(part, asked, vertices, device, folder, as_json=as_json), folder, as_json=as_json)


def both_ways(model: str | Opened, settings: Settings, vertices: int, device: str, folder: Path, *, as_json: bool) -> dict[str, Run]:
    """Run a part freely and with feedback, with progress; the runs by what they are called."""
    from mechstyle.runs.recipes import FREESTYLE  # noqa: PLC0415 — as above

    runs = {}
    for label, freestyle in (("Freestyle", True), ("MechStyle", False)):
        if not as_json:
            name = model if isinstance(model, str) else f"a {model.name}"
            err.print(f"[bold]{label}[/]: {escape(name)} as “{escape(settings['prompt'])}”")
        where, own = folder / label.lower(), {name: value for name, value in settings.items() if not (freestyle and name in FREESTYLE)}
        runs[label] = carry_out(model, own, vertices, {}, device, where, freestyle=freestyle, as_json=as_json)
    return runs


def tell(runs: dict[str, Run], folder: Path, *, as_json: bool) -> None:
    """Write and print what the two runs came to; the table of what stays bent stands last."""
    from mechstyle.teaching import bent  # noqa: PLC0415 — as above

    picture = str(bent({"plain": (runs["Freestyle"], 0), **runs}).save(folder / "comparison.png"))
    if as_json:
        print_json({**{label.lower(): run.summary for label, run in runs.items()}, "files": {"comparison": picture}})
        return
    for label, run in runs.items():
        out.print(f"{label}: 3MF {escape(run.summary.files['model'])}")
    out.print(f"picture: {escape(picture)}\n")
    for label, run in runs.items():
        out.print(f"{label}: {headline(run.verdict)}")
        if run.verdict.doubt:
            out.print(f"  {escape(run.verdict.doubt)}")
    rows = table("test", "plain", *runs, "allowed")
    for cells in sentences.paired([run.verdict for run in runs.values()]):
        rows.add_row(*map(in_colour, cells))
    rows.add_row("style kept", "–", *(f"{run.summary.kept:.0%}" for run in runs.values()), "–")
    out.print()
    out.print(rows)
    out.print(f"next: {escape(activation())}mechstyle run YOUR_PART.stl --prompt brick")


def activation() -> str:
    """What a shell needs in front of `mechstyle …`: nothing if it finds the command, else the virtual environment of this Python."""
    script, found = Path(sys.prefix, "bin", "activate"), shutil.which("mechstyle")
    if not script.is_file() or (found and Path(found).parent == script.parent):
        return ""
    here = os.path.relpath(script) if Path(sys.prefix).is_relative_to(Path.cwd()) else str(script)
    return f"source {shlex.quote(here)} && "


class_app = typer.Typer(help="Prepare parts and styles for a class, and collect its reports.")
app.add_typer(class_app, name="class")

IN_CLASS = 3_000
"""Vertices, so that a run takes about a minute on two cores."""


@class_app.command("prepare")
@command
@recipe_options("iterations", "material", "height", "tolerance", "schedule", "nearly_flat", begins=False, others=True)
def prepare_command(
    models: Annotated[list[str], typer.Argument(metavar="MODEL...", help="Files (STL, OBJ, PLY, GLB, 3MF, STEP) or gallery:NAME.")],
    settings: Settings,
    prompts: Annotated[list[str], typer.Option("--prompt", "-p", help="A style, in words. May be given several times.")],
    folder: Annotated[Path, typer.Option("--out", help="Folder for the list of commands and the prepared runs.")] = Path("class"),
    vertices: Vertices = IN_CLASS,
    device: Device = "auto",
    as_json: Json = False,
) -> None:
    """Mesh every part for every style and drop every plain part, so that pupils wait for their own drops only."""
    from mechstyle.classroom import prepare  # noqa: PLC0415 — physics is loaded when something is run

    with progress_shown(len(models) * len(prompts), quiet=as_json) as teller:
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
    from mechstyle.classroom import as_file, collect  # noqa: PLC0415 — loaded when wanted

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
