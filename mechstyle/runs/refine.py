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

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import BadInput
from mechstyle.geometry.print_quality import untangled
from mechstyle.geometry.subdivision import Subdivided, refined_to
from mechstyle.loop import minimum_wall
from mechstyle.loop.store import Store
from mechstyle.records import Checkpoint, Recipe, Simulation, Verdict
from mechstyle.records.mesh import Field, SurfaceMesh, frozen_array
from mechstyle.runs.twin import Twin
from mechstyle.simulation.part import Workpiece
from mechstyle.simulation.simulator import DropSimulator

VERSION = 3
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
        test = carrier.on(self.cut)
        return replace(test.simulate(relief, thorough=True), meshing=meshing)

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

    def _relief(self, twin: Twin) -> Field:
        """The twin's [mm], shape [fine_count], lowered where it would pass through itself."""
        return untangled(self.cut.mesh, twin.displacement, self._go_on)

    def _go_on(self) -> None:
        self.simulator.progress(0.0)

    @cached_property
    def _twin(self) -> Twin:
        return Twin(self.part, self.cut, self.store.objects, self._go_on)

    def _led_to(self, state: Checkpoint) -> Twin:
        """The twin led to a state from wherever it stands, which must be in the past of the state or one of its iteration."""
        past = [state]
        while past[-1].parent and (self._twin.stands is None or past[-1].iteration > self._twin.stands.iteration):
            past.append(self.store.checkpoint(past[-1].parent))
        for before, after in pairwise([*([] if self._twin.stands is None else [self._twin.stands]), *past[::-1]]):
            self._go_on()  # a run has hundreds
            self._twin.follow(before, after, self.store.recipe(after.recipe))
        return self._twin


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


STRESSES = ("landing_stress", "load_stress")
"""Fields of a simulation with a row for each test, shape [test_count, vertex_count]."""


def _of_the_loop(simulation: Simulation, displacement: Field, cut: Subdivided) -> Simulation:
    """A test on a finer surface as one on the loop's vertices, of a relief of the loop [mm].

    At a vertex stands the largest stress of those it is nearest to: a peak between vertices of the loop is to be lowered, too.
    """
    count, nearest = len(displacement), cut.nearest
    fields: dict[str, Any] = {"contact": simulation.contact[:count]}
    for name in STRESSES:
        values = getattr(simulation, name)
        fields[name] = np.zeros((len(values), count), np.float32)
        np.maximum.at(fields[name].T, nearest, values.T)
    return replace(simulation, displacement=displacement, **fields)


def _spread_out(simulation: Simulation, cut: Subdivided) -> Simulation:
    """A test as one on a finer surface."""
    names = ("displacement", "contact", *STRESSES)
    spread = {name: (cut.interpolation @ getattr(simulation, name).T.astype(np.float32)).T for name in names}
    return replace(simulation, **{**spread, "contact": spread["contact"] > 0.5})
