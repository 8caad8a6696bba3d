"""Which way up to print the part of a run: what its layers bear in falls and under loads, what hangs over, how high it is.

A part lands as it always did, whichever way up it was printed; what changes is where its layers lie. So a way up is judged by the run's own
landings and load cases, with layers along it; up and down are the same layers, and one test serves both.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import msgspec
import numpy as np

from mechstyle.errors import BadInput
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.orientations import FLAT, resting
from mechstyle.geometry.upright import standing
from mechstyle.records import Recipe, Simulation, judge
from mechstyle.records.regions import Point
from mechstyle.runs.run import Run
from mechstyle.simulation.part import Stage

COUNT = 6
"""Ways up that are compared, at most."""
ALIKE = 0.1
"""Shares of what is allowed within a step of this count as alike …"""
LITTLE = 0.5
"""… and all below the end of the step that begins here: meshes of one part differ by as much."""


class WayUp(msgspec.Struct, frozen=True, kw_only=True):
    """A way up to print a part.

    Attributes:
        name: What it is called.
        up: Direction of the part's frame that points up in the printer.
        permanent_set: What stays bent in the worst test, layers judged [mm]; None if that is not known.
        used: Share of what is allowed that this test uses, of bend or of strain: above 1 the part fails. None as before.
        overhang: Area that needs support [mm²].
        height: Height in the printer [mm].
        base: Area on the bed [mm²].
    """

    name: str
    up: Point
    permanent_set: float | None
    used: float | None
    overhang: float
    height: float
    base: float

    @property
    def rank(self) -> tuple[float, float, float]:
        """What orders the ways up, least first: the share used in steps of ALIKE, then overhang, then height."""
        return np.floor(max(self.used or 0.0, LITTLE) / ALIKE), self.overhang, self.height


class WaysUp(msgspec.Struct, frozen=True, kw_only=True):
    """Ways up to print a part, the best first, what is assumed of layers, in words, and drop tests that had to be run for it."""

    ways: tuple[WayUp, ...]
    layers: str
    drops: int


def ways_up(
    run: Run, iteration: int | None = None, *, count: int = COUNT, stage: Stage = no_progress, progress: Progress = no_progress
) -> WaysUp:
    """Rank the flat sides a part can be printed on, at most `count`, and the way it was placed; for the last iteration by default.

    `stage` is called with which is being dropped, `progress` with the fraction of that drop.

    Raises:
        BadInput: If there are no ways to compare.
        DamagedStore: If the part encloses nothing.
    """
    if not 1 <= count <= 26:
        raise BadInput(f"{count} ways up: compare 1 to 26")
    state, recipe = run.checkpoint(iteration), run.store.recipe(run.checkpoint(iteration).recipe)
    mesh, test, material = run.surface(iteration), recipe.test, recipe.test.material
    plain = run.record.droppable(run.part, run.store.root / "part.json").surface  # whose flat sides are flat
    ways = resting(plain.vertices, plain.centre_of_mass, count)
    dropped = dict[Point, Worst]()

    def worst(up: Point) -> Worst | None:
        """The worst test for layers along a direction; None if the material's layers are not known."""
        x, y, z = up
        down = (0.0 - x, 0.0 - y, 0.0 - z)
        if material.layer_ratio is None:
            return None
        if material.layer_ratio == 1.0 or test.build_direction in (up, down):
            return _worst(run.simulation(iteration), recipe)
        axis = max(up, down)
        if axis not in dropped:
            stage(f"drop with layers along ({axis[0]:g}, {axis[1]:g}, {axis[2]:g})")
            simulator = run.simulator(recipe, progress)
            body, _ = simulator.meshes.mesh_for(state.displacement)
            layered = recipe.with_settings(build_direction=axis).on(tetrahedra=body.tets.digest)
            simulator = replace(simulator, part=replace(simulator.part, tets=body.tets, at=body.at), recipe=layered)
            dropped[axis] = _worst(simulator.simulate(state.displacement, thorough=True), layered)
        return dropped[axis]

    found = [
        WayUp(name=_called(name, up), up=up, permanent_set=its and its.bend, used=its and its.used, **standing(mesh, up)._asdict())
        for name, up, its in ((name, up, worst(up)) for name, up in zip(ways.names, map(_rounded, ways.normals), strict=True))
    ]
    source = material.layer_source or material.source
    layers = f"strength across layers of {material.label} is not known, so ways up are ranked by overhang and height only"
    if material.layer_ratio is not None:
        layers = f"across its layers {material.label} bears {material.layer_ratio:g} of what it bears along them ({source})"
    return WaysUp(ways=tuple(sorted(found, key=lambda way: way.rank)), layers=layers, drops=len(dropped))


def _rounded(normal: np.ndarray) -> Point:
    """A direction to four digits, so that what is the same but for noise is dropped once."""
    x, y, z = (float(round(part, 4)) + 0.0 for part in normal)
    return x, y, z


def _called(name: str, up: Point) -> str:
    """What a way up is called: as placed, or by the side of the part that lies on the bed."""
    if name == FLAT:
        return "as placed"
    axis = int(np.argmax(np.abs(up)))
    side = f"{'-' if up[axis] > 0 else '+'}{'xyz'[axis]}"
    return f"on its {side} side" if abs(up[axis]) > 0.99 else f"tilted on its {side} side"


class Worst(NamedTuple):
    """What stays bent in the worst test [mm], and the share of what is allowed that it uses."""

    bend: float
    used: float


def _worst(simulation: Simulation, recipe: Recipe) -> Worst:
    """The worst test of a part by itself; infinite if there is no answer."""
    row = judge(simulation, None, recipe).deciding
    return Worst(math.inf, math.inf) if row is None else Worst(row.permanent_set, row.used)
