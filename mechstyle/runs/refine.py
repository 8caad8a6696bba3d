"""The delivered surface: a run led again on its part with smaller faces, and the last test, which is about that very surface.

A drawn style knows finer edges than 25k vertices can carry. At every new vertex it is drawn anew, and is then led through the run that was:
the same masks, shares, step limits and bounds, interpolated, and the same shares of relief taken back. A learnt style, or one plugged in
that has no finished target, knows only the vertices it was made at, and is interpolated between them: a style field, whose frequencies are
higher than the vertices are dense, gives unrelated values there. Either result is simulated as a surface of its own: a verdict on the
coarse one does not say it.

Checkpoints stay those of the loop's vertices. What is delivered follows from recipe and checkpoints; it is kept beside them by its
checkpoint's digest only so that a picture, a report and a file need not draw it three times.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import BadInput
from mechstyle.geometry.going_on import GoOn, regardless
from mechstyle.geometry.level_base import LevelBase
from mechstyle.geometry.subdivision import Subdivided, refined_to
from mechstyle.geometry.untangling import untangled
from mechstyle.loop import correction, minimum_wall
from mechstyle.loop.bounds import Bounds, advanced, unrestrained
from mechstyle.loop.engine import STEP_LIMIT, STYLE_FIELDS, Stylizer
from mechstyle.loop.objects import Objects
from mechstyle.loop.store import Store
from mechstyle.records import Checkpoint, Recipe, Simulation, Verdict
from mechstyle.records.mesh import Field, SurfaceMesh, frozen_array
from mechstyle.runs.plugins import made
from mechstyle.runs.stylizers import drawing_of, drawn
from mechstyle.simulation.part import Workpiece, bounds_for
from mechstyle.simulation.simulator import DropSimulator
from mechstyle.styling.drawing.fine_canvas import FineCanvas
from mechstyle.styling.drawn import ProceduralStylizer
from mechstyle.styling.prompt import reading_of

VERSION = 2
"""Counts changes that alter the delivered surface, so that what older code kept is drawn again."""
LEAST = 100_000
"""Vertices of a delivered surface unless told …"""
EDGE = 0.6
"""… or more, until its edges are about as long as this [mm], half again the width of a usual line of plastic …"""
MOST = 225_000
"""… up to this, nine times the usual vertices of a run: beyond it drawing, picture and file take too long to come with every run."""
MOST_PARTS = 4
"""Parts that an edge of the loop's surface is cut into at most: where a style lies was decided there, and what that mesh could not show is
not in it."""

INTERPOLATED = "what the style learnt at the vertices is interpolated between them: the file has more faces, but no finer detail"
"""Said of a style that is not drawn."""


@dataclass(frozen=True, eq=False)
class Fine:
    """What is kept of a delivered surface.

    Attributes:
        displacement: Along the normals of the subdivided surface [mm], shape [fine_count]; as it was simulated, if it was.
        colour: Display RGB in [0, 1], shape [fine_count, 3].
        interpolated: Whether any of its styles is interpolated.
        simulation: Its test in all orientations, None if it was not dropped.
    """

    displacement: NDArray[np.float32]
    colour: NDArray[np.float16]
    interpolated: bool
    simulation: Simulation | None = None

    def __post_init__(self) -> None:
        """Freeze the fields over the surface; ValueError if they are not of one surface."""
        count = len(self.displacement)
        object.__setattr__(self, "displacement", frozen_array(self.displacement, np.float32, (count,), "displacement"))
        object.__setattr__(self, "colour", frozen_array(self.colour, np.float16, (count, 3), "colour"))
        if self.simulation is not None and len(self.simulation.displacement) != count:
            raise ValueError(f"a test of {len(self.simulation.displacement)} vertices is no test of {count}")


@dataclass(frozen=True, eq=False)
class Refined:
    """A delivered surface.

    Attributes:
        cut: The unstylized part in smaller faces.
        styled: The styled, coloured surface; as it was simulated, if it was.
        displacement: Its relief [mm], shape [fine_count].
        simulation: Its test in all orientations, None if it was not dropped.
        notes: What a user should know of how it was refined, one sentence each.
    """

    cut: Subdivided
    styled: SurfaceMesh
    displacement: Field
    simulation: Simulation | None
    notes: tuple[str, ...]

    @property
    def original(self) -> SurfaceMesh:
        """The unstylized surface in as many faces."""
        return self.cut.mesh


_last: WeakKeyDictionary[SurfaceMesh, tuple[int, Subdivided]] = WeakKeyDictionary()
"""The last smaller faces of each surface, and the vertices wanted: test, file and picture of a run are all about them."""


def vertices_for(surface: SurfaceMesh, asked: int | None) -> int:
    """Vertices that the delivered surface of a part is to have at least: those asked for, or what its size and a printer's lines need."""
    if asked:
        return asked
    by_edge = float(surface.face_areas.sum()) / (0.5 * np.sqrt(3.0) * EDGE**2)
    return round(min(max(by_edge, LEAST), MOST))


@dataclass(eq=False)
class Refinement:
    """The finer twin of a part in a run, led along one lane.

    Attributes:
        store: The run.
        part: Its part.
        simulator: The drop test of the part under the recipe in force.
        asked: Vertices wanted, None for what the part's size needs.
    """

    store: Store
    part: Workpiece
    simulator: DropSimulator
    asked: int | None = None

    @cached_property
    def cut(self) -> Subdivided:
        """The part in smaller faces."""
        wanted = vertices_for(self.part.surface, self.asked)
        known, cut = _last.get(self.part.surface, (0, None))
        if cut is None or known != wanted:
            cut = refined_to(self.part.surface, wanted, most_parts=MOST_PARTS)
            _last[self.part.surface] = wanted, cut
        return cut

    def tested(self, state: Checkpoint) -> Simulation:
        """Of `loop.engine.Delivery`: what drawing finer leaves of the state is no part of the loop, so its displacement stays."""
        relief = self._relief(self._led_to(state))
        if not relief.any():
            return self._unstylized
        return _of_the_loop(self._dropped(relief, state.displacement), state.displacement, self.cut)

    @property
    def _unstylized(self) -> Simulation:
        return self.simulator.simulate(np.zeros(len(self.part.surface.vertices), np.float32), thorough=True)

    def _dropped(self, relief: Field, of_the_loop: Field) -> Simulation:
        """The test of a relief of the twin, drawn finer from one of the loop [mm]; without any, that of the unstylized part.

        The tetrahedra are those that carry the loop's, which are as fine as they may get: made for the finer one they carried some 3 % more
        of it (a pen holder in brick: 90 % instead of 86 % with edges of 0.6 mm), and meshing takes longer than all else.
        """
        if not relief.any():
            return _spread_out(self._unstylized, self.cut)
        carrier, meshing = self.simulator.carrier(of_the_loop)
        return replace(carrier.on(self.cut).simulate(relief, thorough=True), meshing=meshing)

    def of(self, digest: str, *, drop: bool) -> Refined:
        """The delivered surface of a checkpoint, as it was kept or made now.

        Args:
            digest: The checkpoint.
            drop: Whether to drop it, unless that was done before.

        Raises:
            BadInput: If it is the unstylized part, which has no style.
        """
        found = self.kept(digest)
        if found is None or (drop and found.simulation is None):
            made = self._made(self.store.checkpoint(digest), drop=drop)
            self.store.memo.remember(self._name(digest), made, anew=True)
            found = self._whole(made)
        return found

    def kept(self, digest: str) -> Refined | None:
        """The delivered surface of a checkpoint, None if it was not made yet: drawing it takes seconds."""
        fine = self.store.memo.recall(self._name(digest), Fine)
        return None if fine is None or len(fine.displacement) != len(self.cut.mesh.vertices) else self._whole(fine)

    def shown(self, digest: str, known: dict[str, Refined], *, draw: bool) -> Refined | None:
        """The delivered surface of a checkpoint to look at; the last is kept in `known`. None if it was not made yet and is not to be."""
        if digest not in known:
            found = self.of(digest, drop=False) if draw else self.kept(digest)
            if found is None:
                return None
            known.clear()  # one is enough, and each takes tens of megabytes
            known[digest] = found
        return known[digest]

    def _name(self, digest: str) -> str:
        return f"delivered-{VERSION}-{self.asked or 0}-{digest}"

    def _whole(self, fine: Fine) -> Refined:
        styled = self.cut.mesh.displaced(fine.displacement).coloured(fine.colour)
        return Refined(self.cut, styled, fine.displacement, fine.simulation, (INTERPOLATED,) if fine.interpolated else ())

    def verdict(self, found: Refined) -> Verdict | None:
        """The verdict on a delivered surface, None if it was not dropped."""
        return None if found.simulation is None else self.simulator.judge(found.simulation)

    def _made(self, state: Checkpoint, *, drop: bool) -> Fine:
        if state.iteration == 0:
            raise BadInput("iteration 0 is the original part, which has no style to draw finer: export it with --coarse")
        twin = self._led_to(state)
        relief, colour = self._relief(twin), twin.coloured(state, self.store.recipe(state.recipe)).astype(np.float16)
        simulation = self._dropped(relief, state.displacement) if drop else None
        return Fine(relief if simulation is None else simulation.displacement, colour, twin.interpolated, simulation)

    def _relief(self, twin: _Twin) -> Field:
        """The twin's [mm], shape [fine_count], lowered where it would pass through itself."""
        return untangled(self.cut.mesh, twin.displacement, self._go_on)

    def _go_on(self) -> None:
        self.simulator.progress(0.0)

    @cached_property
    def _twin(self) -> _Twin:
        return _Twin(self.part, self.cut, self.store.objects, self._go_on)

    def _led_to(self, state: Checkpoint) -> _Twin:
        """The twin led to a state from wherever it stands, which must be in the past of the state or one of its iteration."""
        past = [state]
        while past[-1].parent and (self._twin.stands is None or past[-1].iteration > self._twin.stands.iteration):
            past.append(self.store.checkpoint(past[-1].parent))
        for before, after in pairwise([*([] if self._twin.stands is None else [self._twin.stands]), *past[::-1]]):
            self._go_on()  # a run has hundreds
            self._twin.follow(before, after, self.store.recipe(after.recipe))
        return self._twin


@dataclass(eq=False)
class _Twin:
    """A part and its finer twin, led through the same run.

    Attributes:
        part: The part.
        cut: The same in smaller faces.
        objects: Those of the run, which keep its picture; None for cached ones.
        go_on: Asked while a style is drawn whether to; what it raises ends it.
        displacement: The twin's [mm], shape [fine_count].
        stands: The state it was led to, None before the first.
        interpolated: Whether a style on the way was.
    """

    part: Workpiece
    cut: Subdivided
    objects: Objects | None = None
    go_on: GoOn = regardless
    displacement: Field = field(init=False)
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
            self.displacement = self._fine_bounds.clipped(grown)
            return
        if after.iteration > before.iteration:
            mask = before.mask if after.reason else after.mask  # a branch is restrained anew, and a drop changes the mask afterwards
            through = mask * before.share
            coarse, fine = self._increments(*self._drawn)
            reached = advanced(before.displacement, through, coarse, self._bounds, recipe)
            self._grown = reached, advanced(self.displacement, self._spread(through), fine, self._fine_bounds, recipe)
        self.displacement = self._corrected(after.displacement, recipe)

    def _corrected(self, relief: Field, recipe: Recipe) -> Field:
        """What retraction, the tetrahedra or a correction left of the twin's relief, and what was given back of what it lacked [mm]."""
        reached, finer = self._grown  # a correction is told by shares of the finished relief, not of the correction before
        if not relief.any():
            return np.zeros_like(finer)
        kept = finer * self._spread(correction.left(reached, relief))
        if self._drawn is None or not np.any(np.abs(relief) > np.abs(reached)):
            return kept
        coarse, fine = self._drawn
        wanted = unrestrained(coarse.proposal().displacement, self._bounds, recipe)
        asked = unrestrained(fine.proposal().displacement, self._fine_bounds, recipe)
        share = self._spread(correction.given_back(reached, relief, wanted))
        return np.asarray(kept + share * correction.missing(finer, asked), np.float32)

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
        self._fine_bounds = Bounds(spread[0], spread[1], spread[2], spread[3], base=base, plain=inside)
        self._drawn = self._stylizers(recipe)
        if self._drawn is None:
            return
        coarse, fine = self._drawn
        if self._style:
            coarse.start_from(before.displacement, before.colour.astype(np.float32))
            fine.start_from(self.displacement, self._spread(before.colour))
        self._proposed = self._bounds.levelled(coarse.proposal().displacement), self._fine_bounds.levelled(fine.proposal().displacement)

    def _stylizers(self, recipe: Recipe) -> tuple[Stylizer, Stylizer] | None:
        """The stylizers of a recipe for the part and for its twin; the twin's draws what the part's drew, finer.

        None for a style that is known at the vertices only: no drawing says what it is between them.
        """
        if recipe.stylizer:
            plugged = made(self.part.surface, self._bounds, recipe)
            return (plugged, made(self.cut.mesh, self._fine_bounds, recipe)) if isinstance(plugged, ProceduralStylizer) else None
        if recipe.guidance == "clip" or recipe.field == "network":
            return None
        reading = reading_of(recipe)
        coarse = drawing_of(self.part, self._bounds, recipe, reading, self.objects, self.go_on)
        canvases = [FineCanvas(self.cut.mesh, self.cut.interpolation, canvas) for canvas in coarse.canvases]
        shares = self._spread(coarse.shares.T).T.astype(np.float64)
        fine = drawn(recipe, reading, canvases, shares, self._fine_bounds, self.go_on)
        return ProceduralStylizer(self.part.surface, coarse.target), ProceduralStylizer(self.cut.mesh, fine)

    def _increments(self, coarse: Stylizer, fine: Stylizer) -> tuple[Field, Field]:
        """Increments of the levelled proposals of part and twin in one iteration [mm], limited to the engine's step."""
        limit, before = np.float32(STEP_LIMIT * self.part.surface.size), self._proposed
        self._proposed = (
            self._bounds.levelled(coarse.step().displacement),
            self._fine_bounds.levelled(fine.step().displacement),
        )
        ours, theirs = (np.clip(now - then, -limit, limit) for now, then in zip(self._proposed, before, strict=True))
        return ours, theirs

    def _spread(self, values: NDArray[np.floating]) -> Field:
        """Values of the part at the twin's vertices."""
        return np.asarray(self.cut.interpolation @ values.astype(np.float32), np.float32)


def notes_on(part: Workpiece, recipe: Recipe, displacement: Field, found: Refined | None) -> tuple[str, ...]:
    """What a user should know of what is delivered: of how it was refined, and of its walls.

    Args:
        part: The part.
        recipe: The recipe in force.
        displacement: The last checkpoint's [mm], shape [vertex_count].
        found: The delivered surface, None for that of the checkpoint.
    """
    if found is None:
        return minimum_wall.warnings(part.surface, part.thickness, displacement, recipe.minimum_wall)
    walls = (found.cut.interpolation @ part.thickness).astype(np.float32)
    return (*found.notes, *minimum_wall.warnings(found.original, walls, found.displacement, recipe.minimum_wall))


STRESSES = ("stress", "envelope", "probability", "tilted_stress")
FIELDS = (*STRESSES, "contact")
"""Of a simulation, besides the displacement, over the surface."""


def _of_the_loop(simulation: Simulation, displacement: Field, cut: Subdivided) -> Simulation:
    """A test on a finer surface as one on the loop's vertices, of a relief of the loop [mm].

    At a vertex stands the largest stress of those it is nearest to: a peak between vertices of the loop is to be lowered, too.
    """
    count, nearest = len(displacement), cut.nearest
    fields: dict[str, Any] = {"contact": simulation.contact[:count]}
    for name in STRESSES:
        fields[name] = np.zeros(count, np.float32)
        np.maximum.at(fields[name], nearest, getattr(simulation, name))
    return replace(simulation, displacement=displacement, **fields)


def _spread_out(simulation: Simulation, cut: Subdivided) -> Simulation:
    """A test as one on a finer surface."""
    spread = {name: cut.interpolation @ getattr(simulation, name).astype(np.float32) for name in ("displacement", *FIELDS)}
    return replace(simulation, **{**spread, "contact": spread["contact"] > 0.5})

