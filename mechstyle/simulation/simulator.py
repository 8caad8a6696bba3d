"""From a displaced surface to the stress on it: morph the tetrahedra, drop and load them, read σ_V, bring the stress back, judge."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import MechStyleError, SimulationFailed
from mechstyle.fea.drop import Drop, drop
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.orientations import Orientations, landings
from mechstyle.fea.statics.load_test import StaticTest
from mechstyle.fea.stressed_volume import DROPPED, LOADED, Exceeded, Walls, at_nodes, exceeded
from mechstyle.geometry.level_base import LevelBase
from mechstyle.geometry.morph import Morph, Morphed
from mechstyle.geometry.subdivision import Subdivided
from mechstyle.geometry.thickness import local_thickness
from mechstyle.geometry.transfer import SurfaceMean, Transfer
from mechstyle.loop.objects import AT_REST, CARRIER, LAST_MESH, MESH, MESH_FOR, Memo
from mechstyle.records import Landing, LoadResult, Recipe, Simulation, Verdict, judge
from mechstyle.records.mesh import Floats, SurfaceMesh, TetMesh, digest_of
from mechstyle.records.simulation import GREATEST_HEIGHT, LEAST_HEIGHT, Way
from mechstyle.simulation.carrying import MORPHED, Carried, Carrier, KeptMesh, at_rest, carried, carrying
from mechstyle.simulation.physics import PHYSICS_VERSION, memo_key, period_of, physics, prescribed

STEERING = 2
"""Nearly flat landings that are dropped while a relief grows: those in which the original is nearest to its limit."""

CLOSE = 0.1
"""Relative distance of a guessed height from the critical one up to which no further drop is made."""

EXPONENTS = (0.2, 1.0)
"""Range of p in σ_V ∝ height^p that two drops are believed: 1/2 for a flat impact, 1/5 for contact at a point (Hertz)."""


SAME_PART = 1.1
"""Most that other tetrahedra may add to the σ_V of the original: more is what they do to it."""

Read = Callable[[Floats, float], Exceeded]


@dataclass(frozen=True, eq=False)
class Detail:
    """A drop test in full.

    Attributes:
        simulation: What it left on the surface.
        drop: Stress in the body, and history in time, of every orientation.
        balance_error: Largest error of the energy balance of the drop as placed, over the energy at first touch; measured on the same
            drop without damping. None for a drop that failed.
    """

    simulation: Simulation
    drop: Drop
    balance_error: float | None


@dataclass(frozen=True, eq=False)
class DropSimulator:
    """The drop test of one part under one recipe.

    Attributes:
        surface: The unstylized, standardised surface.
        tets: Tetrahedra of it displaced by `at`.
        recipe: What decides the physics: material, drop, orientations, transfer.
        memo: Where results are remembered by the digest of their inputs.
        shared: Where the unstylized part's result is remembered for other runs too, once computed here; None for nowhere.
        device: `cpu` or `cuda`.
        progress: Called with the fraction done of the drop in hand, and while tetrahedra are made; may raise to cancel either.
        at: Displacement the tetrahedra were made for [mm], shape [vertex_count]; None for none.
        settled: Whether it keeps to these tetrahedra whatever they carry.
        original: The test of the surface that this one was subdivided or styled from, which knows the unstylized part; None for neither.
        thickness: Local wall thickness of the surface [mm], shape [vertex_count]; None to work it out.
    """

    surface: SurfaceMesh
    tets: TetMesh
    recipe: Recipe
    memo: Memo
    shared: Memo | None = None
    device: str = "cpu"
    progress: Progress = field(default=no_progress)
    at: NDArray[np.float32] | None = None
    settled: bool = False
    original: DropSimulator | None = None
    thickness: NDArray[np.floating] | None = None

    def on(self, finer: Subdivided) -> DropSimulator:
        """The same test of the same part on a finer surface, which moves these very tetrahedra and is compared with the same original."""
        recipe = msgspec.structs.replace(self.recipe, surface=finer.mesh.digest)
        at = None if self.at is None else (finer.interpolation @ self.at).astype(np.float32)
        return replace(self, surface=finer.mesh, recipe=recipe, at=at, settled=True, original=self)

    @cached_property
    def baseline(self) -> Simulation:
        """The unstylized part in all orientations, on tetrahedra of its own, as fine as those of a relief.

        On those of a relief it would take three times the steps, because their triangles are flattened on the way back, and where some
        would be turned inside out a notch would be left over.
        """
        if self.original is not None:
            return self.original.baseline
        return self.simulate(np.zeros(len(self.surface.vertices), np.float32), thorough=True)

    def judge(self, simulation: Simulation, *, alone: bool = False) -> Verdict:
        """Verdict on a simulation beside that of the original, or `alone` on the original itself."""
        if alone:
            return judge(simulation, None, self.recipe)
        verdict = judge(simulation, self.baseline, self.recipe)
        if verdict.settled or verdict.outcome == "UNKNOWN" or self.recipe.criterion == "paper":  # which an original does not excuse
            return verdict
        return judge(simulation, self.baseline, self.recipe, self._original_beside(simulation.mesh))

    def _original_beside(self, mesh: str) -> Simulation:
        """The original where a part does not pass for sure: as hard in each landing as on the part's own tetrahedra, by their digest.

        What tetrahedra read of the part, they read of the original too: no style is blamed for its mesh. The difference is believed up to
        SAME_PART, as the way back to no relief may leave a notch.
        """
        if self.original is not None:
            return self.original._original_beside(mesh)  # noqa: SLF001 — another of this class
        there, nothing = self._on(mesh), np.zeros(len(self.surface.vertices), np.float32)
        if there.tets.digest != mesh or not there._made_for_relief or not there._carried(nothing).enough:  # noqa: SLF001 — as above
            return self.baseline
        return harder(self.baseline, there._on_these(nothing))  # noqa: SLF001 — as above

    def _on_these(self, displacement: NDArray[np.float32]) -> Simulation:
        """The landings that steer and the loads on these very tetrahedra; remembered."""
        key = self._key(displacement, thorough=False)
        found = self.memo.recall(key, Simulation)
        if found is None:
            found = self._on_morphed_mesh(displacement, thorough=False)
            self.memo.remember(key, found)
        return found

    def simulate(self, displacement: NDArray[np.float32], *, thorough: bool) -> Simulation:
        """Drop the displaced part, flat and in the hardest nearly flat landings or (`thorough`) in all, and load it; remembered.

        A thorough test rests on tetrahedra that carry the relief: where these do not, the part is meshed again at half of that very
        relief. The unstylized part has tetrahedra of its own: see `baseline`.
        """
        if self._made_for_relief and not np.any(displacement):
            return self._at_rest.simulate(displacement, thorough=thorough)
        key = self._key(displacement, thorough=thorough)
        memos = [self.memo] if np.any(displacement) or self._trusted is None else [self._trusted, self.memo]
        simulation = next((found for memo in memos if (found := memo.recall(key, Simulation)) is not None), None)
        if simulation is not None:
            memos = [self.memo]  # others may have written what a run folder holds: only what was computed here is for all
        else:
            decides = thorough and not self.settled and bool(np.any(displacement))
            simulation = self._on_a_mesh_that_carries(displacement) if decides else self._on_morphed_mesh(displacement, thorough=thorough)
        for memo in memos:
            memo.remember(key, simulation)
            memo.remember(self._key(simulation.displacement, thorough=thorough), simulation)  # what the tets did follow has the same answer
        return simulation

    def _on_a_mesh_that_carries(self, displacement: NDArray[np.float32]) -> Simulation:
        """The thorough test on tetrahedra that carry a relief."""
        carrier, meshing = self.carrier(displacement)
        if carrier is self:
            return replace(self._on_morphed_mesh(displacement, thorough=True), meshing=meshing)
        return replace(carrier.simulate(displacement, thorough=True), meshing=meshing)

    def carrier(self, displacement: NDArray[np.float32]) -> tuple[DropSimulator, str]:
        """The same test on tetrahedra that carry a relief [mm], shape [vertex_count], and how these came about, in words; remembered.

        They are its own, those that were made last for such a relief, or new ones; meshing a third time was never seen to carry more. Asked
        again they are the same, whatever was meshed since: what is delivered is not to be another test than its verdict.
        """
        name = f"{CARRIER}{self._key(displacement, thorough=True)}"
        known = self.memo.recall(name, Carrier)
        if known is not None and (there := self._on(known.mesh)).tets.digest == known.mesh:
            return there, known.meshing
        carrier, meshing = self._that_carries(displacement)
        self.memo.remember(name, Carrier(mesh=carrier.tets.digest, meshing=meshing), anew=True)
        return carrier, meshing

    def _that_carries(self, displacement: NDArray[np.float32]) -> tuple[DropSimulator, str]:
        here = self._carried(displacement)
        if here.enough:
            return self, MORPHED
        last = self.memo.recall(self._last_mesh, str)
        if last is not None and (there := (again := self._on(last))._carried(displacement)).serves_instead_of(here):  # noqa: SLF001
            return again, there.again
        try:
            again = self._meshed_again(displacement)
        except MechStyleError as error:
            return self, f"{MORPHED}, carrying {here.words}, as the part could not be meshed again: {error}"
        return again, again._carried(displacement).again  # noqa: SLF001 — as above

    def _meshed_again(self, displacement: NDArray[np.float32]) -> DropSimulator:
        """The same test on tetrahedra made for half of a relief, which are kept for the next."""
        name, objects = f"{MESH_FOR}{digest_of(displacement)}", self.memo.objects
        kept = self.memo.recall(name, KeptMesh)
        if kept is None:
            made, half = carrying(self.surface, displacement, partial(self.progress, 0.0))
            kept = KeptMesh(tets=objects.put_mesh(made), at=objects.put_array(half))
            self.memo.remember(name, kept)
        tets = objects.get_mesh(kept.tets, TetMesh)
        self.memo.remember(f"{MESH}{tets.digest}", kept)
        self.memo.remember(self._last_mesh, tets.digest, anew=True)
        return self._on(tets.digest)

    def _on(self, mesh: str) -> DropSimulator:
        """The same test on tetrahedra that a thorough test was run on, by their digest; this one for its own and those it does not know."""
        kept = None if mesh in ("", self.tets.digest) else self.memo.recall(f"{MESH}{mesh}", KeptMesh)
        if kept is None:
            return self
        tets, at = self.memo.objects.get_mesh(kept.tets, TetMesh), self.memo.objects.get_array(kept.at)
        return replace(self, tets=tets, at=at, recipe=msgspec.structs.replace(self.recipe, tetrahedra=tets.digest), settled=True)

    @property
    def _last_mesh(self) -> str:
        return f"{LAST_MESH}{self.recipe.digest}"

    def _carried(self, displacement: NDArray[np.float32]) -> Carried:
        return carried(self.morph, self.morph.morphed(displacement), self._base, self._printed)

    def detail(self, displacement: NDArray[np.float32]) -> tuple[TetMesh, Detail]:
        """The morphed tetrahedra and the whole drop test in all orientations, with its history in time; remembered as well."""
        if self._made_for_relief and not np.any(displacement):
            return self._at_rest.detail(displacement)
        key = self._key(displacement, thorough=True)
        morphed = self.morph.morphed(displacement)
        detail = self.memo.recall(f"{key}-detail", Detail)
        if detail is None:
            self._static.check()
            result = self._drop(morphed.tets, thorough=True)
            balance = None if result.failure else self._balance_error(morphed.tets, result.phases[0][0].end)
            detail = Detail(self._brought(morphed, result, thorough=True), result, balance)
            self.memo.remember(f"{key}-detail", detail)
            if not np.any(displacement):  # a relief may ask for other tetrahedra
                self.memo.remember(key, detail.simulation)
        return morphed.tets, detail

    @cached_property
    def _trusted(self) -> Memo | None:
        """`shared`, if this is the very part the recipe names: a run folder could hold another one, under the names of a known one."""
        named = (self.recipe.surface, self.recipe.tetrahedra)
        return self.shared if self.shared is None or (self.surface.digest, self.tets.digest) == named else None

    def _balance_error(self, tets: TetMesh, window: float) -> float | None:
        """Of `Detail`, over the first phase, which lasted for `window` [ms].

        What damping took is what is missing in the balance, so the balance can be checked only without it.
        """
        undamped = replace(prescribed(self.recipe), damping=0.0, window=window)
        found = drop(tets, self.recipe.material, self.landings.normals[:1], undamped, device=self.device, progress=self.progress)
        return None if found.failure else float(np.abs(found.history[0].damping_loss).max() / found.history[0].kinetic[0])

    def _key(self, displacement: NDArray[np.float32], *, thorough: bool) -> str:
        recipe = self.recipe
        drops = (thorough, digest_of(self._normals(thorough=thorough)))
        mesh = ("" if self.at is None else digest_of(self.at), self.settled, "" if self.original is None else self.original.surface.digest)
        return memo_key((PHYSICS_VERSION, self.device, *physics(recipe), recipe.loads, drops, mesh), displacement)

    @cached_property
    def morph(self) -> Morph:
        """What moves the tetrahedra with the surface."""
        return Morph(self.surface, self.tets, self.at)

    @cached_property
    def _base(self) -> LevelBase:
        return LevelBase(self.surface)

    @cached_property
    def _transfer(self) -> Transfer:
        return Transfer(self.surface.displaced(self.morph.at), self.tets, self.recipe.transfer)

    @cached_property
    def _smooth(self) -> SurfaceMean:
        return SurfaceMean(self.surface)

    @cached_property
    def _printed(self) -> SurfaceMean:
        """What a nozzle leaves of a relief, a mean over its width."""
        return SurfaceMean(self.surface, 0.5 * self.recipe.nozzle)

    @cached_property
    def _walls(self) -> Walls:
        """Walls of the unstylized part, by which small volumes of thin members count."""
        if self.original is not None:
            return self.original._walls  # noqa: SLF001 — another of this class
        return Walls(self.surface.vertices, local_thickness(self.surface) if self.thickness is None else self.thickness)

    @cached_property
    def landings(self) -> Orientations:
        """Landings of the unstylized part, so that both are compared in the same: flat, nearly flat, then the others."""
        if self.original is not None:
            return self.original.landings
        recipe = self.recipe
        return landings(self.surface, recipe.poses, recipe.orientations, nearly_flat=recipe.nearly_flat)

    @cached_property
    def _steering(self) -> tuple[int, ...]:
        """Numbers of the landings that are dropped while a relief grows."""
        known = [number for number, landing in enumerate(self.baseline.landings) if landing.way == "nearly flat"]
        hardest = sorted(known, key=lambda number: -self.baseline.landings[number].stress)[:STEERING]
        return (0, *sorted(hardest))

    def _numbers(self, *, thorough: bool) -> tuple[int, ...]:
        return tuple(range(len(self.landings.normals))) if thorough or self.baseline.failure else self._steering

    def _normals(self, *, thorough: bool) -> Floats:
        return self.landings.normals[list(self._numbers(thorough=thorough))]

    def _on_morphed_mesh(self, displacement: NDArray[np.float32], *, thorough: bool) -> Simulation:
        morphed = self.morph.morphed(displacement)
        self._static.check()  # before the long drop
        return self._brought(morphed, self._drop(morphed.tets, thorough=thorough), thorough=thorough)

    @cached_property
    def _at_rest(self) -> DropSimulator:
        """The same test on tetrahedra of the unstylized part; remembered for all, and by the run folder for other machines."""
        claimed = self.surface.digest != self.recipe.surface  # by a run folder, which may hold another part under the name of a known one
        shared = None if claimed else self.shared
        name = f"{AT_REST}{self.surface.digest}"
        own, known = self.memo.recall(name, str), None if shared is None else shared.recall(name, str)
        memo = self.memo if shared is None or own not in (None, known) else shared
        kept = own or known
        if kept is None:
            kept = memo.objects.put_mesh(at_rest(self.surface, partial(self.progress, 0.0)))
        tets = (self.memo if own else memo).objects.get_mesh(kept, TetMesh)
        for one in (self.memo, memo):
            one.remember(name, one.objects.put_mesh(tets))
        recipe = msgspec.structs.replace(self.recipe, tetrahedra=tets.digest)  # those of another machine are for this run only
        return replace(self, tets=tets, at=None, recipe=recipe, memo=memo, settled=True)

    def _brought(self, morphed: Morphed, result: Drop, *, thorough: bool) -> Simulation:
        """Result of the drops and the load cases on morphed tetrahedra."""
        return self._under_loads(self._measured(morphed, result, thorough=thorough), morphed.tets)

    @cached_property
    def _static(self) -> StaticTest:
        original = self.morph.morphed(np.zeros(len(self.surface.vertices), np.float32)).tets
        return StaticTest(original, self.recipe.loads, self.recipe.element)

    def _under_loads(self, dropped: Simulation, tets: TetMesh) -> Simulation:
        """A drop's result with those of the recipe's load cases on morphed tetrahedra, on which their places are known."""
        if dropped.failure or not self.recipe.loads:
            return dropped
        try:
            responses = self._static.run(tets, self.recipe.material, self.recipe.across_layers)
        except SimulationFailed as error:
            return replace(dropped, failure=str(error))
        read, cases, fields = self._reading_on(tets), list[LoadResult](), list[NDArray[np.float32]]()
        for name, response in responses.items():
            nodal = at_nodes(tets, response.corners)
            found, maximum = read(nodal, LOADED), float(response.von_mises.max())
            cases.append(LoadResult(name=name, stress=found.stress, maximum=maximum, where=found.where, deflection=response.deflection))
            fields.append(self._on_surface(nodal))
        return replace(dropped, loads=tuple(cases), load_stress=np.stack(fields))

    def _drop(self, tets: TetMesh, *, thorough: bool) -> Drop:
        return self._dropped(tets, self._normals(thorough=thorough), self.recipe.height)

    def _dropped(self, tets: TetMesh, normals: Floats, height: float) -> Drop:
        test = replace(prescribed(self.recipe), height=height)
        return drop(tets, self.recipe.material, normals, test, device=self.device, progress=self.progress, period=self._period)

    @cached_property
    def _period(self) -> float | None:
        """Of `period_of`."""
        if self.original is not None:
            return self.original._period  # noqa: SLF001 — another of this class
        return period_of(lambda: self._at_rest.tets if self._made_for_relief else self.tets, self.recipe, self.memo, self._trusted)

    @property
    def _made_for_relief(self) -> bool:
        return self.at is not None and bool(np.any(self.at))

    def _measured(self, morphed: Morphed, result: Drop, *, thorough: bool) -> Simulation:
        """Figures and surface stress of the drops; none, with the reason, for drops that failed."""
        tets, fit = morphed.tets, carried(self.morph, morphed, self._base, self._printed)
        found = Simulation(
            displacement=morphed.displacement, contact=np.zeros(len(morphed.displacement), bool),
            backed_off=morphed.backed_off, deviation=morphed.deviation,
            carried=fit.whole, carried_base=fit.under, volume_error=fit.volume, volume=float(tets.volumes.sum()),
            mesh=self.tets.digest, level_share=self._base.share(morphed.displacement),
            time_step=result.time_step, steps=result.steps, added_mass=result.added_mass, failure=result.failure,
        )  # fmt: skip
        if result.failure:
            return found
        try:
            measured, fields = self._landed(tets, result, thorough=thorough)
        except SimulationFailed as error:
            return replace(found, failure=str(error))
        contact = self._transfer.to_surface(result.contact[0].astype(np.float64)) > 0.5
        return replace(found, landings=measured, landing_stress=fields, contact=contact)

    def _landed(self, tets: TetMesh, result: Drop, *, thorough: bool) -> tuple[tuple[Landing, ...], NDArray[np.float32]]:
        """Every landing in figures, and its stress at the surface [MPa], shape [landing_count, vertex_count].

        The critical height of a flat landing follows from its drop. In a thorough test that of the hardest of each other kind is found by
        one or two more drops, and those of its kind are worked out with the same exponent.
        """
        ways, numbers, read = self.landings, self._numbers(thorough=thorough), self._reading_on(tets)
        nodal = [at_nodes(tets, corners) for corners in result.corners]
        found = list[Landing]()
        for index, number in enumerate(numbers):
            stress, where = read(nodal[index], DROPPED)
            x, y, z = (float(part) for part in ways.normals[number])
            found.append(Landing(
                name=ways.names[number], way=ways.ways[number], normal=(x, y, z), stress=stress, where=where,
                maximum=float(result.von_mises[index].max()), fall=self.recipe.height,
                critical_height=self._critical_height(stress, 0.5),
                touches=tuple(phase.speed for phase in result.phases[index]), ended=result.endings[index],
            ))  # fmt: skip
        for way in ("nearly flat", "any landing"):
            found = self._retried(tets, read, found, way) if thorough else self._as_the_original(found, way)
        return tuple(found), np.stack([self._on_surface(field) for field in nodal])

    def _reading_on(self, tets: TetMesh) -> Read:
        """What reads σ_V on a mesh, of a stress at its nodes and the edge of V0."""
        weights = self._walls.weights(tets)
        return lambda nodal, edge: exceeded(tets, nodal, weights, edge**3)

    def _critical_height(self, stress: float, exponent: float) -> float:
        """Height from which σ_V is the yield strength [mm], by σ_V ∝ height^exponent; NaN and infinity stay what they are."""
        if not (math.isfinite(stress) and stress > 0.0):
            return math.nan
        height = math.log(self.recipe.height) + math.log(self.recipe.material.yield_strength / stress) / exponent
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

        exponent, drops = exponent_of(hardest, self.recipe.material.yield_strength, stress_from)
        return [self._with_exponent(one, exponent, drops if one is hardest else 0) if one in same else one for one in found]

    def _as_the_original(self, found: list[Landing], way: Way) -> list[Landing]:
        """Landings of one kind with the exponent of the original's."""
        theirs = next((landing.exponent for landing in self.baseline.of(way)), 0.5)
        return [self._with_exponent(one, theirs, 0) if one.way == way else one for one in found]

    def _with_exponent(self, landing: Landing, exponent: float, drops: int) -> Landing:
        height = self._critical_height(landing.stress, exponent)
        return msgspec.structs.replace(landing, critical_height=height, exponent=exponent, retried=drops)

    def _on_surface(self, nodal: Floats) -> NDArray[np.float32]:
        """Stress at the nodes brought to the surface and averaged over 2 mm along it [MPa], shape [vertex_count]."""
        return self._smooth(self._transfer.to_surface(nodal)).astype(np.float32)


def harder(original: Simulation, here: Simulation) -> Simulation:
    """An original with the larger σ_V of two meshes in each landing and load, at most SAME_PART times its own.

    Args:
        original: On tetrahedra of its own.
        here: On others; where that broke down it adds nothing.
    """

    def raised(own: float, other: float | None) -> float:
        return own if other is None or not math.isfinite(other) else max(own, min(other, SAME_PART * own))

    others = {one.name: one.stress for one in here.landings}
    landings = []
    for one in original.landings:
        stress = raised(one.stress, others.get(one.name))
        lower = one.critical_height * (one.stress / stress) ** (1.0 / one.exponent)
        landings.append(msgspec.structs.replace(one, stress=stress, critical_height=lower))
    cases = {case.name: case.stress for case in here.loads}
    loads = [msgspec.structs.replace(case, stress=raised(case.stress, cases.get(case.name))) for case in original.loads]
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
        points.append((guess, math.log(stress_from(math.exp(guess)) / strength)))
        (before, low), (after, high) = points[-2:]
        slope = float(np.clip((high - low) / (after - before), *EXPONENTS))
        guess = float(np.clip(after - high / slope, math.log(LEAST_HEIGHT), math.log(GREATEST_HEIGHT)))
    way, rise = guess - points[0][0], -points[0][1]
    return (float(np.clip(rise / way, *EXPONENTS)) if abs(way) > 1e-3 else slope), len(points) - 1
