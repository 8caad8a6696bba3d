"""The command that tests a part as it is: simulate."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mechstyle.cli.console import command, err, escape, factor, out, print_json, table, telling, verdict_text
from mechstyle.cli.making import Criterion, Device, Json, LoadFile, MaterialName, MinimumWall, Model, Scale, Vertices, read_model

if TYPE_CHECKING:
    from mechstyle.dropped import Dropped

app = typer.Typer()


@app.command("simulate")
@command
def simulate_command(
    model: Model,
    material: MaterialName = "PLA",
    orientations: Annotated[int, typer.Option(help="Drops, the first as placed.")] = 5,
    criterion: Criterion = "robust",
    loads: LoadFile = None,
    minimum_wall: MinimumWall = None,
    vertices: Vertices = 25_000,
    scale: Scale = None,
    device: Device = "auto",
    folder: Annotated[Path | None, typer.Option("--out", help="Folder for the picture; the current one by default.")] = None,
    as_json: Json = False,
) -> None:
    """Drop a part as it is, without any style, and load it if asked to."""
    from mechstyle.dropped import simulate  # noqa: PLC0415 — physics is loaded when something is run

    mesh, name = read_model(model, scale, quiet=as_json)
    with telling(1, quiet=as_json) as teller:
        dropped = simulate(
            mesh,
            material=material,
            orientations=orientations,
            criterion=criterion or "robust",
            loads=loads or (),
            minimum_wall=0.8 if minimum_wall is None else minimum_wall,
            vertices=vertices,
            device=device,
            stage=teller.stage,
            progress=teller.fraction,
        )
        picture = dropped.show().save((folder or Path()) / f"{name}-stress.png")
    if as_json:
        files = {"picture": str(picture)}
        print_json(
            {
                **to_dict(dropped.strength),
                "warning": dropped.warning,
                "loads": dropped.simulation.loaded,
                "notes": dropped.part.notes,
                "material": dropped.recipe.material,
                "files": files,
            }
        )
        return
    _report(dropped, picture)


def _report(dropped: Dropped, picture: Path) -> None:
    """Print what a drop test found, for people."""
    strength = dropped.strength
    rows = table("", "")
    overall = "not run" if dropped.simulation.overall is None else f"{dropped.simulation.overall.p99:.1f} MPa"
    peak = "largest element stress" if dropped.verdict.criterion == "paper" else "peak stress (2 mm average)"
    for label, value in (
        ("verdict", verdict_text(strength.verdict)),
        (
            peak,
            f"{strength.peak_stress:.1f} MPa of {strength.allowable:.1f} MPa, safety factor {factor(strength.safety_factor)}",
        ),
        ("p99.9 as placed", f"{dropped.simulation.as_placed.p999:.1f} MPa"),
        ("p99 over all orientations", overall),
        *((escape(f"load {case.name!r}"), case.words) for case in dropped.simulation.loaded),
        ("literal maximum", f"{strength.maximum:.1f} MPa (depends on the mesh)"),
        ("tetrahedra", f"{len(dropped.part.tets.tets)}"),
        ("picture", escape(str(picture))),
    ):
        rows.add_row(label, value)
    out.print(rows)
    out.print(f"\n{escape(strength.words)}")
    if dropped.warning:
        err.print(f"[yellow]warning:[/] {escape(dropped.warning)}")


def to_dict(record: Any) -> dict[str, Any]:
    """The fields of a record by name."""
    return {name: getattr(record, name) for name in record.__struct_fields__}
