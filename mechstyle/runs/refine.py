"""The result in four times as many faces: the run replayed on the quartered surface, and its drop test.

A drawn style knows finer edges than 25k vertices can carry. At every new vertex it is drawn anew, and is then led through the run that was:
the same masks, shares, step limits and bounds, interpolated, and the same shares of relief taken back. A learnt style knows only the
vertices it was learnt at, and is interpolated between them: a style field, whose frequencies are higher than the vertices are dense, gives
unrelated values there. Either result is simulated as a surface of its own, because a verdict on the coarse one does not say it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import BadInput
from mechstyle.geometry.level_base import LevelBase
from mechstyle.geometry.subdivision import quartered
from mechstyle.loop.engine import STEP_LIMIT, STYLE_FIELDS, Bounds, Stylizer, advanced
from mechstyle.loop.objects import Objects
from mechstyle.loop.store import Entry, Store
from mechstyle.records import Checkpoint, Recipe, Simulation, Verdict
from mechstyle.records.mesh import Field, Floats, SurfaceMesh
from mechstyle.runs.images import raster_of
from mechstyle.runs.plugins import made
from mechstyle.simulation.part import Workpiece, bounds_for
from mechstyle.simulation.simulator import DropSimulator
from mechstyle.styling.combination import combined, places
from mechstyle.styling.dimensions import Dimensions
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.fine_canvas import FineCanvas
from mechstyle.styling.drawn import ProceduralStylizer, canvas_for, target
from mechstyle.styling.prompt import Reading, reading_of

INTERPOLATED = "what the style learnt at the vertices is interpolated between them: the file has more faces, but no finer detail"
"""Said of a learnt style in four times as many faces."""


@dataclass(frozen=True, eq=False)
class Refined:
    """The finer result.

    Attributes:
        original: The quartered, unstylized surface.
        styled: The styled, coloured surface as it was simulated.
        simulation: Its drop test in all orientations.
        verdict: What that means.
        notes: What a user should know of how it was refined, one sentence each.
    """

    original: SurfaceMesh
    styled: SurfaceMesh
    simulation: Simulation
    verdict: Verdict
    notes: tuple[str, ...]


def refined(store: Store, part: Workpiece, digest: str, *, device: str = "cpu") -> Refined:
    """A checkpoint on the quartered surface, dropped.

    Args:
        store: The run.
        part: Its part.
        digest: The checkpoint.
        device: `cpu` or `cuda`.

    Raises:
        BadInput: If it is the unstylized part, which has no style.
    """
    past = _past(store, digest)
    if len(past) < 2:
        raise BadInput("iteration 0 is the original part, which has no style to draw finer: export it without --fine")
    twin = _Twin(part, store.objects)
    recipes = {name: store.recipe(name) for name in {entry.recipe for entry in past}}
    for before, after in pairwise(store.checkpoint(entry.digest) for entry in past):
        twin.follow(before, after, recipes[after.recipe])
    drawn = recipes[after.recipe]
    recipe = msgspec.structs.replace(drawn, surface=twin.surface.digest)
    simulator = DropSimulator(twin.surface, part.tets, recipe, store.memo, device=device, at=twin.at)
    simulation = simulator.simulate(twin.displacement, thorough=True)
    styled = twin.surface.displaced(simulation.displacement).coloured(twin.coloured(after, drawn))
    notes = (INTERPOLATED,) if any(map(_learnt, recipes.values())) else ()
    return Refined(twin.surface, styled, simulation, simulator.judge(simulation), notes)


def _past(store: Store, digest: str) -> list[Entry]:
    """A checkpoint and all before it, oldest first, without their arrays."""
    past = []
    while digest:
        past.append(store.entry(digest))
        digest = past[-1].parent
    return past[::-1]


@dataclass(eq=False)
class _Twin:
    """A part and its quartered twin, led through the same run; `displacement` is the twin's [mm]."""

    part: Workpiece
    objects: Objects
    displacement: Field = field(init=False)

    def __post_init__(self) -> None:
        self._cut = quartered(self.part.surface)
        self.surface = self._cut.mesh
        self.displacement = np.zeros(len(self.surface.vertices), np.float32)
        self._style: tuple[object, ...] = ()
        self._grown = np.zeros(len(self.part.surface.vertices), np.float32), self.displacement

    @property
    def at(self) -> Field | None:
        """What the part's tetrahedra were made for, at the twin's vertices [mm], shape [fine_count]."""
        return None if self.part.at is None else self._spread(self.part.at)

    @cached_property
    def _base(self) -> LevelBase:
        return LevelBase(self.surface)

    def follow(self, before: Checkpoint, after: Checkpoint, recipe: Recipe) -> None:
        """Do on the twin what led from one checkpoint to the next."""
        style = tuple(getattr(recipe, name) for name in STYLE_FIELDS)
        if style != self._style:
            self._take_up(recipe, before)
            self._style = style
        if _learnt(recipe):
            grown = self.displacement + self._spread(after.displacement - before.displacement)
            self.displacement = self._fine_bounds.clipped(grown)
            return
        if after.iteration > before.iteration:
            mask = before.mask if after.reason else after.mask  # a branch is restrained anew, and a drop changes the mask afterwards
            through = mask * before.share
            reached = advanced(before.displacement, through, self._increment(self._coarse, self._bounds), self._bounds, recipe)
            finer = self._increment(self._fine, self._fine_bounds)
            self._grown = reached, advanced(self.displacement, self._spread(through), finer, self._fine_bounds, recipe)
        reached, finer = self._grown  # what a correction leaves is a share of the finished relief, not of the correction before
        self.displacement = finer * self._spread(_left(reached, after.displacement))

    def coloured(self, last: Checkpoint, recipe: Recipe) -> Field:
        """Display RGB of the twin, shape [fine_count, 3]: drawn anew, but interpolated where it was learnt or the part keeps its own."""
        if _learnt(recipe):
            return self._spread(last.colour)
        kept = self._spread(np.asarray(bounds_for(self.part, recipe)[0].uncoloured, np.float32))
        return np.asarray((1.0 - kept) * self._fine.proposal().colour + kept * self._spread(last.colour), np.float32)

    def _take_up(self, recipe: Recipe, before: Checkpoint) -> None:
        """Begin with the style of a recipe, from the surface another one has left if there was one."""
        self._bounds, _ = bounds_for(self.part, recipe)
        spread = [self._spread(getattr(self._bounds, name)) for name in ("thickness", "inward", "outward", "freedom")]
        base = None if self._bounds.base is None else self._base
        self._fine_bounds = Bounds(spread[0], spread[1], spread[2], spread[3], base=base)
        if _learnt(recipe):
            return
        self._coarse, self._fine = self._stylizers(recipe)
        if self._style:
            self._coarse.start_from(before.displacement, before.colour.astype(np.float32))
            self._fine.start_from(self.displacement, self._spread(before.colour))

    def _stylizers(self, recipe: Recipe) -> tuple[Stylizer, Stylizer]:
        """The stylizers of a recipe for the part and for its twin; the twin's draws what the part's drew, finer."""
        if recipe.stylizer:
            return made(self.part.surface, self._bounds, recipe), made(self.surface, self._fine_bounds, recipe)
        reading, raster = reading_of(recipe), raster_of(recipe, self.objects)
        shares = places(reading, self.part.surface, self.part.thickness).shares
        thickness = self._bounds.thickness
        coarse = [canvas_for(recipe, wish, self.part.surface, thickness, raster) for wish in reading.wishes]
        fine = [FineCanvas(self.surface, self._cut.parents, canvas) for canvas in coarse]
        return (
            _drawn(recipe, reading, coarse, shares, self._bounds),
            _drawn(recipe, reading, fine, self._spread(shares.T).T.astype(np.float64), self._fine_bounds),
        )

    def _increment(self, stylizer: Stylizer, bounds: Bounds) -> Field:
        """Increment of a stylizer's levelled proposal in one iteration [mm], limited to the engine's step."""
        limit, proposed = np.float32(STEP_LIMIT * self.part.surface.size), bounds.levelled(stylizer.proposal().displacement)
        return np.clip(bounds.levelled(stylizer.step().displacement) - proposed, -limit, limit)

    def _spread(self, values: NDArray[np.floating]) -> Field:
        """Values of the part at the twin's vertices."""
        return np.asarray(self._cut.interpolation @ values.astype(np.float32), np.float32)


def _learnt(recipe: Recipe) -> bool:
    """Whether a style is known at the vertices only: no drawing says what it is between them."""
    return not recipe.stylizer and (recipe.guidance == "clip" or recipe.field == "network")


def _drawn(recipe: Recipe, reading: Reading, canvases: Sequence[Canvas], shares: Floats, bounds: Bounds) -> Stylizer:
    """The stylizer towards what a prompt asks for, each wish drawn on a canvas of its own."""
    mesh = canvases[0].mesh
    targets = [
        target(
            mesh,
            wish,
            Dimensions.of(recipe, wish),
            seed=recipe.seed,
            thickness=bounds.thickness,
            inward=bounds.inward,
            outward=bounds.outward,
            canvas=canvas,
        )
        for wish, canvas in zip(reading.wishes, canvases, strict=True)
    ]
    return ProceduralStylizer(mesh, combined(mesh, targets, shares))


def _left(before: Field, after: Field) -> Field:
    """Share of the relief that retraction, the tetrahedra or a correction left at each vertex, in [0, 1]."""
    safe = np.where(before == 0.0, 1.0, before)
    return np.asarray(np.where(before == 0.0, 1.0, np.clip(after / safe, 0.0, 1.0)), np.float32)
