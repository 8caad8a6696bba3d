"""The command that shows what each mechanism is worth: ablation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mechstyle.cli.console import EXIT_BAD_INPUT, command, escape, out, print_json, table, telling
from mechstyle.cli.options import MACHINE, STYLE, Device, Json, Settings, Vertices, recipe_options
from mechstyle.records.mesh import STANDARD_VERTICES

if TYPE_CHECKING:
    from mechstyle.study.ablation import Ablation

app = typer.Typer()


@app.command("ablation")
@command
@recipe_options("iterations", "seed", "material", "orientations", "poses", "loads", begins=False, others=True)
def ablation_command(
    models: Annotated[list[str], typer.Argument(metavar="MODEL...", help="Files (STL, OBJ, PLY, GLB, 3MF) or gallery:NAME.")],
    settings: Settings,
    prompts: Annotated[
        list[str] | None, typer.Option("--prompt", "-p", help="A style, in words. May be given several times.", rich_help_panel=STYLE)
    ] = None,
    amplitudes: Annotated[
        list[float] | None,
        typer.Option(
            "--amplitude",
            help="Half the relief's depth over local wall thickness; unless told, the default depth. May be given several times.",
            rich_help_panel=STYLE,
        ),
    ] = None,
    arms: Annotated[
        list[str] | None, typer.Option("--arm", help="freestyle, static, masks, full or finish-first; all of them unless told.")
    ] = None,
    jobs: Annotated[int, typer.Option(min=1, max=256, help="Processes side by side.", rich_help_panel=MACHINE)] = 1,
    vertices: Vertices = STANDARD_VERTICES,
    device: Device = "auto",
    folder: Annotated[Path, typer.Option("--out", help="Folder for the runs; what was run there before is read.")] = Path("ablation"),
    as_json: Json = False,
) -> None:
    """Stylize parts with mechanisms taken away one after the other, and count what each is worth."""
    from mechstyle.study.ablation import ablation  # noqa: PLC0415 — physics is loaded when something is run
    from mechstyle.study.grids import ARMS  # noqa: PLC0415

    wanted = prompts or ["brick"]
    with telling(len(models) * len(wanted) * len(amplitudes or [0]) * len(arms or ARMS), quiet=as_json) as teller:
        teller.stage("running")
        found = ablation(
            models, wanted, folder, amplitudes=amplitudes or [None], arms=arms or list(ARMS), vertices=vertices, device=device, jobs=jobs,
            tell=lambda row: teller.step(escape(f"{row.part} as {row.prompt!r}, {row.arm}: {row.verdict or row.refused}")), **settings,
        )  # fmt: skip
    files = found.save(folder)
    if as_json:
        print_json({"rows": list(found.rows), "files": files})
    else:
        _print(found, files)
    if all(row.status == "refused" for row in found.rows):
        raise SystemExit(EXIT_BAD_INPUT)


def _print(found: Ablation, files: dict[str, str]) -> None:
    """The counts, what was refused, and where the files are."""
    headings, *lines = found.summary()
    rows = table(*headings)
    for line in lines:
        rows.add_row(*line)
    out.print(rows)
    for row in found.rows:
        if row.refused:
            out.print(f"[yellow]refused:[/] {escape(row.part)} as “{escape(row.prompt)}”: {escape(row.refused)}")
    for what, path in files.items():
        out.print(f"{what}: {escape(path)}")
