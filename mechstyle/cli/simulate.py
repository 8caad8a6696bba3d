"""The command that tests a part as it is: simulate."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mechstyle.cli.console import command, err, escape, factor, out, print_json, table, telling, verdict_text
from mechstyle.cli.options import Device, Json, Model, Scale, Settings, Up, Vertices, recipe_options
from mechstyle.cli.run import read_model
from mechstyle.records.landings import STANDARDS
from mechstyle.records.mesh import STANDARD_VERTICES
from mechstyle.records.recipe import DEFAULTS

if TYPE_CHECKING:
    from mechstyle.simulation.part_test import PartTest

app = typer.Typer()

Original = Annotated[
    str,
    typer.Option(help="What it was styled from, a file or gallery:NAME in the same place; it is then judged beside that, as in its run."),
]


@app.command("simulate")
@command
@recipe_options("material", "orientations", "poses", "tilts", "standard", "build_direction", "criterion", "loads", "minimum_wall", "window")
def simulate_command(
    model: Model,
    settings: Settings,
    original: Original = "",
    vertices: Vertices = STANDARD_VERTICES,
    scale: Scale = None,
    up: Up = "",
    device: Device = "auto",
    folder: Annotated[Path | None, typer.Option("--out", help="Folder for pictures and files; the current one by default.")] = None,
    vtu: Annotated[bool, typer.Option("--vtu", help="Write displacement, stress and contact for ParaView.")] = False,
    vtu_each: Annotated[bool, typer.Option("--vtu-each", help="The same, with stress and contact of every orientation.")] = False,
    as_json: Json = False,
) -> None:
    """Drop a part as it is, without any style, and load it if asked to; beside the original it was styled from if that is named."""
    from mechstyle.simulation.part_test import simulate  # noqa: PLC0415 — physics is loaded when something is run

    mesh, name = read_model(model, scale, up, quiet=as_json)
    before = read_model(original, None, "", quiet=as_json)[0] if original else None
    with telling(1, quiet=as_json) as teller:
        dropped = simulate(
            mesh, original=before, **settings, vertices=vertices, device=device, stage=teller.stage, progress=teller.fraction,
            measured=lambda shape: teller.warn(shape.too_thin(settings.get("minimum_wall", DEFAULTS["minimum_wall"]))),
        )  # fmt: skip
        teller.stage("writing files")
        files = _written(dropped, folder or Path(), name, vtu=vtu or vtu_each, each=vtu_each)
    if as_json:
        print_json(_figures(dropped, files))
    else:
        _report(dropped, files)


def _written(dropped: PartTest, folder: Path, name: str, *, vtu: bool, each: bool) -> dict[str, str]:
    """Write pictures and, if wanted, the file for ParaView; their paths by what they are. A failed drop has no history."""
    files = {"picture": dropped.show().save(folder / f"{name}-stress.png")}
    if dropped.course is not None:
        files["history"] = dropped.show_history().save(folder / f"{name}-history.png")
        if vtu:
            files["vtu"] = dropped.save_vtu(folder / f"{name}.vtu", each_orientation=each)
    return {what: str(path) for what, path in files.items()}


def _figures(dropped: PartTest, files: dict[str, str]) -> dict[str, Any]:
    """The measured figures as plain values, for `--json`."""
    from mechstyle.simulation.drop_history import history_figures  # noqa: PLC0415 — as above

    simulation = dropped.simulation
    return {
        **to_dict(dropped.strength),
        "as_placed": simulation.as_placed,
        "overall": simulation.overall,
        "landings": simulation.landings,
        "after_standard": dropped.recipe.after_standard,
        "course": dropped.course,
        "history": history_figures(dropped.history),
        "warning": dropped.warning,
        "loads": simulation.loaded,
        "notes": dropped.part.notes,
        "material": dropped.recipe.material,
        "tetrahedra": len(dropped.tets.tets),
        "fit": dropped.fit,
        "original": None if dropped.original is None else dropped.original.as_placed,
        "original_tilted": None if dropped.original is None else dropped.original.tilted,
        "original_landings": () if dropped.original is None else dropped.original.landings,
        "original_failure_probability": None if dropped.original is None else dropped.original.failure_probability,
        "steps": simulation.steps,
        "time_step": simulation.time_step,
        "added_mass": simulation.added_mass,
        "files": files,
    }


def _report(dropped: PartTest, files: dict[str, str]) -> None:
    """Print what a drop test found, for people."""
    strength, simulation = dropped.strength, dropped.simulation
    rows = table("", "")
    peak = "largest element stress" if dropped.verdict.criterion == "paper" else "peak stress as placed"
    for label, value in (
        ("verdict", verdict_text(strength.verdict, marginal=strength.marginal)),
        ("safety factor", f"{factor(strength.safety_factor)}, the least of the rules that count"),
        (peak, f"{strength.peak_stress:.1f} MPa of {strength.allowable:.1f} MPa"),
        *_tilted_row(dropped),
        ("p99.9 as placed", f"{simulation.as_placed.p999:.1f} MPa"),
        *_orientation_rows(dropped),
        *((escape(f"load {case.name!r}"), case.words) for case in simulation.loaded),
        ("literal maximum", f"{strength.maximum:.1f} MPa (depends on the mesh)"),
        *_course_rows(dropped),
        ("shape", f"tetrahedra {dropped.fit.words}"),
        *_original_rows(dropped),
        *([("layers", escape(dropped.recipe.layers_judged))] if dropped.recipe.build_direction else []),
        ("tetrahedra", f"{len(dropped.tets.tets)}; {simulation.steps} steps of {1e3 * simulation.time_step:.3f} µs"),
        *((what, escape(path)) for what, path in files.items()),
    ):
        rows.add_row(label, value)
    out.print(rows)
    out.print(f"\n{escape(strength.words)}")
    if dropped.recipe.standard:
        out.print(f"[dim]{escape(STANDARDS[dropped.recipe.standard].departs)}[/]")
    if dropped.original is None:
        out.print("[dim]judged alone, by the strength of its material: a styled part is judged as in its run with --original FILE[/]")
    if dropped.warning:
        err.print(f"[yellow]warning:[/] {escape(dropped.warning)}")


def _tilted_row(dropped: PartTest) -> list[tuple[str, str]]:
    """A table row of the drops nearly as placed, with their limit where they are judged."""
    simulation, judged = dropped.simulation, dropped.verdict.tilted
    if simulation.tilted is None:
        return []
    limit = f" of {judged.limit:.1f} MPa" if judged is not None and judged in dropped.verdict.counting and not simulation.failure else ""
    return [("tilted by 3°", f"{simulation.tilted.surface:.1f} MPa{limit} at the surface")]


def _original_rows(dropped: PartTest) -> list[tuple[str, str]]:
    """Table rows of what a part is compared with."""
    original, relief = dropped.original, dropped.fit.relief
    if original is None or relief is None:
        return []
    tilted = "" if original.tilted is None else f", tilted {original.tilted.surface:.1f} MPa"
    under = "" if relief.carried_base is None else f" ({relief.carried_base:.0%} under the part)"
    carried = f"{relief.carried:.0%} of it carried by the tetrahedra{under}"
    return [
        ("original", f"{original.as_placed.peak:.1f} MPa as placed{tilted}"),
        ("relief", f"{relief.lowest:.2f} to {relief.highest:.2f} mm over the original, {carried}"),
    ]


def _orientation_rows(dropped: PartTest) -> list[tuple[str, str]]:
    """Table rows of the drops in other orientations."""
    overall = dropped.simulation.overall
    if overall is None or not dropped.simulation.landings:
        return [("p99 over all orientations", "not run" if overall is None else "not known")]
    worst, before = dropped.simulation.worst, dropped.original
    assert worst is not None, "there are landings"
    first = "" if before is None or before.worst is None else f"; the original {before.worst.measures.peak:.1f} MPa"
    x, y, z = worst.normal
    rows = [
        ("p99 over all orientations", f"{overall.p99:.1f} MPa"),
        ("worst orientation", f"{worst.measures.peak:.1f} MPa, {worst.name}, floor normal ({x:.2f}, {y:.2f}, {z:.2f}){first}"),
    ]
    if dropped.recipe.after_standard:
        rows.append(("orientations", dropped.recipe.after_standard))
    chance = dropped.simulation.failure_probability
    if chance is not None:
        share = f"{chance:.0%} of random drops begin to yield it somewhere, beyond {dropped.recipe.material.yield_strength:.1f} MPa"
        if before is not None and before.failure_probability is not None:
            share += f", the original in {before.failure_probability:.0%}"
        rows.append(("failure probability", f"{share} (of {len(dropped.simulation.landings)} {dropped.recipe.poses} drops)"))
    return rows


def _course_rows(dropped: PartTest) -> list[tuple[str, str]]:
    """When the drop as placed did what."""
    course = dropped.course
    if course is None:
        return []
    x, y, z = course.peak_where
    return [
        ("highest on the surface", f"{course.peak_stress:.1f} MPa by {course.peak_time:.2f} ms, at ({x:.1f}, {y:.1f}, {z:.1f}) mm"),
        ("contact force", f"up to {course.peak_force:.0f} N, the last of it at {course.contact_time:.2f} ms"),
        ("touches", course.touch_words),
        ("energy", course.words),
    ]


def to_dict(record: Any) -> dict[str, Any]:
    """The fields of a record by name."""
    return {name: getattr(record, name) for name in record.__struct_fields__}
