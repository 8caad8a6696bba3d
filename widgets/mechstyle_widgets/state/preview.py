"""Preview of a style on a part before it is run: drawn off the kernel's own thread, the latest wish counts, nothing waits for it."""

from __future__ import annotations

import math
import re
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from mechstyle.records import Recipe
from mechstyle.records.mesh import VERTICES as POSSIBLE
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.regions import Region
from mechstyle.records.simulation import LIKE_ASKED
from mechstyle.runs.stylizers import FinishedStyle, finished_style
from mechstyle.simulation.part import Shape, standardised_before
from mechstyle_widgets.jupyter.prepare import shape_in_worker
from mechstyle_widgets.jupyter.throttle import Timer, in_a_thread, running_loop
from mechstyle_widgets.state.troubles import sentence

WAIT = 0.15
"""After the last change of a setting [s]."""
VERTICES = 6000
"""As many show a style and are drawn in half a second; a run of fewer is shown with its own."""
READY = 4
"""Parts that are kept ready."""
_ready: dict[tuple[str, int], Shape] = {}
"""The last ones, by what they are of and their vertices: a cell that is run again shows its style at once."""


ENLARGED = re.compile(r"too coarse for (?P<what>.+?) of .* enlarged (?P<times>[\d.]+)x")
"""What the note of a drawing says where its mesh carries no pattern so fine."""


class Enlarged(NamedTuple):
    """What of a pattern is drawn so many times larger than asked, and the vertices that would carry it."""

    what: str
    times: float
    vertices: int


@dataclass(frozen=True, eq=False)
class Preview:
    """A style on a part, not tested; no style where only running it tells. `seconds` is the time of drawing [s]."""

    shape: Shape
    style: FinishedStyle | None
    seconds: float
    protect: tuple[Region, ...] = ()

    @property
    def surface(self) -> SurfaceMesh:
        """The styled, coloured surface; the original part where only a run knows."""
        if self.style is None:
            return self.shape.surface
        return self.shape.surface.displaced(self.style.relief).coloured(self.style.colour)

    def enlarged(self, vertices: int) -> Enlarged | None:
        """How much larger than asked the pattern of a run of so many vertices is drawn, the worst of it; None where it is as asked."""
        drawn = len(self.shape.surface.vertices)
        coarser = max(1.0, drawn / vertices) if vertices <= drawn else drawn / vertices
        found = [ENLARGED.search(note) for note in (() if self.style is None else self.style.notes)]
        times = [(float(one["times"]), one["what"]) for one in found if one]
        if not times:
            return None
        most, what = max(times)
        largest = most * math.sqrt(coarser)
        would = min(math.ceil(drawn * most**2 / 1000.0) * 1000, POSSIBLE[1])
        return Enlarged(what, largest, would) if largest > LIKE_ASKED else None


class _Wish(NamedTuple):
    mesh: SurfaceMesh
    vertices: int
    recipe: Recipe


class _Overtaken(Exception):
    """Another part was asked for, or nobody waits any longer."""


class Previewer:
    """Draws what is asked for last, from whichever thread."""

    def __init__(self, arrived: Callable[[Preview], None], failed: Callable[[str], None]) -> None:
        """Call `arrived` with previews, `failed` with a sentence, both on the event loop; without one nothing is drawn."""
        self._arrived, self._failed = arrived, failed
        self._loop = running_loop()
        self._turn = threading.RLock()  # of who changes the next three
        self._wish: _Wish | None = None
        self._timer: Timer | None = None
        self._busy = False

    def ask(self, mesh: SurfaceMesh, vertices: int, recipe: Recipe) -> bool:
        """Draw a style on a part [mm] for a run of so many vertices, a moment after the last wish; whether it will be."""
        if self._loop is None:
            return False
        with self._turn:
            self.cancel()
            self._wish = _Wish(mesh, min(vertices, VERTICES), recipe)
            self._timer = Timer(self._loop, WAIT, self._begin)
        return True

    def ready(self, mesh: SurfaceMesh, vertices: int) -> SurfaceMesh | None:
        """The surface on which a style will be drawn, if it is known; None without an event loop, where nothing will."""
        if self._loop is None:
            return None
        shape = _ready.get((mesh.digest, min(vertices, VERTICES)))
        return standardised_before(mesh, min(vertices, VERTICES)) if shape is None else shape.surface

    @property
    def awaited(self) -> bool:
        """Whether a preview was asked for that is still wanted."""
        return self._wish is not None

    def cancel(self) -> None:
        """Want nothing any more: what is being drawn is not shown, and what prepares a part for it ends."""
        with self._turn:
            self._wish = None
            if self._timer is not None:
                self._timer.cancel()
                self._timer = None

    def _begin(self) -> None:
        with self._turn:
            self._timer, wish = None, self._wish
            if wish is not None and not self._busy:
                self._busy = True
                end = partial(self._end, wish)
                in_a_thread(self._loop, partial(self._drawn, wish), end, end)

    def _wanted(self, wish: _Wish) -> bool:
        """Whether its part is still asked about, in whatever style: the newest follows."""
        newest = self._wish
        return newest is not None and newest.mesh is wish.mesh

    def _end(self, wish: _Wish, answer: Preview | Exception) -> None:
        self._busy = False
        try:
            if self._wanted(wish) and not isinstance(answer, _Overtaken):
                self._failed(sentence(answer)) if isinstance(answer, Exception) else self._arrived(answer)
        finally:
            with self._turn:
                if self._wish is not wish and self._timer is None:
                    self._begin()

    def _drawn(self, wish: _Wish) -> Preview:
        def go_on() -> None:
            if not self._wanted(wish):
                raise _Overtaken

        key = (wish.mesh.digest, wish.vertices)
        shape = _ready.pop(key, None) or shape_in_worker(wish.mesh, wish.vertices, go_on)
        _ready[key] = shape
        for old in list(_ready)[:-READY]:
            _ready.pop(old, None)
        began = time.monotonic()
        style = finished_style(shape, wish.recipe)
        return Preview(shape, style, time.monotonic() - began, wish.recipe.restraint.protect)
