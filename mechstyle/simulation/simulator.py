"""From a displaced surface to the stress on it: morph the tetrahedra, drop and load them, read σ_V, bring the stress back, judge."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import SimulationFailed
from mechstyle.fea.drop import Drop, drop
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.orientations import Orientations
from mechstyle.fea.statics import StaticTest
from mechstyle.fea.stressed_volume import DROPPED, LOADED, Exceeded, at_nodes, exceeded
from mechstyle.geometry.morph import Morphed
from mechstyle.loop.objects import Memo
from mechstyle.records import Landing, LoadResult, Recipe, Simulation, Verdict, judge
from mechstyle.records.mesh import Floats, TetMesh, digest_of
from mechstyle.records.simulation import GREATEST_HEIGHT, LEAST_HEIGHT, Way
from mechstyle.simulation.meshes import Body, Meshes
from mechstyle.simulation.part import Workpiece
from mechstyle.simulation.physics import PHYSICS_VERSION, landings_of, memo_key, period_of, physics, prescribed

STEERING = 2
"""Nearly flat landings that are dropped while a relief grows: those in which the original is nearest to its limit."""

CLOSE = 0.1
"""Relative distance of a guessed height from the critical one up to which no further drop is made."""

EXPONENTS = (0.2, 1.0)
"""Range of p in σ_V ∝ height^p that two drops are believed: 1/2 for a flat impact, 1/5 for contact at a point (Hertz)."""

LIKELY_EXPONENT = 0.37
"""p of a landing that is not flat, with which the height of its first further drop is guessed; 0.29 to 0.44 in nine originals."""

Read = Callable[[Floats, float], Exceeded]


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

        A thorough test rests on tetrahedra that follow the relief. Where a relief that fails is corrected, the landings that steer come
        first, and the others are left out if one of those, or a load, fails for certain already.
        """
        if not thorough and np.any(displacement):
            return self._on(self.meshes.first, displacement, thorough=False)
        body, meshing = self.meshes.carrier(displacement)
        known, corrected = None, self.recipe.restraint.guarantee and np.any(displacement) and not self.baseline.failure
        if thorough and corrected and self._steering != self.numbers(displacement, thorough=True):
            known = self._on(body, displacement, thorough=False)
            failing = (row.decides and row.outcome == "FAILS" and row.sure for row in self.judge(known).rows)
            if bool(known.failure) or any(failing):
                return replace(known, meshing=meshing)
        return replace(self._on(body, displacement, thorough=thorough, known=known), meshing=meshing)

    def judge(self, simulation: Simulation, *, alone: bool = False) -> Verdict:
        """Verdict on a simulation and that of the original, or `alone` on the original itself.

        Where a part does not pass for sure, its original is read on the part's own tetrahedra, too, if without relief they have its shape:
        no style is blamed for its mesh. A rough test asks so only where a part fails.
        """
        if alone:
            return judge(simulation, None, self.recipe)
        verdict = judge(simulation, self.baseline, self.recipe)
        enough = verdict.settled or (verdict.passes and self.recipe.test.rough)
        if enough or verdict.outcome == "UNKNOWN" or self.recipe.test.criterion == "paper":  # which an original does not excuse
            return verdict
        body, nothing = self.meshes.known(simulation.mesh), np.zeros(len(self.part.surface.vertices), np.float32)
        if body is None or not body.made_for_relief or not body.is_the_plain_part:
            return verdict
        return judge(simulation, self.baseline, self.recipe, harder(self.baseline, self._on(body, nothing, thorough=False)))

    def detail(self, displacement: NDArray[np.float32]) -> tuple[TetMesh, Detail]:
        """The moved tetrahedra and the whole drop test in all landings, with its history in time; remembered as well."""
        body, meshing = self.meshes.carrier(displacement)
        morphed, key = body.morph.morphed(displacement), self._key(body, displacement, thorough=True)
        detail = self.memo.recall(f"{key}-detail", Detail)
        if detail is None:
            self._static(body).check()
            numbers = self.numbers(displacement, thorough=True)
            result = self._dropped(morphed.tets, self.landings.normals[list(numbers)], self.recipe.test.height)
            balance = None
            if not result.failure:  # once more through its first phase, without damping, which takes what is missing
                undamped = replace(prescribed(self.recipe), damping=0.0, window=result.phases[0][0].end)
                material, flat = self.recipe.test.material, self.landings.normals[:1]
                again = drop(morphed.tets, material, flat, undamped, device=self.device, progress=self.progress)
                balance = None if again.failure else float(np.abs(again.history[0].damping_loss).max() / again.history[0].kinetic[0])
            simulation = self._brought(body, morphed, result, numbers, thorough=True)
            detail = Detail(replace(simulation, meshing=meshing), result, balance)
            self.memo.remember(f"{key}-detail", detail)
            self.memo.remember(key, simulation)
        return morphed.tets, detail

    def _on(self, body: Body, displacement: NDArray[np.float32], *, thorough: bool, known: Simulation | None = None) -> Simulation:
        """A test on these very tetrahedra; remembered. Landings of the same test that are `known` are not dropped again."""
        key = self._key(body, displacement, thorough=thorough)
        on_plain = not np.any(displacement) and not body.made_for_relief
        memos: tuple[Memo, ...] = self.meshes.plain[1] if on_plain else (self.memo,)
        simulation = next((found for memo in memos if (found := memo.recall(key, Simulation)) is not None), None)
        if simulation is not None:
            memos = memos[-1:]  # others may have written what a run folder holds: only what was computed here is for all
        else:
            morphed = body.morph.morphed(displacement)
            self._static(body).check()  # before the long drop
            numbers = self.numbers(displacement, thorough=thorough)
            if known is not None:
                numbers = tuple(number for number in numbers if known.landing(self.landings.names[number]) is None)
            result = self._dropped(morphed.tets, self.landings.normals[list(numbers)], self.recipe.test.height)
            simulation = self._brought(body, morphed, result, numbers, thorough=thorough, known=known)
        for memo in memos:
            memo.remember(key, simulation)
            memo.remember(self._key(body, simulation.displacement, thorough=thorough), simulation)  # what the tets did follow: same answer
        return simulation

    def _key(self, body: Body, displacement: NDArray[np.float32], *, thorough: bool) -> str:
        recipe = self.recipe.on(surface=self.part.surface.digest, tetrahedra=body.tets.digest)
        normals = self.landings.normals[list(self.numbers(displacement, thorough=thorough))]
        further = thorough and not self.recipe.test.hardest_only
        drops, at = (further, digest_of(normals)), "" if body.at is None else digest_of(body.at)
        return memo_key((PHYSICS_VERSION, self.device, *physics(recipe), recipe.test.loads, drops, at), displacement)

    @cached_property
    def _steering(self) -> tuple[int, ...]:
        """Numbers of the landings that are dropped while a relief grows."""
        known = [number for number, landing in enumerate(self.baseline.landings) if landing.way == "nearly flat"]
        hardest = sorted(known, key=lambda number: -self.baseline.landings[number].stress)[:STEERING]
        return (0, *sorted(hardest))

    def numbers(self, displacement: NDArray[np.float32], *, thorough: bool) -> tuple[int, ...]:
        """Numbers of the landings in which a displaced part is dropped."""
        every = tuple(range(len(self.landings.normals)))
        if (thorough and not (self.recipe.test.hardest_only and np.any(displacement))) or self.baseline.failure:
            return every
        others = tuple(number for number in every if self.landings.ways[number] == "any landing") if thorough else ()
        return (*self._steering, *others)

    def _static(self, body: Body) -> StaticTest:
        """The load cases, their places picked on the plain part."""
        plain = body.morph.morphed(np.zeros(len(self.part.surface.vertices), np.float32)).tets if self.recipe.test.loads else body.tets
        return StaticTest(plain, self.recipe.test.loads, self.recipe.test.element)

    def _under_loads(self, body: Body, dropped: Simulation, tets: TetMesh) -> Simulation:
        """A drop's result with those of the recipe's load cases on moved tetrahedra, on which their places are known."""
        if dropped.failure or not self.recipe.test.loads:
            return dropped
        try:
            responses = self._static(body).run(tets, self.recipe.test.material, self.recipe.test.across_layers)
        except SimulationFailed as error:
            return replace(dropped, failure=str(error))
        read, cases, fields = self._reading_on(tets), list[LoadResult](), list[NDArray[np.float32]]()
        for name, response in responses.items():
            nodal = at_nodes(tets, response.corners)
            found, maximum = read(nodal, LOADED), float(response.von_mises.max())
            cases.append(LoadResult(name=name, stress=found.stress, maximum=maximum, where=found.where, deflection=response.deflection))
            fields.append(body.stress_at_surface(nodal))
        return replace(dropped, loads=tuple(cases), load_stress=np.stack(fields))

    def _dropped(self, tets: TetMesh, normals: Floats, height: float) -> Drop:
        test = replace(prescribed(self.recipe), height=height)
        return drop(tets, self.recipe.test.material, normals, test, device=self.device, progress=self.progress, period=self.period)

    @cached_property
    def period(self) -> float | None:
        """Of `period_of`."""
        return period_of(lambda: self.meshes.plain[0].tets, self.recipe, self.memo, self.meshes.shared)

    def _brought(
        self, body: Body, morphed: Morphed, result: Drop, numbers: Sequence[int], *, thorough: bool, known: Simulation | None = None
    ) -> Simulation:
        """Figures and surface stress of the drops of some landings and of the load cases; none, with the reason, where one failed.

        What is `known` are other landings of the same test, with its load cases; `thorough` says that these, with those, are all.
        """
        tets, fit = morphed.tets, body.followed(morphed)
        found = Simulation(
            displacement=morphed.displacement, contact=np.zeros(len(morphed.displacement), bool),
            backed_off=morphed.backed_off, deviation=morphed.deviation,
            carried=fit.whole, carried_base=fit.under, volume_error=fit.volume, volume=float(tets.volumes.sum()),
            mesh=body.tets.digest, level_share=body.shape.level_base.share(morphed.displacement),
            time_step=result.time_step, steps=max(result.steps, 0 if known is None else known.steps),
            added_mass=result.added_mass, failure=result.failure,
        )  # fmt: skip
        if result.failure:
            return found
        try:
            measured, fields = self._landed(body, morphed, result, numbers, thorough=thorough, known=known)
        except SimulationFailed as error:
            return replace(found, failure=str(error))
        found = replace(found, landings=measured, landing_stress=fields)
        if known is not None:
            return replace(found, contact=known.contact, loads=known.loads, load_stress=known.load_stress)
        return self._under_loads(body, replace(found, contact=body.contact_at_surface(result.contact[0])), tets)

    def _landed(
        self, body: Body, morphed: Morphed, result: Drop, numbers: Sequence[int], *, thorough: bool, known: Simulation | None
    ) -> tuple[tuple[Landing, ...], NDArray[np.float32]]:
        """Every landing in figures, and its stress at the surface [MPa], shape [landing_count, vertex_count]; args as for `_brought`.

        The critical height of a flat landing follows from its drop. In a thorough test that of the hardest of each other kind is found by
        one or two more drops, begun with the exponent of the original, and those of its kind are worked out with the same exponent.
        """
        tets, ways, read = morphed.tets, self.landings, self._reading_on(morphed.tets)
        there = {} if known is None else dict(zip(known.landings, known.landing_stress, strict=True))
        fields = {one.name: field for one, field in there.items()}
        landed = {one.name: self._with_exponent(one, 0.5, 0) for one in there}
        for index, number in enumerate(numbers):
            nodal, name = at_nodes(tets, result.corners[index]), ways.names[number]
            stress, where = read(nodal, DROPPED)
            x, y, z = (float(part) for part in ways.normals[number])
            fields[name] = body.stress_at_surface(nodal)
            landed[name] = Landing(
                name=name, way=ways.ways[number], normal=(x, y, z), stress=stress, where=where,
                maximum=float(result.von_mises[index].max()), fall=self.recipe.test.height,
                critical_height=self._critical_height(stress, 0.5),
                touches=tuple(phase.speed for phase in result.phases[index]), ended=result.endings[index],
            )  # fmt: skip
        found = [landed[name] for name in ways.names if name in landed]
        stresses = np.stack([fields[one.name] for one in found])
        for way in ("nearly flat", "any landing"):
            theirs = [one.exponent for one in self.baseline.of(way)] if np.any(morphed.displacement) else []
            begun = theirs[0] if theirs else LIKELY_EXPONENT
            found = [self._with_exponent(one, begun, 0) if one.way == way else one for one in found]
            if thorough and not self.recipe.test.hardest_only:
                found = self._retried(tets, read, found, way)
        return tuple(found), stresses

    def _reading_on(self, tets: TetMesh) -> Read:
        """What reads σ_V on a mesh, of a stress at its nodes and the edge of V0."""
        weights = self.part.shape.walls.weights(tets)
        return lambda nodal, edge: exceeded(tets, nodal, weights, edge**3)

    def _critical_height(self, stress: float, exponent: float) -> float:
        """Height from which σ_V is the yield strength [mm], by σ_V ∝ height^exponent; NaN and infinity stay what they are."""
        if not (math.isfinite(stress) and stress > 0.0):
            return math.nan
        height = math.log(self.recipe.test.height) + math.log(self.recipe.test.material.yield_strength / stress) / exponent
        return float(np.clip(math.exp(min(height, 50.0)), LEAST_HEIGHT, GREATEST_HEIGHT))

    def _retried(self, tets: TetMesh, read: Read, found: list[Landing], way: Way) -> list[Landing]:
        """Landings of one kind with the exponent that further drops of the hardest of them tell."""
        same = [landing for landing in found if landing.way == way and math.isfinite(landing.critical_height)]
        if not same:
            return found
        hardest = max(same, key=lambda landing: landing.stress)

        def stress_from(height: float) -> float:
            result = self._dropped(tets, np.array([hardest.normal]), height)
            if result.failure:
                raise SimulationFailed(result.failure)
            stress = read(at_nodes(tets, result.corners[0]), DROPPED).stress
            if not (math.isfinite(stress) and stress > 0.0):
                raise SimulationFailed(f"the stress of a fall of {height:.0f} mm is not a finite number above 0")
            return stress

        exponent, drops = exponent_of(hardest, self.recipe.test.material.yield_strength, stress_from)
        return [self._with_exponent(one, exponent, drops if one is hardest else 0) if one in same else one for one in found]

    def _with_exponent(self, landing: Landing, exponent: float, drops: int) -> Landing:
        height = self._critical_height(landing.stress, exponent)
        return msgspec.structs.replace(landing, critical_height=height, exponent=exponent, retried=drops)


def harder(original: Simulation, here: Simulation) -> Simulation:
    """An original with the larger σ_V of two meshes in each landing and load; where `here` broke down it adds nothing."""

    def raised(one: Landing | LoadResult, other: Landing | LoadResult | None) -> float:
        return one.stress if other is None or not math.isfinite(other.stress) else max(one.stress, other.stress)

    landings = []
    for one in original.landings:
        stress = raised(one, here.landing(one.name))
        lower = one.critical_height * (one.stress / stress) ** (1.0 / one.exponent)
        landings.append(msgspec.structs.replace(one, stress=stress, critical_height=lower))
    loads = [msgspec.structs.replace(case, stress=raised(case, here.load(case.name))) for case in original.loads]
    return replace(original, landings=tuple(landings), loads=tuple(loads))


def exponent_of(landing: Landing, strength: float, stress_from: Callable[[float], float]) -> tuple[float, int]:
    """Exponent p of σ_V ∝ height^p between a fall and the critical height, and the drops it took: a secant in logarithms.

    Args:
        landing: The drop from the height of the fall, whose critical height is a first guess.
        strength: Yield strength [MPa].
        stress_from: σ_V of the same landing from another height [mm].
    """
    points = [(math.log(landing.fall), math.log(landing.stress / strength))]
    guess, slope = math.log(landing.critical_height), landing.exponent
    for _ in range(2):
        if abs(guess - points[-1][0]) < CLOSE:
            break
        height = float(np.clip(math.exp(guess), LEAST_HEIGHT, GREATEST_HEIGHT))  # the exponential of a logarithm may be a little more
        points.append((guess, math.log(stress_from(height) / strength)))
        (before, low), (after, high) = points[-2:]
        slope = float(np.clip((high - low) / (after - before), *EXPONENTS))
        guess = float(np.clip(after - high / slope, math.log(LEAST_HEIGHT), math.log(GREATEST_HEIGHT)))
    way, rise = guess - points[0][0], -points[0][1]
    return (float(np.clip(rise / way, *EXPONENTS)) if abs(way) > 1e-3 else slope), len(points) - 1
