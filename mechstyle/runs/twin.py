"""The finer twin of a part, led through the run that was: the style drawn anew at every new vertex, under the same restraint.

What masks, shares and corrections left of the coarse relief is left of the fine one, interpolated; step limits and bounds are the same. A
style that is known at the vertices only, learnt or plugged in, is interpolated between them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mechstyle.geometry.going_on import GoOn, regardless
from mechstyle.geometry.level_base import WHOLLY, LevelBase
from mechstyle.geometry.subdivision import Subdivided
from mechstyle.loop import correction
from mechstyle.loop.bounds import Bounds, advanced, unrestrained
from mechstyle.loop.engine import STEP_LIMIT, STYLE_FIELDS, Stylizer
from mechstyle.loop.objects import Objects
from mechstyle.records import Checkpoint, Recipe
from mechstyle.records.mesh import Bools, Field
from mechstyle.runs.plugins import made
from mechstyle.runs.stylizers import drawing_of, drawn
from mechstyle.simulation.part import Workpiece, bounds_for
from mechstyle.styling.drawing.fine_canvas import FineCanvas
from mechstyle.styling.drawn import ProceduralStylizer
from mechstyle.styling.prompt import reading_of


@dataclass(eq=False)
class Twin:
    """A part and its finer twin, led through the same run.

    Attributes:
        part: The part.
        cut: The same in smaller faces.
        objects: Those of the run, which keep its picture; None for cached ones.
        go_on: Asked while a style is drawn whether to; what it raises ends it.
        displacement: The twin's [mm], shape [fine_count].
        bounds: How far the style in force may go on the twin.
        stands: The state it was led to, None before the first.
        interpolated: Whether a style on the way was.
    """

    part: Workpiece
    cut: Subdivided
    objects: Objects | None = None
    go_on: GoOn = regardless
    displacement: Field = field(init=False)
    bounds: Bounds = field(init=False)
    stands: Checkpoint | None = None
    interpolated: bool = False

    def __post_init__(self) -> None:
        self.displacement = np.zeros(len(self.cut.mesh.vertices), np.float32)
        self._style: tuple[object, ...] = ()
        self._drawn: tuple[Stylizer, Stylizer] | None = None
        self._grown = np.zeros(len(self.part.surface.vertices), np.float32), self.displacement

    @cached_property
    def _base(self) -> LevelBase:
        return LevelBase(self.cut.mesh)

    def follow(self, before: Checkpoint, after: Checkpoint, recipe: Recipe) -> None:
        """Do on the twin what led from one checkpoint to the next."""
        self.stands = after
        style = tuple(getattr(recipe, name) for name in STYLE_FIELDS)
        if style != self._style:
            self._take_up(recipe, before)
            self._style = style
        if self._drawn is None:
            self.interpolated = True
            grown = self.displacement + self._spread(after.displacement - before.displacement)
            self.displacement = self.bounds.clipped(grown)
            return
        if after.iteration > before.iteration:
            mask = before.mask if after.reason else after.mask  # a branch is restrained anew, and a drop changes the mask afterwards
            through = mask * before.share
            coarse, fine = self._increments(*self._drawn)
            reached = advanced(before.displacement, through, coarse, self._bounds, recipe)
            self._grown = reached, advanced(self.displacement, self._spread(through), fine, self.bounds, recipe)
        self.displacement = self._corrected(after.displacement, recipe)

    def _corrected(self, relief: Field, recipe: Recipe) -> Field:
        """What the tetrahedra or a correction left of the twin's relief, and what was given back of what it lacked [mm]."""
        reached, finer = self._grown  # a correction is told by shares of the finished relief, not of the correction before
        if not relief.any():
            return np.zeros_like(finer)
        kept = finer * self._spread(correction.left(reached, relief))
        kept[self._laid_flat(reached, relief)] = 0.0
        if self._drawn is None or not np.any(np.abs(relief) > np.abs(reached)):
            return kept
        coarse, fine = self._drawn
        wanted = unrestrained(coarse.proposal().displacement, self._bounds, recipe)
        asked = unrestrained(fine.proposal().displacement, self.bounds, recipe)
        share = self._spread(correction.given_back(reached, relief, wanted))
        return np.asarray(kept + share * correction.missing(finer, asked), np.float32)

    def _laid_flat(self, reached: Field, relief: Field) -> Bools:
        """Whether a vertex of the twin lies between some that a correction laid flat under the part, shape [fine_count].

        Of a level base the highest areas had no relief to be taken; drawn finer, what lies between them has.
        """
        standing = self._bounds.standing
        if not np.any(standing & (relief == 0.0) & (reached != 0.0)):
            return np.zeros(len(self.displacement), bool)
        return self._spread(np.asarray(standing & (relief == 0.0), np.float32)) > WHOLLY

    def coloured(self, last: Checkpoint, recipe: Recipe) -> Field:
        """Display RGB of the twin, shape [fine_count, 3]: drawn anew, but interpolated where it was learnt or the part keeps its own."""
        if self._drawn is None:
            return self._spread(last.colour)
        kept = self._spread(np.asarray(bounds_for(self.part, recipe)[0].uncoloured, np.float32))
        return np.asarray((1.0 - kept) * self._drawn[1].proposal().colour + kept * self._spread(last.colour), np.float32)

    def _take_up(self, recipe: Recipe, before: Checkpoint) -> None:
        """Begin with the style of a recipe, from the surface another one has left if there was one."""
        self._bounds, _ = bounds_for(self.part, recipe)
        spread = [self._spread(getattr(self._bounds, name)) for name in ("thickness", "inward", "outward", "freedom")]
        base, plain = None if self._bounds.base is None else self._base, self._bounds.plain
        inside = plain if isinstance(plain, bool) else self._spread(plain.astype(np.float32)) == 1.0
        self.bounds = Bounds(spread[0], spread[1], spread[2], spread[3], base=base, plain=inside)
        self._drawn = self._stylizers(recipe)
        if self._drawn is None:
            return
        coarse, fine = self._drawn
        if self._style:
            coarse.start_from(before.displacement, before.colour.astype(np.float32))
            fine.start_from(self.displacement, self._spread(before.colour))
        self._proposed = self._bounds.levelled(coarse.proposal().displacement), self.bounds.levelled(fine.proposal().displacement)

    def _stylizers(self, recipe: Recipe) -> tuple[Stylizer, Stylizer] | None:
        """The stylizers of a recipe for the part and for its twin; the twin's draws what the part's drew, finer.

        None for a style that is known at the vertices only: no drawing says what it is between them.
        """
        if recipe.stylizer:
            plugged = made(self.part.surface, self._bounds, recipe)
            return (plugged, made(self.cut.mesh, self.bounds, recipe)) if isinstance(plugged, ProceduralStylizer) else None
        if recipe.guidance == "clip" or recipe.field == "network":
            return None
        reading = reading_of(recipe)
        coarse = drawing_of(self.part, self._bounds, recipe, reading, self.objects, self.go_on)
        canvases = [FineCanvas(self.cut.mesh, self.cut.interpolation, canvas) for canvas in coarse.canvases]
        shares = self._spread(coarse.shares.T).T.astype(np.float64)
        fine = drawn(recipe, reading, canvases, shares, self.bounds, self.go_on)
        targets = ((self.part.surface, coarse.target), (self.cut.mesh, fine))
        ours, theirs = (ProceduralStylizer(mesh, target, recipe.iterations) for mesh, target in targets)
        return ours, theirs

    def _increments(self, coarse: Stylizer, fine: Stylizer) -> tuple[Field, Field]:
        """Increments of the levelled proposals of part and twin in one iteration [mm], limited to the engine's step."""
        limit, before = np.float32(STEP_LIMIT * self.part.surface.size), self._proposed
        self._proposed = (
            self._bounds.levelled(coarse.step().displacement),
            self.bounds.levelled(fine.step().displacement),
        )
        ours, theirs = (np.clip(now - then, -limit, limit) for now, then in zip(self._proposed, before, strict=True))
        return ours, theirs

    def _spread(self, values: NDArray[np.floating]) -> Field:
        """Values of the part at the twin's vertices."""
        return np.asarray(self.cut.interpolation @ values.astype(np.float32), np.float32)
