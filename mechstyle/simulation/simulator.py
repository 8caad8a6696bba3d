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
from mechstyle.fea.drop import Drop, drop
from mechstyle.fea.elements import element_named
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.orientations import Orientations
from mechstyle.fea.permanent_set import at_nodes, measured
from mechstyle.fea.statics import Loaded, StaticTest
from mechstyle.geometry.morph import Morphed
from mechstyle.loop.control import YIELDED
from mechstyle.loop.objects import Memo
from mechstyle.records import Landing, LoadResult, Recipe, Simulation, Verdict, judge
from mechstyle.records.material import Material
from mechstyle.records.mesh import TetMesh, digest_of
from mechstyle.records.simulation import Place, place_in_words
from mechstyle.simulation.meshes import MORPHED, Body, Meshes
from mechstyle.simulation.part import Workpiece
from mechstyle.simulation.physics import PHYSICS_VERSION, landings_of, memo_key, period_of, physics, prescribed

STEERING = 2
"""Nearly flat landings that are dropped while a relief grows: those after which most of the original stays bent."""


@dataclass(frozen=True, eq=False)
class Landed:
    """One landing with its fields at the surface, each as in `Simulation`."""

    landing: Landing | None
    stress: NDArray[np.float32]
    strain: NDArray[np.float32]
    bend: NDArray[np.float32]
    contact: NDArray[np.bool_]
    time_step: float
    steps: int
    added_mass: float
    failure: str = ""


@dataclass(frozen=True, eq=False)
class UnderLoads:
    """The load cases with their fields at the surface, each as in `Simulation`."""

    results: tuple[LoadResult, ...]
    stress: NDArray[np.float32]
    strain: NDArray[np.float32]
    bend: NDArray[np.float32]
    failure: str = ""


@dataclass(frozen=True, eq=False)
class Detail:
    """A drop test in full.

    Attributes:
        simulation: What it left on the surface.
        drop: Stress in the body, and history in time, of every orientation.
        balance_error: Largest error of energy of the flat drop without damping, over the energy at first touch; None if it failed.
    """

    simulation: Simulation
    drop: Drop
    balance_error: float | None


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
    """

    part: Workpiece
    recipe: Recipe
    memo: Memo
    shared: Memo | None = None
    device: str = "cpu"
    progress: Progress = field(default=no_progress)

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
        body, meshing = self.meshes.carrier(displacement) if follow else (self.meshes.first, MORPHED)
        return self._tested(body, displacement, self._numbers(displacement, thorough=thorough), meshing)

    def judge(self, simulation: Simulation, *, alone: bool = False) -> Verdict:
        """Verdict on a simulation and that of the original, or `alone` on the original itself."""
        return judge(simulation, None if alone else self.baseline, self.recipe)

    def detail(self, displacement: NDArray[np.float32]) -> tuple[TetMesh, Detail]:
        """The moved tetrahedra and the whole drop test in all landings, with its history in time; remembered as well."""
        body, meshing = self.meshes.carrier(displacement)
        morphed, numbers = body.morph.morphed(displacement), self._numbers(displacement, thorough=True)
        asked = (self.landings.normals.tolist(), self.landings.names, self.recipe.test.loads, self.recipe.test.tolerance)
        key = f"{self._key('detail', body, morphed, asked)}-detail"
        detail = self.memo.recall(key, Detail)
        if detail is None:
            self._static(body).check()
            result, balance = self._dropped(morphed.tets, numbers), None
            if not result.failure:  # once more through its first phase, without damping, which takes what is missing
                undamped = replace(prescribed(self.recipe), damping=0.0, window=result.phases[0][0].end)
                material, flat = self.recipe.test.material, self.landings.normals[:1]
                again = drop(morphed.tets, material, flat, undamped, device=self.device, progress=self.progress)
                balance = None if again.failure else float(np.abs(again.history[0].damping_loss).max() / again.history[0].kinetic[0])
                for index, number in enumerate(numbers):
                    self._remember(body, morphed, number, self._brought(body, morphed, result, index, number))
            detail = Detail(self._tested(body, displacement, numbers, meshing), result, balance)
            self.memo.remember(key, detail)
        return morphed.tets, detail

    @cached_property
    def period(self) -> float | None:
        """Of `period_of`."""
        return period_of(lambda: self.meshes.plain[0].tets, self.recipe, self.memo, self.meshes.shared)

    def _numbers(self, displacement: NDArray[np.float32], *, thorough: bool) -> tuple[int, ...]:
        """Numbers of the landings in which a displaced part is dropped."""
        every = tuple(range(len(self.landings.names)))
        if thorough or not np.any(displacement) or self.baseline.failure:
            return every
        nearly = [number for number, landing in enumerate(self.baseline.landings) if landing.way == "nearly flat"]
        hardest = sorted(nearly, key=lambda number: -self.baseline.landings[number].permanent_set)[:STEERING]
        return (0, *sorted(hardest))

    def _tested(self, body: Body, displacement: NDArray[np.float32], numbers: Sequence[int], meshing: str) -> Simulation:
        """A test on these very tetrahedra: what is known of it is recalled, the rest dropped and loaded."""
        morphed = body.morph.morphed(displacement)
        self._static(body).check()  # before the long drop
        landed = self._landed(body, morphed, numbers)
        failure = next((one.failure for one in landed if one.failure), "")
        loads = UnderLoads((), *self._nothing(0)) if failure or not self.recipe.test.loads else self._under_loads(body, morphed)
        fit = body.followed(morphed)
        found = Simulation(
            displacement=morphed.displacement, contact=landed[0].contact, backed_off=morphed.backed_off, deviation=morphed.deviation,
            carried=fit.whole, thicker=fit.thicker, grounded=fit.grounded, volume_error=fit.volume,
            volume=float(morphed.tets.volumes.sum()),
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

    def _landed(self, body: Body, morphed: Morphed, numbers: Sequence[int]) -> list[Landed]:
        """The landings of these numbers; those that nobody remembers are dropped together."""
        known = {number: self._recall(body, morphed, number) for number in numbers}
        missing = [number for number, one in known.items() if one is None]
        if missing:
            for number, (result, index) in zip(missing, self._each_dropped(morphed.tets, missing), strict=True):
                known[number] = self._brought(body, morphed, result, index, number)
        found = list[Landed]()
        for number, one in known.items():
            assert one is not None, "what was missing was dropped"
            self._remember(body, morphed, number, one)
            found.append(one)
        return found

    def _each_dropped(self, tets: TetMesh, numbers: Sequence[int]) -> list[tuple[Drop, int]]:
        """The drop of each landing, and its number there.

        If one breaks down, each is dropped by itself, so that no other is lost with it.
        """
        result = self._dropped(tets, numbers)
        if not result.failure or len(numbers) == 1:
            return [(result, index) for index in range(len(numbers))]
        return [(self._dropped(tets, [number]), 0) for number in numbers]

    def _dropped(self, tets: TetMesh, numbers: Sequence[int]) -> Drop:
        normals, test = self.landings.normals[list(numbers)], prescribed(self.recipe)
        return drop(tets, self.recipe.test.material, normals, test, device=self.device, progress=self.progress, period=self.period)

    def _brought(self, body: Body, morphed: Morphed, result: Drop, index: int, number: int) -> Landed:
        """One landing of a drop in figures, and its fields at the surface; none, with the reason, where the drop failed."""
        stress, strain, bend = (one[0] for one in self._nothing(1))
        contact = body.contact_at_surface(result.contact[index])
        figures = (result.time_step, result.steps, result.added_mass)
        if result.failure:
            return Landed(None, stress, strain, bend, contact, *figures, result.failure)
        tets, way, elastic = morphed.tets, self.landings, self.recipe.test.criterion == "paper"
        place: Place = (0.0, 0.0, 0.0)
        element = element_named(self.recipe.test.element)
        permanent_set = plastic_strain = 0.0
        if not elastic:
            permanent_set, place, plastic_strain = measured(tets, result.permanent[index], result.tension_strain[index])
            strain = body.field_at_surface(at_nodes(tets, element.at_corners(result.plastic_strain[index])))
            bend = body.displacement_at_surface(result.permanent[index])
        x, y, z = (float(part) for part in way.normals[number])
        landing = Landing(
            name=way.names[number], way=way.ways[number], normal=(x, y, z), fall=self.recipe.test.height, permanent_set=permanent_set,
            plastic_strain=plastic_strain, where=place, place=self._named(morphed, place) if permanent_set else "",
            maximum=float(result.von_mises[index].max()), touches=tuple(phase.speed for phase in result.phases[index]),
            ended=result.endings[index],
        )  # fmt: skip
        stress = body.field_at_surface(at_nodes(tets, element.at_corners(result.von_mises[index])))
        shown = stress if elastic else flow_stress(stress, strain, self.recipe.test.material)
        return Landed(landing, shown, strain, bend, contact, *figures)

    def _named(self, morphed: Morphed, place: Place) -> str:
        low, high = (msgspec.convert(end(morphed.tets.vertices, axis=0).tolist(), Place) for end in (np.min, np.max))
        return place_in_words(place, low, high)

    def _nothing(self, count: int) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Stress, strain and bend of no test, for so many tests."""
        scalars = np.zeros((count, len(self.part.surface.vertices)), np.float32)
        return scalars, scalars, np.zeros((*scalars.shape, 3), np.float32)

    # --- what is remembered ---

    def _key(self, what: str, body: Body, morphed: Morphed, asked: object) -> str:
        """The name of a result: physics, the moved tetrahedra, how their fields get to the surface, and what was asked."""
        recipe = self.recipe.on(surface=self.part.surface.digest, tetrahedra=morphed.tets.digest)
        at = "" if body.at is None else digest_of(body.at)
        return memo_key((what, PHYSICS_VERSION, self.device, *physics(recipe), at, asked), np.empty(0, np.float32))

    def _memos(self, body: Body, morphed: Morphed) -> tuple[Memo, ...]:
        """Where results on these tetrahedra are remembered, the most trusted first: those of the plain part serve other runs."""
        on_plain = not np.any(morphed.displacement) and not body.made_for_relief
        return self.meshes.plain[1] if on_plain else (self.memo,)

    def _recall(self, body: Body, morphed: Morphed, number: int) -> Landed | None:
        key = self._key("landing", body, morphed, self.landings.normals[number].tolist())
        found = next((one for memo in self._memos(body, morphed) if (one := memo.recall(key, Landed)) is not None), None)
        if found is None or found.landing is None:
            return found
        name, way = self.landings.names[number], self.landings.ways[number]  # the same landing under the name it has here
        return replace(found, landing=msgspec.structs.replace(found.landing, name=name, way=way))

    def _remember(self, body: Body, morphed: Morphed, number: int, landed: Landed) -> None:
        key, memos = self._key("landing", body, morphed, self.landings.normals[number].tolist()), self._memos(body, morphed)
        known = any(memo.recall(key, Landed) is not None for memo in memos)
        for memo in memos[-1:] if known else memos:  # others may have written a run folder: only what was computed here is for all
            memo.remember(key, landed)

    # --- loads ---

    def _static(self, body: Body) -> StaticTest:
        """The load cases, their places picked on the plain part."""
        plain = body.morph.morphed(np.zeros(len(self.part.surface.vertices), np.float32)).tets if self.recipe.test.loads else body.tets
        return StaticTest(plain, self.recipe.test.loads, self.recipe.test.element)

    def _under_loads(self, body: Body, morphed: Morphed) -> UnderLoads:
        """The recipe's load cases on moved tetrahedra; remembered."""
        memos, key = self._memos(body, morphed), self._key("loads", body, morphed, (self.recipe.test.loads, self.recipe.test.tolerance))
        found = next((one for memo in memos if (one := memo.recall(key, UnderLoads)) is not None), None)
        if found is None:
            found = self._loaded(body, morphed)
        else:
            memos = memos[-1:]
        for memo in memos:
            memo.remember(key, found)
        return found

    def _loaded(self, body: Body, morphed: Morphed) -> UnderLoads:
        tets, test = morphed.tets, self.recipe.test
        try:
            cases = self._static(body).loaded(
                tets, test.material, across=test.across_layers, tolerance=test.tolerance, elastic=test.criterion == "paper",
                progress=self.progress,
            )  # fmt: skip
        except SimulationFailed as error:
            return UnderLoads((), *self._nothing(0), str(error))

        def result(name: str, case: Loaded) -> LoadResult:
            return LoadResult(
                name=name, permanent_set=case.permanent_set, plastic_strain=case.plastic_strain, where=case.where,
                place=self._named(morphed, case.where) if case.permanent_set else "", maximum=case.maximum, deflection=case.deflection,
                factor=case.factor, reached=case.reached, collapses=case.collapses,
            )  # fmt: skip

        strains = [body.field_at_surface(case.strain) for case in cases.values()]
        stresses = [body.field_at_surface(case.stress) for case in cases.values()]
        if test.criterion != "paper":
            stresses = [flow_stress(stress, strain, test.material) for stress, strain in zip(stresses, strains, strict=True)]
        return UnderLoads(
            tuple(result(name, case) for name, case in cases.items()), np.stack(stresses), np.stack(strains),
            np.stack([body.displacement_at_surface(case.displacement) for case in cases.values()]),
        )  # fmt: skip


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
