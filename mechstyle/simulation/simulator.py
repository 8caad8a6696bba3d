"""From a displaced surface to the stress on it: morph the tetrahedra, drop them, average, bring the field back, judge."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import MechStyleError, SimulationFailed
from mechstyle.fea.criterion import exceedance, measures
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import Drop, DropTest, drop
from mechstyle.fea.elements import element_named
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.orientations import Orientations, nearly, orientation_set
from mechstyle.fea.period import lowest_period
from mechstyle.fea.statics.load_test import StaticTest
from mechstyle.fea.surface_stress import Deciding, SurfaceStress, worst
from mechstyle.fea.verdict import judge
from mechstyle.geometry.level_base import LevelBase
from mechstyle.geometry.morph import Morph, Morphed
from mechstyle.geometry.resting_face import centre_of_mass
from mechstyle.geometry.tetrahedra import tetrahedralise
from mechstyle.geometry.transfer import Transfer
from mechstyle.loop.objects import Memo
from mechstyle.records import Landing, LoadResult, Measures, Recipe, Simulation, Verdict
from mechstyle.records.mesh import SurfaceMesh, TetMesh

PHYSICS_VERSION = 5
"""Counts changes that alter results, so that remembered simulations of older code are not reused."""


def prescribed(recipe: Recipe) -> DropTest:
    """The drop test a recipe prescribes."""
    return DropTest(
        height=recipe.drop_height, friction=recipe.friction, window=recipe.window, damping=recipe.damping, element=recipe.element,
        across=recipe.across_layers,
    )  # fmt: skip


def physics(recipe: Recipe) -> tuple[Any, ...]:
    """The settings that decide the drop of a displaced part as placed and the stress it leaves on the surface."""
    layers = () if recipe.build_direction is None else (recipe.build_direction,)
    part = (recipe.surface, recipe.tetrahedra, recipe.material, *layers)
    return (*part, recipe.drop_height, recipe.friction, recipe.window, recipe.damping, recipe.element, recipe.transfer)


def memo_key(inputs: tuple[Any, ...], displacement: NDArray[np.float32]) -> str:
    """The name under which what follows from inputs and a displacement [mm], shape [vertex_count], is remembered."""
    return hashlib.sha256(msgspec.json.encode(inputs) + np.ascontiguousarray(displacement, np.float32).tobytes()).hexdigest()


def period_of(tets: TetMesh, recipe: Recipe, memo: Memo, trusted: Memo | None = None) -> float | None:
    """Lowest elastic period of the unstylized part [ms], by which the end of an impact is told, also of a styled one.

    None if the recipe has a window, which needs none.

    Args:
        tets: The unstylized part.
        recipe: What decides the physics.
        memo: Where the answer is remembered.
        trusted: Where it is looked for first, and remembered if it was worked out here; None for nowhere.
    """
    if recipe.window is not None:
        return None
    key = memo_key(("period", PHYSICS_VERSION, recipe.tetrahedra, recipe.material, recipe.element), np.empty(0, np.float32))
    memos = [memo] if trusted is None else [trusted, memo]
    period = next((found for one in memos if (found := one.recall(key, float)) is not None), None)
    if period is not None:
        return period
    test = prescribed(recipe)
    period = lowest_period(discretise(tets, recipe.material, test.added_mass, element_named(test.element)), recipe.material)
    for one in memos:
        one.remember(key, period)
    return period


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
        tets: Its tetrahedra.
        recipe: What decides the physics: material, drop, orientations, transfer.
        memo: Where results are remembered by the digest of their inputs.
        shared: Where the unstylized part's result is remembered for other runs too, once computed here; None for nowhere.
        device: `cpu` or `cuda`.
        cache: Folder for fresh tetrahedra, None to mesh anew each time.
        progress: Called with the fraction done of the drop in hand; may raise to cancel it.
    """

    surface: SurfaceMesh
    tets: TetMesh
    recipe: Recipe
    memo: Memo
    shared: Memo | None = None
    device: str = "cpu"
    cache: Path | None = None
    progress: Progress = field(default=no_progress)

    @cached_property
    def baseline(self) -> Simulation:
        """The unstylized part in all orientations."""
        return self.simulate(np.zeros(len(self.surface.vertices), np.float32), thorough=True)

    def judge(self, simulation: Simulation) -> Verdict:
        """Verdict on a simulation under the recipe's criterion."""
        return judge(simulation, self.baseline, self.recipe.material, self.recipe.criterion)

    def simulate(self, displacement: NDArray[np.float32], *, thorough: bool) -> Simulation:
        """Drop the displaced part, as placed and tilted or (`thorough`) in all orientations, and load it; remembered by its inputs.

        A relief that reaches under a part cannot be carried by morphed tetrahedra, so
        the thorough test of such a part is run on a fresh mesh of the styled surface.
        """
        fresh = thorough and self.recipe.base != "protected" and bool(np.any(displacement))
        key = self._key(displacement, thorough=thorough, fresh=fresh)
        memos = [self.memo] if np.any(displacement) or self._trusted is None else [self._trusted, self.memo]
        simulation = next((found for memo in memos if (found := memo.recall(key, Simulation)) is not None), None)
        if simulation is not None:
            memos = [self.memo]  # others may have written what a run folder holds: only what was computed here is for all
        else:
            simulation = self._on_fresh_mesh(displacement) if fresh else self._on_morphed_mesh(displacement, thorough=thorough)
        for memo in memos:
            memo.remember(key, simulation)
            if not fresh:  # what the tets did follow has the same answer
                memo.remember(self._key(simulation.displacement, thorough=thorough, fresh=False), simulation)
        return simulation

    def detail(self, displacement: NDArray[np.float32]) -> tuple[TetMesh, Detail]:
        """The morphed tetrahedra and the whole drop test in all orientations, with its history in time; remembered as well."""
        key = self._key(displacement, thorough=True, fresh=False)
        morphed = self._morph.morphed(displacement)
        detail = self.memo.recall(f"{key}-detail", Detail)
        if detail is None:
            self._static.check()
            result = self._drop(morphed.tets, thorough=True)
            balance = None if result.failure else self._balance_error(morphed.tets, result.phases[0][0].end)
            detail = Detail(self._told(morphed, result), result, balance)
            self.memo.remember(f"{key}-detail", detail)
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

    def _key(self, displacement: NDArray[np.float32], *, thorough: bool, fresh: bool) -> str:
        recipe = self.recipe
        drops = (recipe.tilts, recipe.poses, recipe.orientations) if thorough else (recipe.tilts,)
        return memo_key((PHYSICS_VERSION, self.device, *physics(recipe), recipe.loads, drops, fresh), displacement)

    @cached_property
    def _morph(self) -> Morph:
        return Morph(self.surface, self.tets)

    @cached_property
    def _base(self) -> LevelBase:
        return LevelBase(self.surface)

    @cached_property
    def _transfer(self) -> Transfer:
        return Transfer(self.surface, self.tets, self.recipe.transfer)

    @cached_property
    def _reading(self) -> SurfaceStress:
        return SurfaceStress(self.tets)

    @cached_property
    def _orientations(self) -> Orientations:
        """Orientations of the unstylized part, so that both are compared in the same landings: as placed, tilted, then the others."""
        recipe, points = self.recipe, self.surface.vertices
        return nearly(orientation_set(recipe.poses, recipe.orientations, points, centre_of_mass(self.surface)), recipe.tilts)

    def _on_morphed_mesh(self, displacement: NDArray[np.float32], *, thorough: bool) -> Simulation:
        morphed = self._morph.morphed(displacement)
        self._static.check()  # before the long drop
        return self._told(morphed, self._drop(morphed.tets, thorough=thorough))

    def _told(self, morphed: Morphed, result: Drop) -> Simulation:
        """Result of the drop and the load cases on morphed tetrahedra."""
        return self._under_loads(self._measured(morphed, result, self._reading, self._transfer), morphed.tets)

    def _on_fresh_mesh(self, displacement: NDArray[np.float32]) -> Simulation:
        """The same on a new mesh of the styled surface; on the morphed one, which the record then says, if fTetWild cannot mesh it."""
        styled = self.surface.displaced(displacement)
        try:
            tets = tetrahedralise(styled, len(self.tets.tets), cache=self.cache)
        except MechStyleError as error:
            fallback = self._on_morphed_mesh(displacement, thorough=True)
            return replace(fallback, meshing=f"morphed, as a fresh mesh of the styled surface could not be had: {error}")
        whole = Morphed(tets=tets, displacement=np.asarray(displacement, np.float32), backed_off=0.0, deviation=0.0, remesh=False)
        transfer = Transfer(styled, tets, self.recipe.transfer)
        dropped = self._measured(whole, self._drop(tets, thorough=True), SurfaceStress(tets), transfer)
        if not self.recipe.loads:
            return replace(dropped, meshing="fresh")
        loaded = self._under_loads(dropped, self._morph.morphed(displacement).tets)
        return replace(loaded, meshing="fresh for the drop, morphed for the loads")

    @cached_property
    def _static(self) -> StaticTest:
        return StaticTest(self.tets, self.recipe.loads, self.recipe.element)

    def _under_loads(self, dropped: Simulation, tets: TetMesh) -> Simulation:
        """A drop's result raised to what the recipe's load cases do to morphed tetrahedra, on which their places are known."""
        if dropped.failure or not self.recipe.loads:
            return dropped
        try:
            responses = self._static.run(tets, self.recipe.material, self.recipe.across_layers)
        except SimulationFailed as error:
            return replace(dropped, failure=str(error))
        result = dropped
        for name, response in responses.items():
            deciding = self._reading.of_load(tets, response.von_mises, response.corners, self._static.borders[name])
            case = measures(tets, response.von_mises, deciding)
            field = self._transfer.to_surface(deciding.field).astype(np.float32)
            told = LoadResult(
                name=name, peak=case.peak, where=case.where, deflection=response.deflection,
                surface=deciding.resolved, averaged=deciding.averaged,
            )  # fmt: skip
            result = replace(
                result,
                stress=np.maximum(result.stress, field),
                envelope=np.maximum(result.envelope, field),
                as_placed=result.as_placed.or_worse(case),
                loaded=(*result.loaded, told),
            )
        return result

    def _drop(self, tets: TetMesh, *, thorough: bool) -> Drop:
        normals, test = self._orientations.normals[: None if thorough else 1 + self.recipe.tilts], prescribed(self.recipe)
        return drop(tets, self.recipe.material, normals, test, device=self.device, progress=self.progress, period=self._period)

    @cached_property
    def _period(self) -> float | None:
        """Of `period_of`."""
        return period_of(self.tets, self.recipe, self.memo, self._trusted)

    def _measured(self, morphed: Morphed, result: Drop, reading: SurfaceStress, transfer: Transfer) -> Simulation:
        """Measures and surface fields of a drop; all zero, with the reason, for one that failed."""
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
            backed_off=morphed.backed_off,
            deviation=morphed.deviation,
            level_share=self._base.share(morphed.displacement),
            time_step=result.time_step,
            steps=result.steps,
            added_mass=result.added_mass,
            failure=result.failure,
        )
        if result.failure:
            return failed
        stresses = zip(result.von_mises, result.corners, result.contact, strict=True)
        deciding = [reading.of_landing(tets, points, corners, touched) for points, corners, touched in stresses]
        landings = self._landings(tets, result, deciding)
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

    def _landings(self, tets: TetMesh, result: Drop, deciding: list[Deciding]) -> tuple[Landing, ...]:
        """Measures and phases of each landing."""
        ways, known = self._orientations, (result.von_mises, deciding, result.phases, result.endings)
        drops = zip(ways.names, ways.normals, ways.weights, *known, strict=False)  # as placed may be all
        return tuple(
            Landing(
                name=name,
                normal=(float(x), float(y), float(z)),
                weight=float(weight),
                measures=measures(tets, stress, one),
                touches=tuple(phase.speed for phase in phases),
                ended=ended,
            )
            for name, (x, y, z), weight, stress, one, phases, ended in drops
        )
