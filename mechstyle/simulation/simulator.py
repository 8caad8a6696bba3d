"""From a displaced surface to the stress on it: morph the tetrahedra, drop them, average, bring the field back, judge."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import MechStyleError, SimulationFailed
from mechstyle.fea.criterion import exceedance, measured_landings, measures
from mechstyle.fea.drop import Drop, drop
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.orientations import Orientations, nearly, orientation_set
from mechstyle.fea.statics.load_test import StaticTest
from mechstyle.fea.surface_stress import SurfaceStress, worst
from mechstyle.fea.verdict import judge
from mechstyle.geometry.level_base import LevelBase
from mechstyle.geometry.morph import Morph, Morphed
from mechstyle.geometry.resting_face import centre_of_mass
from mechstyle.geometry.subdivision import Subdivided
from mechstyle.geometry.transfer import Transfer
from mechstyle.loop.objects import AT_REST, CARRIER, LAST_MESH, MESH, MESH_FOR, Memo
from mechstyle.records import Measures, Recipe, Simulation, Verdict
from mechstyle.records.mesh import SurfaceMesh, TetMesh, digest_of
from mechstyle.simulation.carrying import MORPHED, Carried, Carrier, KeptMesh, at_rest, carried, carrying
from mechstyle.simulation.original import asked, asked_everywhere, beside, confirmed, excuses
from mechstyle.simulation.physics import PHYSICS_VERSION, memo_key, period_of, physics, prescribed
from mechstyle.simulation.under_loads import told, under_loads


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
        coarser: The test of the surface that this one is subdivided from, which knows the unstylized part; None if it is not.
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
    coarser: DropSimulator | None = None

    def on(self, finer: Subdivided) -> DropSimulator:
        """The same test of the same part on a finer surface, which moves these very tetrahedra and is compared with the same original."""
        recipe = msgspec.structs.replace(self.recipe, surface=finer.mesh.digest)
        at = None if self.at is None else (finer.interpolation @ self.at).astype(np.float32)
        return replace(self, surface=finer.mesh, recipe=recipe, at=at, settled=True, coarser=self)

    @cached_property
    def baseline(self) -> Simulation:
        """The unstylized part in all orientations, on tetrahedra of its own, as fine as those of a relief.

        On those of a relief it would take three times the steps, because their triangles are flattened on the way back, and where some
        would be turned inside out a notch would be left over, which may bear several times what the original does.
        """
        if self.coarser is not None:
            return self.coarser.baseline
        return self.simulate(np.zeros(len(self.surface.vertices), np.float32), thorough=True)

    def judge(self, simulation: Simulation) -> Verdict:
        """Verdict on a simulation under the recipe's criterion."""
        return judge(simulation, self.baseline_of(simulation), self.recipe.material, self.recipe.criterion)

    def baseline_of(self, simulation: Simulation) -> Simulation:
        """What a simulation is compared with: the baseline, and where `original.asked` says so the original here, too."""
        if self.coarser is not None:
            return self.coarser.baseline_of(simulation)
        own, there = self.baseline, self._on(simulation.mesh)
        made_for_it = there.tets.digest == simulation.mesh and there._made_for_relief  # noqa: SLF001 — another of this class
        # On tetrahedra that cannot come back to it the original stands on a few nodes and bears more, which would let the style bear more.
        nothing = np.zeros(len(self.surface.vertices), np.float32)
        if made_for_it and asked(simulation, own, self.recipe) and there._carried(nothing).enough:  # noqa: SLF001 — as above
            everywhere = asked_everywhere(simulation, own, self.recipe)
            here = there._plain(thorough=True) if everywhere else there._without_relief  # noqa: SLF001 — as above
            return beside(own, here, self.recipe.material)
        return self.believed(simulation.mesh)

    def believed(self, mesh: str) -> Simulation:
        """The baseline; where that would excuse a style, only what tetrahedra made for a relief, by their digest, confirm of it."""
        own, there, material = self.baseline, self._on(mesh), self.recipe.material
        made_for_it = there.tets.digest == mesh and there._made_for_relief  # noqa: SLF001 — as above
        return confirmed(own, there._without_relief, material) if made_for_it and excuses(own, material) else own  # noqa: SLF001 — as above

    @cached_property
    def _without_relief(self) -> Simulation:
        """The original as placed and tilted on tetrahedra that were made for a relief."""
        return self._plain(thorough=False)

    def _plain(self, *, thorough: bool) -> Simulation:
        """The original on tetrahedra that were made for a relief, as placed and tilted or in all orientations; remembered."""
        nothing = np.zeros(len(self.surface.vertices), np.float32)
        key = self._key(nothing, thorough=thorough)
        found = self.memo.recall(key, Simulation)
        if found is None:
            found = self._on_morphed_mesh(nothing, thorough=thorough)
            self.memo.remember(key, found)
        return found

    def simulate(self, displacement: NDArray[np.float32], *, thorough: bool) -> Simulation:
        """Drop the displaced part, as placed and tilted or (`thorough`) in all orientations, and load it; remembered by its inputs.

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
        return carried(self.morph, self.morph.morphed(displacement), self._base)

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
            detail = Detail(self._told(morphed, result), result, balance)
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
        found = drop(tets, self.recipe.material, self._orientations.normals[:1], undamped, device=self.device, progress=self.progress)
        return None if found.failure else float(np.abs(found.history[0].damping_loss).max() / found.history[0].kinetic[0])

    def _key(self, displacement: NDArray[np.float32], *, thorough: bool) -> str:
        recipe = self.recipe
        drops = (recipe.tilts, recipe.poses, recipe.orientations) if thorough else (recipe.tilts,)
        mesh = ("" if self.at is None else digest_of(self.at), self.settled)
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
    def _reading(self) -> SurfaceStress:
        if self.coarser is not None and self.coarser.tets is self.tets:
            return self.coarser._reading  # noqa: SLF001 — as above
        return SurfaceStress(self.morph.finished)

    def _reading_of(self, body: TetMesh, relief: NDArray[np.float32]) -> SurfaceStress:
        """What reads the stress of a body: on the sides of its finished relief or, if it is not known, its own; without any of the mesh."""
        if np.any(relief):
            return self._reading if self._made_for_relief else SurfaceStress(body)
        return SurfaceStress(self.tets)

    @cached_property
    def _orientations(self) -> Orientations:
        """Orientations of the unstylized part, so that both are compared in the same landings: as placed, tilted, then the others."""
        if self.coarser is not None:
            return self.coarser._orientations  # noqa: SLF001 — another of this class
        recipe, points = self.recipe, self.surface.vertices
        return nearly(orientation_set(recipe.poses, recipe.orientations, points, centre_of_mass(self.surface)), recipe.tilts)

    def _on_morphed_mesh(self, displacement: NDArray[np.float32], *, thorough: bool) -> Simulation:
        morphed = self.morph.morphed(displacement)
        self._static.check()  # before the long drop
        return self._told(morphed, self._drop(morphed.tets, thorough=thorough))

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

    def _told(self, morphed: Morphed, result: Drop) -> Simulation:
        """Result of the drop and the load cases on morphed tetrahedra."""
        return self._under_loads(self._measured(morphed, result), morphed.tets)

    @cached_property
    def _static(self) -> StaticTest:
        original = self.morph.morphed(np.zeros(len(self.surface.vertices), np.float32)).tets
        return StaticTest(original, self.recipe.loads, self.recipe.element)

    def _under_loads(self, dropped: Simulation, tets: TetMesh) -> Simulation:
        """A drop's result raised to what the recipe's load cases do to morphed tetrahedra, on which their places are known."""
        if dropped.failure or not self.recipe.loads:
            return dropped
        try:
            responses = self._static.run(tets, self.recipe.material, self.recipe.across_layers)
        except SimulationFailed as error:
            return replace(dropped, failure=str(error))
        reading, borders = self._reading_of(tets, dropped.displacement), self._static.borders
        deciding = {name: reading.of_load(tets, one.von_mises, one.corners, borders[name]) for name, one in responses.items()}
        fields = np.stack([self._transfer.to_surface(one.field).astype(np.float32) for one in deciding.values()])
        return under_loads(dropped, [told(name, tets, responses[name], one, borders[name]) for name, one in deciding.items()], fields)

    def _drop(self, tets: TetMesh, *, thorough: bool) -> Drop:
        normals, test = self._orientations.normals[: None if thorough else 1 + self.recipe.tilts], prescribed(self.recipe)
        return drop(tets, self.recipe.material, normals, test, device=self.device, progress=self.progress, period=self._period)

    @cached_property
    def _period(self) -> float | None:
        """Of `period_of`."""
        if self.coarser is not None:
            return self.coarser._period  # noqa: SLF001 — another of this class
        return period_of(lambda: self._at_rest.tets if self._made_for_relief else self.tets, self.recipe, self.memo, self._trusted)

    @property
    def _made_for_relief(self) -> bool:
        return self.at is not None and bool(np.any(self.at))

    def _measured(self, morphed: Morphed, result: Drop) -> Simulation:
        """Measures and surface fields of a drop; all zero, with the reason, for one that failed."""
        transfer, fit = self._transfer, carried(self.morph, morphed, self._base)
        tets, zeros = morphed.tets, np.zeros(len(self.surface.vertices), np.float32)
        nothing = Measures(peak=0.0, p999=0.0, p99=0.0, maximum=0.0, where=(0.0, 0.0, 0.0), volume=float(tets.volumes.sum()))
        several, tilts = len(result.von_mises) > 1 + self.recipe.tilts, slice(1, 1 + self.recipe.tilts)
        failed = Simulation(
            displacement=morphed.displacement,
            stress=zeros,
            envelope=zeros,
            probability=zeros,
            contact=np.zeros(len(zeros), bool),
            as_placed=nothing,
            overall=nothing if several else None,
            backed_off=morphed.backed_off, deviation=morphed.deviation,
            carried=fit.whole, carried_base=fit.under, volume_error=fit.volume,
            mesh=self.tets.digest, level_share=self._base.share(morphed.displacement),
            time_step=result.time_step, steps=result.steps, added_mass=result.added_mass, failure=result.failure,
        )  # fmt: skip
        if result.failure:
            return failed
        reading, stresses = self._reading_of(tets, morphed.displacement), zip(result.von_mises, result.corners, result.contact, strict=True)
        deciding = [reading.of_landing(tets, points, corners, touched) for points, corners, touched in stresses]
        landings = measured_landings(self._orientations, tets, result, deciding)
        fields = np.stack([transfer.to_surface(one.field) for one in deciding])
        found = replace(
            failed,
            stress=fields[0],
            envelope=fields.max(axis=0),  # what each landing does in its own zones: no average is taken over maxima of several landings
            contact=transfer.to_surface(result.contact[0].astype(np.float64)) > 0.5,
            as_placed=landings[0].measures,
            landings=landings,
        )
        if nearly_as_placed := deciding[tilts]:
            outside = np.stack([transfer.to_surface(one.outside) for one in nearly_as_placed])
            of_tilts = measures(tets, result.von_mises[tilts].max(axis=0), worst(nearly_as_placed))
            found = replace(found, tilted=of_tilts, tilted_stress=outside.max(axis=0).astype(np.float32))
        if not several:
            return found
        found = replace(found, overall=measures(tets, result.von_mises.max(axis=0), worst(deciding)))
        if not self.recipe.random_drops:
            return found
        allowable, weights = self.recipe.material.yield_strength, self._orientations.weights
        return replace(
            found,
            probability=exceedance(fields, weights, allowable).astype(np.float32),
            failure_probability=float(exceedance([landing.measures.peak for landing in landings], weights, allowable)),
        )
