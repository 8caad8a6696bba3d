"""From a displaced surface to what stays bent of it: morph the tetrahedra, drop and load them, bring the fields to the surface, judge.

A landing is the unit: it is dropped once and remembered by its own key, whoever asks for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import SimulationFailed
from mechstyle.fea.discretisation import Relative
from mechstyle.fea.drop import Drop, History, drop
from mechstyle.fea.elements import at_vertices
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.orientations import Orientations
from mechstyle.fea.permanent_set import measured
from mechstyle.fea.statics import StaticTest
from mechstyle.geometry.morph import Morphed
from mechstyle.loop.control import YIELDED
from mechstyle.loop.objects import Memo, Memos
from mechstyle.records import Landing, LoadResult, Recipe, Simulation, Verdict, judge
from mechstyle.records.material import Material
from mechstyle.records.mesh import TetMesh, digest_of
from mechstyle.records.simulation import Place, place_in_words
from mechstyle.simulation.meshes import MORPHED, Body, Meshes
from mechstyle.simulation.part import Workpiece
from mechstyle.simulation.physics import PHYSICS_VERSION, landings_of, memo_key, period_of, physics, prescribed
from mechstyle.simulation.printed import plastic_share, printed_body

STEERING = 2
"""Nearly flat landings that are dropped while a relief grows: those after which most of the original stays bent."""


def _no_field() -> NDArray[np.float32]:
    """Of a test that failed, and what an elastic body has none of."""
    return np.zeros(0, np.float32)


@dataclass(frozen=True, eq=False, kw_only=True)
class Landed:
    """One landing with its fields at the surface, each as in `Simulation`; the history is kept of the flat one alone."""

    landing: Landing | None
    contact: NDArray[np.bool_]
    time_step: float
    steps: int
    added_mass: float
    history: History | None
    stress: NDArray[np.float32] = field(default_factory=_no_field)
    strain: NDArray[np.float32] = field(default_factory=_no_field)
    bend: NDArray[np.float32] = field(default_factory=_no_field)
    failure: str = ""


@dataclass(frozen=True, eq=False, kw_only=True)
class UnderLoads:
    """The load cases with their fields at the surface, each as in `Simulation`."""

    results: tuple[LoadResult, ...] = ()
    stress: NDArray[np.float32] = field(default_factory=_no_field)
    strain: NDArray[np.float32] = field(default_factory=_no_field)
    bend: NDArray[np.float32] = field(default_factory=_no_field)
    failure: str = ""


@dataclass(frozen=True, eq=False)
class DropSimulator:
    """The drop test of one part under one recipe.

    Attributes:
        part: The prepared part.
        recipe: What decides the physics: material, drop, orientations, transfer.
        memo: Where results are remembered by the digest of their inputs.
        shared: The same of the unstylized part for other runs too, once computed here; None for nowhere.
        device: `cpu` or `cuda`.
        progress: Called with the fraction done, and while tetrahedra are made; may raise to cancel.
        enlarged: Times larger than asked the pattern of the reliefs is.
    """

    part: Workpiece
    recipe: Recipe
    memo: Memo
    shared: Memo | None = None
    device: str = "cpu"
    progress: Progress = field(default=no_progress)
    enlarged: float = 1.0

    @cached_property
    def meshes(self) -> Meshes:
        """The tetrahedra that serve the part and its reliefs."""
        part, recipe = self.part, self.recipe
        first = Body(part.shape, part.tets, recipe.delivery.nozzle, recipe.test.transfer, part.at)
        # A folder that holds another part than its recipe names teaches other runs nothing, and learns nothing from them.
        claimed = part.surface.digest != recipe.test.specimen.surface
        return Meshes(first, self.memo, None if claimed else self.shared, recipe.digest, self.progress)

    @cached_property
    def landings(self) -> Orientations:
        """Landings of the unstylized part, so that both are compared in the same: flat, nearly flat, then the others."""
        return landings_of(self.part.surface, self.recipe)

    @cached_property
    def baseline(self) -> Simulation:
        """The unstylized part in all landings, on tetrahedra of its own."""
        return self.simulate(np.zeros(len(self.part.surface.vertices), np.float32), thorough=True)

    def simulate(self, displacement: NDArray[np.float32], *, thorough: bool) -> Simulation:
        """Drop the displaced part, flat and in the hardest nearly flat landings or (`thorough`) in all, and load it; remembered.

        A thorough test rests on tetrahedra that follow the relief.
        """
        follow = thorough or not np.any(displacement)
        body, meshing = self.meshes.mesh_for(displacement) if follow else (self.meshes.first, MORPHED)
        return self._tested(body, body.morph.morphed(displacement), self._numbers(displacement, thorough=thorough), meshing)

    def judge(self, simulation: Simulation, *, alone: bool = False) -> Verdict:
        """Verdict on a simulation and that of the original, or `alone` on the original itself."""
        return judge(simulation, None if alone else self.baseline, self.recipe)

    def morphed(self, simulation: Simulation) -> tuple[Body, Morphed]:
        """The tetrahedra of a test, and as they were moved for it; SimulationFailed if this run has them no more."""
        body = self.meshes.known(simulation.mesh) or self.meshes.plain[0]
        if body.tets.digest != simulation.mesh:
            raise SimulationFailed("the tetrahedra of this test are gone: test the part again")
        return body, body.morph.morphed(simulation.displacement)

    def history(self, simulation: Simulation) -> History:
        """Energies and forces of the flat landing of a test over time."""
        history = self._landed(*self.morphed(simulation), [0])[0].history
        assert history is not None, "that of the flat landing is kept"
        return history

    @cached_property
    def period(self) -> float | None:
        """Of `period_of`."""
        shared = self.meshes.shared
        return period_of(lambda: self.meshes.plain[0].tets, self.recipe, Memos((self.memo,) if shared is None else (shared, self.memo)))

    def _numbers(self, displacement: NDArray[np.float32], *, thorough: bool) -> tuple[int, ...]:
        """Numbers of the landings in which a displaced part is dropped."""
        if thorough or not np.any(displacement) or self.baseline.failure:
            return tuple(range(len(self.landings.names)))
        nearly = [number for number, landing in enumerate(self.baseline.landings) if landing.way == "nearly flat"]
        hardest = sorted(nearly, key=lambda number: -self.baseline.landings[number].permanent_set)[:STEERING]
        return (0, *sorted(hardest))

    def _tested(self, body: Body, morphed: Morphed, numbers: Sequence[int], meshing: str) -> Simulation:
        """A test on these very tetrahedra: what is known of it is recalled, the rest dropped and loaded."""
        static = self._static(body) if self.recipe.test.loads else None
        landed = self._landed(body, morphed, numbers)
        failure = next((one.failure for one in landed if one.failure), "")
        loads = UnderLoads() if failure or static is None else self._under_loads(static, body, morphed)
        fit = body.followed(morphed)
        found = Simulation(
            displacement=morphed.displacement, contact=landed[0].contact, backed_off=morphed.backed_off, deviation=morphed.deviation,
            carried=fit.whole, thicker=fit.thicker, grounded=fit.grounded, volume_error=fit.volume,
            enlarged=self.enlarged if np.any(morphed.displacement) else 1.0,
            volume=float(morphed.tets.volumes.sum()),
            plastic_share=1.0 if self.recipe.printed.solid else plastic_share(morphed.tets, self.recipe),
            mesh=body.tets.digest, level_share=body.shape.level_base.share(morphed.displacement), meshing=meshing,
            time_step=landed[0].time_step, steps=max(one.steps for one in landed), added_mass=landed[0].added_mass,
            failure=failure or loads.failure,
        )  # fmt: skip
        if found.failure:
            return found
        stress, strain, bend = (np.stack([getattr(one, name) for one in landed]) for name in ("stress", "strain", "bend"))
        return replace(
            found, landings=tuple(one.landing for one in landed if one.landing is not None), landing_stress=stress,
            landing_strain=strain, landing_set=bend, loads=loads.results, load_stress=loads.stress, load_strain=loads.strain,
            load_set=loads.bend,
        )  # fmt: skip

    # --- landings ---

    def _landed(self, body: Body, morphed: Morphed, numbers: Sequence[int]) -> list[Landed]:
        """The landings of these numbers, under the names they have here; those that nobody remembers are dropped together."""
        memos, ways = self._memos(body, morphed), self.landings
        keys = {number: self._key("landing", body, morphed, ways.normals[number].tolist()) for number in numbers}
        found = {number: memos.recall(key, Landed) for number, key in keys.items()}
        missing = [number for number, one in found.items() if one is None]
        for number, (result, index) in zip(missing, self._each_dropped(morphed.tets, missing), strict=True):
            found[number] = landed = self._brought(body, morphed, result, index, number)
            memos.remember(keys[number], landed)
        called = {number: {"name": ways.names[number], "way": ways.ways[number]} for number in numbers}
        return [
            replace(one, landing=one.landing and msgspec.structs.replace(one.landing, **called[number]))
            for number, one in found.items() if one is not None
        ]  # fmt: skip

    def _each_dropped(self, tets: TetMesh, numbers: Sequence[int]) -> list[tuple[Drop, int]]:
        """The drop of each landing, and its number there.

        If one breaks down, each is dropped by itself, so that no other is lost with it.
        """
        if not numbers:
            return []
        result = self.dropped(tets, numbers)
        if not result.failure or len(numbers) == 1:
            return [(result, index) for index in range(len(numbers))]
        return [(self.dropped(tets, [number]), 0) for number in numbers]

    def dropped(self, tets: TetMesh, numbers: Sequence[int]) -> Drop:
        """A drop of tetrahedra in the landings of these numbers, in full."""
        normals, test = self.landings.normals[list(numbers)], prescribed(self.recipe)
        return drop(
            tets, self.recipe.test.material, normals, test, device=self.device, progress=self.progress, period=self.period,
            relative=self._inside(tets),
        )  # fmt: skip

    def _inside(self, tets: TetMesh) -> Relative | None:
        """What the tetrahedra of a print have of the properties of its plastic; None where they are solid."""
        return None if self.recipe.printed.solid else printed_body(tets, self.recipe)

    def _brought(self, body: Body, morphed: Morphed, result: Drop, index: int, number: int) -> Landed:
        """One landing of a drop in figures, and its fields at the surface; none, with the reason, where the drop failed."""
        tets, test, name = morphed.tets, self.recipe.test, self.landings.names[number]
        landed = Landed(
            landing=None, contact=body.contact_at_surface(result.contact[index]), time_step=result.time_step, steps=result.steps,
            added_mass=result.added_mass, history=None if number else result.history[index],
            failure=f"in the landing {name!r} {result.failure}" if result.failure else "",
        )  # fmt: skip
        if result.failure:
            return landed
        place: Place = (0.0, 0.0, 0.0)
        permanent_set = plastic_strain = 0.0
        stress = body.field_at_surface(at_vertices(tets, result.von_mises[index]))
        if test.criterion != "paper":
            relative = self._inside(tets)
            density = 1.0 if relative is None else relative.density
            permanent_set, place, plastic_strain = measured(tets, result.permanent[index], result.tension_strain[index], density)
            strain = body.field_at_surface(at_vertices(tets, result.plastic_strain[index]))
            stress = flow_stress(stress, strain, test.material)
            landed = replace(landed, strain=strain, bend=body.displacement_at_surface(result.permanent[index]))
        x, y, z = (float(part) for part in self.landings.normals[number])
        landing = Landing(
            name=name, way=self.landings.ways[number], normal=(x, y, z), fall=test.height, permanent_set=permanent_set,
            plastic_strain=plastic_strain, where=place, place=_named(tets, place) if permanent_set else "",
            maximum=float(result.von_mises[index].max()), touches=tuple(phase.speed for phase in result.phases[index]),
            ended=result.endings[index],
        )  # fmt: skip
        return replace(landed, landing=landing, stress=stress)

    # --- loads ---

    def _static(self, body: Body) -> StaticTest:
        """The load cases, their places picked on the plain part and looked at before the long drop."""
        plain = body.morph.morphed(np.zeros(len(self.part.surface.vertices), np.float32)).tets
        static = StaticTest(plain, self.recipe.test.loads, self.recipe.test.element)
        static.check()
        return static

    def _under_loads(self, static: StaticTest, body: Body, morphed: Morphed) -> UnderLoads:
        """The recipe's load cases on moved tetrahedra; remembered."""
        memos, key = self._memos(body, morphed), self._key("loads", body, morphed, (self.recipe.test.loads, self.recipe.test.tolerance))
        found = memos.recall(key, UnderLoads)
        if found is None:
            found = self._loaded(static, body, morphed.tets)
            memos.remember(key, found)
        return found

    def _loaded(self, static: StaticTest, body: Body, tets: TetMesh) -> UnderLoads:
        test, elastic = self.recipe.test, self.recipe.test.criterion == "paper"
        try:
            cases = static.loaded(
                tets, test.material, across=test.across_layers, tolerance=test.tolerance, elastic=elastic, progress=self.progress,
                relative=self._inside(tets),
            ).values()  # fmt: skip
        except SimulationFailed as error:
            return UnderLoads(failure=str(error))

        strains = [body.field_at_surface(case.strain) for case in cases]
        stresses = [body.field_at_surface(case.stress) for case in cases]
        if not elastic:
            stresses = [flow_stress(stress, strain, test.material) for stress, strain in zip(stresses, strains, strict=True)]
        bends = [body.displacement_at_surface(case.displacement) for case in cases]
        places = [_named(tets, one.result.where) if one.result.permanent_set else "" for one in cases]
        results = tuple(msgspec.structs.replace(one.result, place=place) for one, place in zip(cases, places, strict=True))
        return UnderLoads(results=results, stress=np.stack(stresses), strain=np.stack(strains), bend=np.stack(bends))

    # --- what is remembered ---

    def _key(self, what: str, body: Body, morphed: Morphed, asked: object) -> str:
        """The name of a result: physics, the moved tetrahedra, how their fields get to the surface, and what was asked."""
        recipe = self.recipe.on(surface=self.part.surface.digest, tetrahedra=morphed.tets.digest)
        at = "" if body.at is None else digest_of(body.at)
        return memo_key((what, PHYSICS_VERSION, self.device, *physics(recipe), at, asked), np.empty(0, np.float32))

    def _memos(self, body: Body, morphed: Morphed) -> Memos:
        """Where results on these tetrahedra are remembered: those of the plain part serve other runs."""
        on_plain = not np.any(morphed.displacement) and not body.made_for_relief
        return self.meshes.plain[1] if on_plain else Memos((self.memo,))


def _named(tets: TetMesh, place: Place) -> str:
    """A place of a part in words."""
    low, high = (msgspec.convert(end(tets.vertices, axis=0).tolist(), Place) for end in (np.min, np.max))
    return place_in_words(place, low, high)


BEYOND = 1e-3
"""Share by which the stress of a place that has yielded is at least above the yield strength: what lies above it is hatched."""


def flow_stress(stress: NDArray[np.float32], strain: NDArray[np.float32], material: Material) -> NDArray[np.float32]:
    """Stress at the surface [MPa]: the flow stress where it has yielded, and at most the yield strength elsewhere.

    A mean over 2 mm hides a hinge that is narrower, and a line through Gauss points rises above what the material can bear. All of shape
    [vertex_count], `strain` the plastic one.
    """
    strength = material.yield_strength
    flows = strength * (1.0 + BEYOND) + material.hardening * strain
    return np.where(strain > YIELDED, flows, np.minimum(stress, strength)).astype(np.float32)
