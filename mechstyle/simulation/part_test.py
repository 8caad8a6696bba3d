"""Drop test and load cases of a part without style."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from mechstyle._files import write_whole
from mechstyle.errors import SimulationFailed
from mechstyle.fea.drop import resolve_device
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.history import History
from mechstyle.fea.snapshots import snapshot
from mechstyle.fea.verdict import input_warning, judge
from mechstyle.fea.vtu import vtu_path
from mechstyle.loop.history import Strength
from mechstyle.pictures import fields
from mechstyle.pictures.panels import Picture, field_panel, picture, verdict_note
from mechstyle.records import Recipe, Simulation, Verdict
from mechstyle.records.landings import with_drops
from mechstyle.records.load_cases import LoadCase, load_cases
from mechstyle.records.material import Material, material_named
from mechstyle.records.mesh import STANDARD_VERTICES, SurfaceMesh, TetMesh
from mechstyle.records.recipe import DEFAULTS, direction_of
from mechstyle.simulation.beside_original import Fit, fit_of, other_part
from mechstyle.simulation.carrying import others_at_rest
from mechstyle.simulation.drop_history import Course, history_picture, vtu_bytes
from mechstyle.simulation.impact import Impact, impact_of
from mechstyle.simulation.original import confirmed, excuses
from mechstyle.simulation.part import Shape, Stage, Workpiece, cached_memo, fitted, prepare, say_nothing
from mechstyle.simulation.physics import period_of, prescribed
from mechstyle.simulation.simulator import Detail, DropSimulator

if TYPE_CHECKING:
    from mechstyle.pictures.figure import Panel


@dataclass(frozen=True, eq=False)
class PartTest:
    """A part and what its drop test said.

    Attributes:
        part: The prepared part.
        recipe: Material, drop and criterion.
        simulation: What was measured.
        verdict: What it means.
        warning: That its original exceeds the material's strength or seems to be another part, and which walls are thinner than the
            printer's thinnest, in sentences; "" for nothing.
        tets: The tetrahedra that were dropped.
        detail: The test in full.
        impact: The drop as placed, moment by moment; None for one that failed.
        fit: How the tetrahedra follow the part as it was given.
        original: The same test of what the part is compared with, as far as other tetrahedra confirm what it reads above its strength;
            None if that was not told.
    """

    part: Workpiece
    recipe: Recipe
    simulation: Simulation
    verdict: Verdict
    warning: str
    tets: TetMesh
    detail: Detail
    impact: Impact | None
    fit: Fit
    original: Simulation | None = None

    @property
    def strength(self) -> Strength:
        """The verdict in figures."""
        return Strength.of(self.verdict, self.simulation)

    @property
    def history(self) -> History:
        """Energies, contact force and largest stress of the drop as placed over time."""
        return self.detail.drop.history[0]

    @cached_property
    def course(self) -> Course | None:
        """The drop as placed over time, in figures; None for one that failed."""
        if self.impact is None:
            return None
        return Course.of(self.detail.drop, self.impact, self.part.surface.vertices, self.detail.balance_error)

    def show(self) -> Picture:
        """Stress as placed from three sides; below it the worst of several orientations, and the probability if they are random drops."""
        limit, surface, simulation = self.verdict.deciding.limit, self.part.surface, self.simulation
        first = "stress, dropped and loaded" if simulation.loaded else "stress as placed"
        stress, note = fields.stress(limit), verdict_note(self.verdict)
        panels = [field_panel(surface, stress, simulation.stress, title=first, note=note)]
        for view, title in (("front", "from the front"), ("below", "from below")):
            panels.append(field_panel(surface, stress, simulation.stress, title=title, view=view))
        if simulation.overall is not None:
            worst = f"worst of {len(self.detail.drop.von_mises)} orientations"
            for view, title in (("three_quarter", worst), ("below", "from below")):
                panels.append(field_panel(surface, fields.envelope(limit), simulation.envelope, title=title, view=view))
        if self.simulation.failure_probability is not None:
            panels.append(self._probability_panel())
        return picture(panels, columns=3)

    def _probability_panel(self) -> Panel:
        whole = f"{self.simulation.failure_probability:.0%} of random drops begin to yield it somewhere"
        exceeding = fields.probability(self.recipe.material.yield_strength)
        return field_panel(self.part.surface, exceeding, self.simulation.probability, title="failure probability", note=whole)

    def show_history(self) -> Picture:
        """Peak stress, energies and contact force of the drop as placed over time.

        Raises:
            SimulationFailed: If the drop failed.
        """
        if self.impact is None or self.course is None:
            raise SimulationFailed(self.simulation.failure)
        return history_picture(self.history, self.impact, self.course, self.verdict.of_the_drop)

    def save_vtu(self, path: str | Path, *, each_orientation: bool = False) -> Path:
        """Write displacement, stress and contact in the body for ParaView; `drop_history.vtu_bytes` lists the fields.

        Args:
            path: A file that ends in .vtu.
            each_orientation: Whether to add stress and contact of every orientation.

        Raises:
            BadInput: If the file has another ending.
            SimulationFailed: If the drop failed.
        """
        target = vtu_path(path)
        if self.course is None:
            raise SimulationFailed(self.simulation.failure)
        period = period_of(lambda: self.part.tets, self.recipe, cached_memo())
        at = snapshot(self.tets, self.recipe.material, prescribed(self.recipe), self.course.peak_time, period)
        allowable = self.recipe.material.yield_strength
        probabilities = [landing.weight for landing in self.simulation.landings] if self.recipe.random_drops else []
        write_whole(target, vtu_bytes(self.tets, self.detail.drop, at, probabilities, allowable, each=each_orientation))
        return target


def simulate(
    mesh: SurfaceMesh,
    *,
    original: SurfaceMesh | None = None,
    material: str | Material = "PLA",
    orientations: int | None = None,
    poses: str | None = None,
    tilts: int = DEFAULTS["tilts"],
    standard: str = DEFAULTS["standard"],
    criterion: str = DEFAULTS["criterion"],
    loads: str | Path | LoadCase | Sequence[LoadCase] = (),
    minimum_wall: float = DEFAULTS["minimum_wall"],
    build_direction: str | Sequence[float] | None = None,
    window: float | None = DEFAULTS["window"],
    vertices: int = STANDARD_VERTICES,
    device: str = "auto",
    stage: Stage = say_nothing,
    progress: Progress = no_progress,
    measured: Callable[[Shape], None] = say_nothing,
) -> PartTest:
    """Drop a part as it is.

    Args:
        mesh: A closed surface [mm], z up, as it stands.
        original: What it was styled from, in the same place: that is dropped, too, and it is judged by the rules of a run. None judges it
            alone, by the strength of its material.
        material: A library name, a .toml/.json file, or a Material.
        orientations: Drops, the first as placed; by default as many as the poses or the standard need.
        poses: How the others land, one of `Recipe.poses`: every way by default.
        tilts: Drops tilted by 3° to all sides besides; 0 takes exactly flat at its word.
        standard: Drop standard whose orientations and height are simulated, such as `mil-810h`; the verdict is no test to it.
        criterion: `robust` or `paper`.
        loads: A load file or load cases the part must carry besides.
        minimum_wall: The thinnest wall that is not warned about [mm]; 0 for no warning.
        build_direction: Direction it is printed in, x, y, z or a vector, so that layers are judged by their own strength; None to leave
            layers out.
        window: Simulated time after first touch [ms]; unless told, until the impact has ended.
        vertices: Vertices of the standardised surface.
        device: `auto`, `cpu` or `cuda`.
        stage: Told what is being prepared, in words.
        progress: Called with the fraction of the drop done; may raise to cancel.
        measured: Told the part's surface and walls, before the minutes that meshing and drop may take.

    Raises:
        BadInput: If the part or a setting cannot be used, in one sentence.
    """
    chosen, where = material_named(material), resolve_device(device)
    landings = {name: value for name, value in (("orientations", orientations), ("poses", poses)) if value is not None}
    wanted = Recipe(
        surface="", tetrahedra="", prompt="", material=chosen, criterion=criterion, loads=load_cases(loads), minimum_wall=minimum_wall,
        window=window, tilts=tilts,
        build_direction=None if build_direction is None else direction_of(build_direction),
        **with_drops({"standard": standard, **landings}),
    )  # fmt: skip
    part = prepare(mesh, vertices=vertices, stage=stage, measured=measured)
    plain = None if original is None else prepare(original, vertices=vertices, stage=stage)
    return _tested((mesh, original), part, plain, wanted, where, stage, progress)


def _tested(
    given: tuple[SurfaceMesh, SurfaceMesh | None], part: Workpiece, plain: Workpiece | None, wanted: Recipe,
    device: str, stage: Stage, progress: Progress,
) -> PartTest:  # fmt: skip
    """The test of a prepared part, beside its prepared original if there is one; `given` are both as they came."""

    def dropper(one: Workpiece) -> DropSimulator:
        return DropSimulator(one.surface, one.tets, fitted(wanted, one), memo, device=device, progress=progress)

    memo, material, recipe = cached_memo(), wanted.material, fitted(wanted, part)
    unstyled = np.zeros(len(part.surface.vertices), np.float32)
    stage("dropping it")
    tets, detail = dropper(part).detail(unstyled)
    fit, simulation, original = fit_of(tets, *given), detail.simulation, None
    if plain is None or fit.relief is None:
        verdict = judge_alone(simulation, material, wanted.criterion)
    else:
        stage("dropping its original")
        original = _confirmed(plain, dropper, material, stage, progress)
        simulation = replace(simulation, carried=fit.relief.carried, carried_base=fit.relief.carried_base)
        verdict = judge(simulation, original, material, wanted.criterion)
    stage("looking at the impact")
    impact = None if detail.drop.failure else impact_of(part, recipe, unstyled, memo, progress)
    thin = (f"{sentence}." for sentence in part.shape.too_thin(wanted.minimum_wall))
    other = "" if given[1] is None else other_part(given[0], given[1])
    before = "" if original is None else input_warning(original, material)  # what a part alone exceeds is its verdict
    warning = " ".join(filter(None, (other, before, *thin)))
    return PartTest(part, recipe, simulation, verdict, warning, tets, detail, impact, fit, original)


def _confirmed(
    plain: Workpiece, dropper: Callable[[Workpiece], DropSimulator], material: Material, stage: Stage, progress: Progress
) -> Simulation:
    """The test of an original; where it reads above its strength, no more of it than other tetrahedra confirm, as in a run."""
    own = dropper(plain).baseline
    if not excuses(own, material):
        return own
    stage("dropping its original on other tetrahedra")
    try:
        others = dropper(replace(plain, tets=others_at_rest(plain.surface, partial(progress, 0.0))))
        here = others.simulate(np.zeros(len(plain.surface.vertices), np.float32), thorough=False)
    except SimulationFailed as error:
        here = replace(own, failure=str(error))
    return confirmed(own, here, material)


def judge_alone(simulation: Simulation, material: Material, criterion: str) -> Verdict:
    """Whether a part that has no original to be compared with survives: its stress as placed and under loads against the yield strength.

    The rules on other landings compare with the original and therefore do not apply; what tilted landings do is told with the words.
    An original without stress leaves nothing but the yield strength of `fea.verdict.judge`.
    """
    as_placed = replace(simulation, overall=None)
    nothing = msgspec.structs.replace(simulation.as_placed, peak=0.0, surface=0.0, contact=0.0)
    unloaded = replace(as_placed, as_placed=nothing, tilted=None, dropped=None, loaded=())
    verdict = judge(as_placed, unloaded, material, criterion)
    if simulation.tilted is None or simulation.failure:
        return verdict
    reached = simulation.tilted.surface
    beyond = " and begins to yield" if reached > material.yield_strength else ""
    return msgspec.structs.replace(verdict, words=f"{verdict.words} Tilted by a few degrees its surface reaches {reached:.1f} MPa{beyond}.")
