"""Commands on a part as it is: simulate, protect."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mechstyle.cli.console import command, err, escape, out, print_json, progress_shown, report_verdict, table
from mechstyle.cli.options import READ_AS, REGIONS, Details, Device, Json, Model, Settings, Vertices, reads_a_part, recipe_options
from mechstyle.cli.run import read_model
from mechstyle.errors import BadInput
from mechstyle.records.landings import STANDARDS
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.records.recipe import DEFAULTS, settings_of
from mechstyle.records.regions import KINDS

if TYPE_CHECKING:
    from mechstyle.simulation.part_test import PartTest

app = typer.Typer()

Original = Annotated[
    str,
    typer.Option(
        help=f"The plain part it was styled from, a file or gallery:NAME in the same place, to compare it with as in its run. {READ_AS}"
    ),
]


@app.command("simulate")
@command
@reads_a_part
@recipe_options(
    "material", "height", "tolerance", "orientations", "poses", "nearly_flat", "standard", "build_direction", "criterion", "loads",
    "minimum_wall", "window", *settings_of("printed"),
)  # fmt: skip
def simulate_command(
    model: Model,
    settings: Settings,
    reading: Settings,
    original: Original = "",
    vertices: Vertices = STANDARD_VERTICES,
    device: Device = "auto",
    folder: Annotated[Path | None, typer.Option("--out", help="Folder for pictures and files; the current one by default.")] = None,
    vtu: Annotated[bool, typer.Option("--vtu", help="Write what stays bent, stress and contact in the body for ParaView.")] = False,
    details: Details = False,
    as_json: Json = False,
) -> None:
    """Drop a part without styling it, and load it with --load; compare it with the plain part with --original."""
    from mechstyle.simulation.part_test import simulate  # noqa: PLC0415 — physics is loaded when something is run

    mesh, name = read_model(model, reading, quiet=as_json)
    before = read_model(original, {}, quiet=as_json)[0] if original else None
    with progress_shown(1, quiet=as_json) as teller:
        dropped = simulate(
            mesh, original=before, **settings, vertices=vertices, device=device, stage=teller.stage, progress=teller.fraction,
            measured=lambda shape: teller.warn(shape.too_thin(settings.get("minimum_wall", DEFAULTS["minimum_wall"]))),
        )  # fmt: skip
        teller.stage("writing files")
        files = _written(dropped, folder or Path(), name, vtu=vtu)
    if as_json:
        print_json(_figures(dropped, files))
    else:
        _report(dropped, files, details=details)


def _written(dropped: PartTest, folder: Path, name: str, *, vtu: bool) -> dict[str, str]:
    """Write pictures and, if wanted, the file for ParaView; their paths by what they are. A failed drop has no history."""
    files = {"picture": dropped.show().save(folder / f"{name}-stress.png")}
    if dropped.course is not None:
        files["history"] = dropped.show_history().save(folder / f"{name}-history.png")
        if vtu:
            files["vtu"] = dropped.save_vtu(folder / f"{name}.vtu")
    return {what: str(path) for what, path in files.items()}


def _figures(dropped: PartTest, files: dict[str, str]) -> dict[str, Any]:
    from mechstyle.simulation.drop_history import history_figures  # noqa: PLC0415 — as above

    simulation, original, verdict = dropped.simulation, dropped.original, dropped.verdict
    return {
        "outcome": verdict.outcome,
        "doubts": verdict.doubts,
        "tolerance": verdict.tolerance,
        "rows": verdict.rows,
        "words": verdict.words,
        "landings": simulation.landings,
        "loads": simulation.loads,
        "original": None if original is None else {"landings": original.landings, "loads": original.loads},
        "after_standard": dropped.recipe.test.after_standard,
        "course": dropped.course,
        "history": history_figures(dropped.history),
        "warning": dropped.warning,
        "advice": dropped.advice,
        "notes": dropped.part.notes,
        "material": dropped.recipe.test.material,
        "printed": dropped.recipe.printed,
        "mass": dropped.mass,
        "tetrahedra": len(dropped.tets.tets),
        "fit": dropped.fit,
        "relief": {"lowest": float(dropped.relief.min()), "highest": float(dropped.relief.max()), "followed": simulation.carried},
        "steps": simulation.steps,
        "time_step": simulation.time_step,
        "added_mass": simulation.added_mass,
        "files": files,
    }


def _report(dropped: PartTest, files: dict[str, str], *, details: bool) -> None:
    """Print what a drop test found, for people."""
    test = dropped.recipe.test
    if details:
        _report_details(dropped)
    for what, path in files.items():
        out.print(f"{what}: {escape(path)}")
    out.print()
    report_verdict(dropped.verdict, details=details)
    if not dropped.recipe.printed.solid:
        out.print(f"weighs {dropped.mass:.1f} g as printed")
    if dropped.advice:
        out.print(escape(dropped.advice))
    if test.layers_judged:
        out.print(escape(test.layers_judged))
    if test.after_standard:
        out.print(f"{escape(test.after_standard)}. {escape(STANDARDS[test.standard].departs)}")
    if dropped.original is not None:
        follows = f"the mesh follows {dropped.simulation.carried:.0%} of it"
        out.print(f"relief {dropped.relief.min():.2f} to {dropped.relief.max():.2f} mm over the original, {follows}")
    else:
        out.print("[dim]if this is a styled part, --original FILE compares it with its plain part, as in its run[/]")
    if dropped.warning:
        err.print(f"[yellow]warning:[/] {escape(dropped.warning)}")


def _report_details(dropped: PartTest) -> None:
    """Print figures of the drop that few need."""
    simulation, rows = dropped.simulation, table("", "")
    course = list[tuple[str, str]]()
    if dropped.course is not None:
        force = f"up to {dropped.course.peak_force:.0f} N, the last of it at {dropped.course.contact_time:.2f} ms"
        course = [("contact force", force), ("touches", dropped.course.touch_words), ("energy", dropped.course.words)]
    for label, value in (
        *course,
        ("shape", f"tetrahedra {dropped.fit.words}"),
        ("tetrahedra", f"{len(dropped.tets.tets)}; {simulation.steps} steps of {1e3 * simulation.time_step:.3f} µs"),
    ):
        rows.add_row(label, value)
    out.print(rows)


@app.command("protect", epilog=REGIONS)
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
    with progress_shown(1, quiet=as_json) as teller:
        found = looked_at(mesh, settings["protect"], vertices=vertices, stage=teller.stage)
        path = found.show().save(picture or Path(f"{name}-protected.png"))
    if as_json:
        print_json({"share": found.share, "notes": found.protection.notes, "files": {"picture": str(path)}})
        return
    for note in found.protection.notes:
        out.print(escape(note))
    out.print(f"picture: {escape(str(path))}")
