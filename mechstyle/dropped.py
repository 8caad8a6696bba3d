"""One drop test of a part as it is, without any style."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np

from mechstyle import walls
from mechstyle.fea.criterion import input_warning, judge
from mechstyle.fea.drop_test import resolve_device
from mechstyle.load_cases import LoadCase, load_cases
from mechstyle.look import Picture, picture, stress_panel
from mechstyle.material import Material, material_named
from mechstyle.mesh import SurfaceMesh
from mechstyle.planning import fitted
from mechstyle.records import Recipe, Simulation, Verdict
from mechstyle.simulator import DropSimulator, Progress, no_progress
from mechstyle.summary import Strength
from mechstyle.workpiece import STANDARD_VERTICES, Stage, Workpiece, cached_memo, prepare, say_nothing


@dataclass(frozen=True, eq=False)
class Dropped:
    """A part and what its drop test said.

    Attributes:
        part: The prepared part.
        recipe: Material, drop and criterion.
        simulation: What was measured.
        verdict: What it means.
        warning: What the part itself exceeds, its material's strength or its printer's thinnest wall, in sentences; "" for nothing.
    """

    part: Workpiece
    recipe: Recipe
    simulation: Simulation
    verdict: Verdict
    warning: str

    @property
    def strength(self) -> Strength:
        """The verdict in figures."""
        return Strength.of(self.verdict)

    def show(self) -> Picture:
        """Stress of the as-placed drop from three sides."""
        limit = self.verdict.deciding.limit
        first = "stress, dropped and loaded" if self.simulation.loaded else "stress as placed"
        views = (("three_quarter", first), ("side", "side"), ("below", "from below"))
        field = self.simulation.stress
        return picture([stress_panel(self.part.surface, field, self.verdict, title=title, limit=limit, view=view) for view, title in views])


def simulate(
    mesh: SurfaceMesh,
    *,
    material: str | Material = "PLA",
    orientations: int = 5,
    criterion: str = "robust",
    loads: str | Path | LoadCase | Sequence[LoadCase] = (),
    minimum_wall: float = 0.8,
    vertices: int = STANDARD_VERTICES,
    device: str = "auto",
    stage: Stage = say_nothing,
    progress: Progress = no_progress,
) -> Dropped:
    """Drop a part as it is.

    Args:
        mesh: A closed surface [mm], z up, as it stands.
        material: A library name, a .toml/.json file, or a Material.
        orientations: Drops, the first as placed.
        criterion: `robust` or `paper`.
        loads: A load file or load cases the part must carry besides.
        minimum_wall: The thinnest wall that is not warned about [mm]; 0 for no warning.
        vertices: Vertices of the standardised surface.
        device: `auto`, `cpu` or `cuda`.
        stage: Told what is being prepared, in words.
        progress: Called with the fraction of the drop done; may raise to cancel.

    Raises:
        BadInput: If the part or a setting cannot be used, in one sentence.
    """
    chosen, where = material_named(material), resolve_device(device)
    wanted = Recipe(
        surface="", tetrahedra="", prompt="", material=chosen, orientations=orientations, criterion=criterion, loads=load_cases(loads),
        minimum_wall=minimum_wall,
    )  # fmt: skip
    part = prepare(mesh, vertices=vertices, stage=stage)
    recipe = fitted(wanted, part)
    stage("dropping it")
    simulator = DropSimulator(part.surface, part.tets, recipe, cached_memo(), device=where, progress=progress)
    unstyled = np.zeros(len(part.surface.vertices), np.float32)
    simulation = simulator.simulate(unstyled, thorough=True)
    thin = walls.warnings(part.surface, part.thickness, unstyled, minimum_wall)
    warning = " ".join(filter(None, (input_warning(simulation, chosen), *(f"{sentence}." for sentence in thin))))
    return Dropped(part, recipe, simulation, judge_alone(simulation, chosen, criterion), warning)


def judge_alone(simulation: Simulation, material: Material, criterion: str) -> Verdict:
    """Whether a part that has no original to be compared with survives: its peak as placed against the yield strength.

    The rule over all orientations compares with the original and therefore does not apply. An original without stress leaves
    nothing but the yield strength of `fea.criterion.judge`.
    """
    as_placed = replace(simulation, overall=None)
    original = replace(as_placed, as_placed=msgspec.structs.replace(simulation.as_placed, peak=0.0))
    return judge(as_placed, original, material, criterion)
