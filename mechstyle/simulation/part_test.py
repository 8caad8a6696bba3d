"""Drop test and load cases of a part without style, which may be another part with a relief."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from scipy.spatial import cKDTree

from mechstyle._files import write_whole
from mechstyle.errors import BadInput, SimulationFailed, check_known
from mechstyle.fea.drop import History, resolve_device
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.loop import minimum_wall as walls
from mechstyle.pictures import fields
from mechstyle.pictures.panels import Picture, bent_panel, field_panel, picture, stress_note
from mechstyle.records import Recipe, Simulation, Verdict, sentences
from mechstyle.records.landings import with_drops
from mechstyle.records.load_cases import LoadCase, load_cases
from mechstyle.records.material import Material, material_named
from mechstyle.records.mesh import STANDARD_VERTICES, Field, SurfaceMesh, TetMesh, check_vertices
from mechstyle.records.recipe import DEFAULTS, direction_of, settings_of
from mechstyle.records.sliced import with_sliced
from mechstyle.records.written import READERS, length_of, tolerance_of
from mechstyle.simulation.drop_history import Course, history_picture, vtu_bytes, vtu_path
from mechstyle.simulation.impact import Impact, impact_of
from mechstyle.simulation.more_walls import with_more_walls
from mechstyle.simulation.part import Shape, Stage, Workpiece, cached_memo, fitted, prepare, standardised
from mechstyle.simulation.printed import plastic_share
from mechstyle.simulation.simulator import DropSimulator

ROUNDS = 20
"""Times a vertex is moved along its normal towards the styled surface; on a slope of 45° each halves what is missing."""
SEEN = 0.01
"""Relief below which a place has none [mm]: no printer shows it."""
ON_NORMAL = 0.01
"""Distance from the normal of a vertex within which a styled vertex is that one, moved [mm]; files round less."""
ALIKE = 0.05
"""Distance of the styled surface from what the relief gives at which they are the same [mm]: less than a printer shows …"""
STRAYS = 0.02
"""… but for this share of the area, as a relief folds over itself here and there …"""
FAR = 1.0
"""… by this at most [mm]: 0.35 mm of a part in free bricks. A narrow slot lies further, and would be judged as none."""


@dataclass(frozen=True, eq=False)
class PartTest:
    """A part and what its drop test said.

    Attributes:
        simulator: What tested it: the prepared part, which is the original where one was given, and its recipe.
        relief: Relief over the original [mm], shape [vertex_count]; zero where none was given.
        simulation: What was measured.
        verdict: What it means.
        warning: Which walls are thinner than the printer's thinnest; "" for nothing.
        advice: How many more walls make a print hold that fails, as tested; "" for nothing.
        tets: The tetrahedra that were dropped.
        history: Energies, contact force and largest stress of the drop as placed over time.
        impact: The drop as placed, moment by moment, and the shape that it leaves; None for one that failed.
        fit: How the tetrahedra follow the part as it was given.
        original: The same test of the original, None if none was given.

    Example:
        >>> tested = ms.simulate(ms.load("gallery:drawer_knob"), vertices=500, device="cpu")
        >>> tested.verdict.outcome
        'HOLDS'
        >>> tested.relief.max() == 0.0
        np.True_
    """

    simulator: DropSimulator
    relief: Field
    simulation: Simulation
    verdict: Verdict
    warning: str
    tets: TetMesh
    history: History
    impact: Impact | None
    fit: Fit
    original: Simulation | None = None
    advice: str = ""

    @property
    def part(self) -> Workpiece:
        """The prepared part."""
        return self.simulator.part

    @property
    def recipe(self) -> Recipe:
        """Material, drop and criterion."""
        return self.simulator.recipe

    @property
    def surface(self) -> SurfaceMesh:
        """Surface that was dropped."""
        return self.part.surface.displaced(self.relief) if self.relief.any() else self.part.surface

    @property
    def mass(self) -> float:
        """Mass of the part as printed [g]."""
        share = plastic_share(self.tets, self.recipe)
        return float(self.recipe.test.material.density * self.surface.volume * share)

    @cached_property
    def course(self) -> Course | None:
        """The drop as placed over time, in figures; None for one that failed."""
        flat = self.simulation.flat
        return None if self.impact is None or flat is None else Course.of(self.history, flat, self.impact, self.surface.vertices)

    def show(self) -> Picture:
        """Stress in the worst test from three sides, and what stays bent in it, exaggerated."""
        worst, surface, strength = self.verdict.deciding, self.surface, self.recipe.test.material.yield_strength
        stress = fields.stress(strength, worst)
        values = stress.values_in(self.simulation)
        views, note = (("three_quarter", "stress"), ("front", "from the front"), ("below", "from below")), self.verdict.short
        panels = [field_panel(surface, stress, values, title=title, view=view) for view, title in views]
        if worst is not None:
            note = stress_note(surface, values, strength, worst)
            panels += [bent_panel(surface, self.simulation, worst)] if worst.test != "published rule" else []
        return picture([replace(panels[0], note=note), *panels[1:]], title=sentences.title(self.verdict), columns=2)

    def show_history(self) -> Picture:
        """Largest stress, energies and contact force of the drop as placed over time.

        Raises:
            SimulationFailed: If the drop failed.
        """
        if self.impact is None or self.course is None:
            raise SimulationFailed(self.simulation.failure)
        return history_picture(self.history, self.impact, self.course, self.recipe.test.material.yield_strength)

    def save_vtu(self, path: str | Path) -> Path:
        """Drop the part flat once more and write what that leaves in the body for ParaView; `drop_history.vtu_bytes` lists the fields.

        Raises:
            BadInput: If the file does not end in .vtu.
            SimulationFailed: If the drop failed.
        """
        target = vtu_path(path)
        if self.course is None:
            raise SimulationFailed(self.simulation.failure)
        write_whole(target, vtu_bytes(self.tets, self.simulator.dropped(self.tets, [0])))
        return target


def simulate(
    mesh: SurfaceMesh, *, original: SurfaceMesh | None = None, material: str | Material = "PLA",
    orientations: int | None = None, poses: str | None = None, nearly_flat: bool = DEFAULTS["nearly_flat"],
    height: float | str | None = None, standard: str = DEFAULTS["standard"], criterion: str = DEFAULTS["criterion"],
    tolerance: float | str = DEFAULTS["tolerance"], loads: str | Path | LoadCase | Sequence[LoadCase] = (),
    minimum_wall: float = DEFAULTS["minimum_wall"], build_direction: str | Sequence[float] | None = None,
    window: float | None = DEFAULTS["window"], vertices: int = STANDARD_VERTICES, device: str = "auto",
    stage: Stage = no_progress, progress: Progress = no_progress, measured: Callable[[Shape], None] = no_progress, **printed: Any,
) -> PartTest:  # fmt: skip
    """Drop a part as it is.

    Args:
        mesh: A closed surface [mm], z up, as it stands.
        original: What it was styled from, in the same place: the part is read as a relief on it and judged as in a run.
        material: A library name, a .toml/.json file, or a Material.
        orientations: Landings that are not nearly flat, the flat one included; as many as the poses or the standard need.
        poses: How the others land, one of `records.POSES`: every way by default.
        nearly_flat: Whether it lands tilted by 3° onto the corners and sides of what it stands on, too.
        height: Height of the fall the part is to survive, [mm] or text such as "1.5 m"; 1.5 m, or what the standard asks for.
        standard: Drop standard whose orientations and height are simulated, such as `mil-810h`; the verdict is no test to it.
        criterion: `robust` or `paper`.
        tolerance: The most that may stay bent, [mm] or text such as "0.2 mm".
        loads: A load file or load cases the part must carry besides.
        minimum_wall: The thinnest wall that is not warned about [mm]; 0 for no warning.
        build_direction: Direction it is printed in, x, y, z or a vector, so that layers are judged by their own strength.
        window: Simulated time after first touch [ms]; by default until the impact has ended.
        vertices: Vertices of the standardised surface.
        device: `auto`, `cpu` or `cuda`.
        stage: Called with what is being prepared, in words.
        progress: Called with the fraction of the drop done; may raise to cancel.
        measured: Called with the part's surface and walls, before the minutes that meshing and drop may take.
        printed: How it is printed inside, settings of a recipe such as walls=3 and infill="15 %", or sliced="part.gcode"; solid by default.

    Raises:
        BadInput: If the part or a setting cannot be used, in one sentence.

    Example:
        >>> ms.simulate(ms.load("gallery:drawer_knob"), vertices=500, device="cpu").verdict.outcome
        'HOLDS'
    """
    check_known(simulate, printed, (*settings_of("printed"), "sliced"))
    chosen, where = material_named(material), resolve_device(device)
    asked = {"standard": standard, "orientations": orientations, "poses": poses, "height": None if height is None else length_of(height)}
    wanted = Recipe.of(
        prompt="", material=chosen, criterion=criterion, loads=load_cases(loads), minimum_wall=minimum_wall, window=window,
        tolerance=tolerance_of(tolerance), nearly_flat=nearly_flat, build_direction=None if build_direction is None else
        direction_of(build_direction), **inside_of(printed),
        **with_drops({name: value for name, value in asked.items() if value is not None}),
    )  # fmt: skip
    return _tested(mesh, *_prepared(mesh, original, check_vertices(vertices), stage, measured), wanted, where, stage, progress)


def inside_of(printed: Mapping[str, Any]) -> dict[str, Any]:
    """Settings of how a part is printed, read."""
    found = with_sliced(printed).items()
    return {name: READERS[name](value) if name in READERS else value for name, value in found if value is not None}


def _prepared(
    mesh: SurfaceMesh, original: SurfaceMesh | None, vertices: int, stage: Stage, measured: Callable[[Shape], None]
) -> tuple[Workpiece, Field | None]:
    """A part made ready as it is, or its original and the relief that makes the part of it [mm], shape [vertex_count]."""
    if original is None:
        return prepare(mesh, vertices=vertices, stage=stage, measured=measured), None
    stage("comparing it with its original")
    relief = relief_over(standardised(original, vertices), mesh, original)
    return prepare(original, vertices=vertices, stage=stage, measured=measured, relief=lambda _, **__: relief), relief


def _tested(
    given: SurfaceMesh, part: Workpiece, relief: Field | None, wanted: Recipe, device: str, stage: Stage, progress: Progress
) -> PartTest:
    """The test of a prepared part as it is, or of a relief on it [mm], shape [vertex_count]; `given` is the part as it was read."""
    memo, recipe = cached_memo(), fitted(wanted, part)
    displacement = np.zeros(len(part.surface.vertices), np.float32) if relief is None else relief
    simulator = DropSimulator(part, recipe, memo, memo, device, progress)
    stage("dropping it")
    simulation = simulator.simulate(displacement, thorough=True)
    original = None
    if relief is not None:
        stage("dropping its original")
        original = simulator.baseline
    verdict = simulator.judge(simulation, alone=relief is None)
    stage("looking at the impact")
    impact = None if simulation.failure else impact_of(simulator, simulation, progress=progress)
    thin = walls.warnings(part.surface, part.thickness, displacement, wanted.delivery.minimum_wall)
    tets, history = simulator.morphed(simulation)[1].tets, simulator.history(simulation)
    warning = " ".join(f"{sentence}." for sentence in thin)
    advice = with_more_walls(simulator, simulation, verdict)
    return PartTest(simulator, displacement, simulation, verdict, warning, tets, history, impact, fit_of(tets, given), original, advice)


class Fit(msgspec.Struct, frozen=True, kw_only=True):
    """How the boundary of tetrahedra lies to a part.

    Attributes:
        mean: Distance from the part, averaged over its vertices [mm].
        most: The largest [mm].
        volume: Volume of the tetrahedra over that of the part, less 1.
    """

    mean: float
    most: float
    volume: float

    @property
    def words(self) -> str:
        """Its figures in words."""
        return f"{self.mean:.2f} mm from the part on average, {self.most:.2f} mm at most, volume {self.volume:+.1%}"


def fit_of(tets: TetMesh, part: SurfaceMesh) -> Fit:
    """How tetrahedra follow a part as it was given, before it was standardised."""
    distance = TriangleTree(tets.vertices, tets.boundary_faces).nearest(part.vertices).distance
    return Fit(mean=float(distance.mean()), most=float(distance.max()), volume=float(tets.volumes.sum()) / part.volume - 1.0)


def relief_over(original: SurfaceMesh, styled: SurfaceMesh, given: SurfaceMesh | None = None) -> Field:
    """The relief that makes a styled part of its original [mm], shape [vertex_count].

    Each vertex of the original is moved along its normal to where it meets the styled surface.

    Args:
        original: The standardised original.
        styled: The part as it was given, in the same place.
        given: The original as it was given, from which standardising it may have gone; None for no further than ALIKE.

    Raises:
        BadInput: If the part is not its original with a relief.
    """
    if given is not None and styled.digest == given.digest:
        return np.zeros(len(original.vertices), np.float32)
    tree, normals = TriangleTree(styled.vertices, styled.faces), original.vertex_normals
    relief, limit = np.zeros(len(original.vertices)), 0.25 * original.size
    for _ in range(ROUNDS):
        there = original.vertices + relief[:, None] * normals
        relief = np.clip(relief + np.einsum("ij,ij->i", tree.nearest(there).point - there, normals), -limit, limit)
    # Beside a fold the nearest surface belongs to a neighbour. In a mesh of the same vertices the one on the normal is known.
    vertices = cKDTree(styled.vertices)
    lost = vertices.query(original.vertices + relief[:, None] * normals)[0] > ON_NORMAL
    if lost.mean() < 0.5:
        reach = 2.0 * float(np.abs(relief).max())
        for vertex in np.flatnonzero(lost):
            near = styled.vertices[vertices.query_ball_point(original.vertices[vertex], reach)] - original.vertices[vertex]
            along = near @ normals[vertex]
            aside = np.linalg.norm(near - along[:, None] * normals[vertex], axis=1)
            if len(near) and aside.min() < ON_NORMAL:
                relief[vertex] = along[aside.argmin()]
    made = original.displaced(relief.astype(np.float32))
    back = TriangleTree(made.vertices, made.faces).nearest(styled.vertices).distance
    areas = styled.vertex_areas
    own = ALIKE if given is None else 1.5 * float(TriangleTree(original.vertices, original.faces).nearest(given.vertices).distance.max())
    astray = float(areas[back > max(own, ALIKE)].sum() / areas.sum())
    if astray > STRAYS or back.max() > max(own, FAR):
        sizes = [" × ".join(f"{side:.3g}" for side in mesh.extents) for mesh in (styled, original)]
        raise BadInput(
            f"the part ({sizes[0]} mm) is not its original ({sizes[1]} mm) with a relief: {astray:.0%} of its surface is elsewhere"
            f" and one place lies {back.max():.1f} mm away;"
            " give the file it was styled from, in the same place and with as many --vertices, or leave the original out"
        )
    return np.where(np.abs(relief) < SEEN, 0.0, relief).astype(np.float32)
