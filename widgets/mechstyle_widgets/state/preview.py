"""Preview of a style on a part before it is run: drawn off the kernel's own thread, the latest wish counts, nothing waits for it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from mechstyle.records import Recipe
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.regions import Region
from mechstyle.runs.stylizers import FinishedStyle, finished_style
from mechstyle.simulation.part import Shape, standardised_before
from mechstyle_widgets.jupyter.prepare import shape_aside
from mechstyle_widgets.jupyter.throttle import Timer, running_loop
from mechstyle_widgets.state.troubles import sentence

WAIT = 0.15
"""After the last change of a setting [s]."""
VERTICES = 6000
"""As many show a style and are drawn in half a second; a run of fewer is shown with its own."""
READY = 4
"""Parts that are kept ready."""
_ready: dict[tuple[str, int], Shape] = {}
"""The last ones, by what they are of and their vertices: a cell that is run again shows its style at once."""


@dataclass(frozen=True, eq=False)
class Preview:
    """A style on a part, not tested.

    Attributes:
        shape: The part it was drawn on.
        style: The finished style; None where only running it tells.
        seconds: How long the drawing took [s].
        protect: Regions that were protected when it was asked for.
    """

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


@dataclass(frozen=True, eq=False)
class _Wish:
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
        """Draw a style on a part, a moment after the last wish; whether it will be.

        Args:
            mesh: The part [mm].
            vertices: Of the run that is to come.
            recipe: Its recipe, as `draft` makes it.
        """
        if self._loop is None:
            return False
        with self._turn:
            self.cancel()
            self._wish = _Wish(mesh, min(vertices, VERTICES), recipe)
            self._timer = Timer(self._loop, WAIT, self._begin)
        return True

    def ready(self, mesh: SurfaceMesh, vertices: int) -> SurfaceMesh | None:
        """The surface on which a style will be drawn, if it is known; None without an event loop, where nothing will.

        Args:
            mesh: The part [mm].
            vertices: Of the run that is to come.
        """
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
                threading.Thread(target=self._work, args=(wish,), name="mechstyle-preview", daemon=True).start()

    def _work(self, wish: _Wish) -> None:
        """In the thread: draw, and bring the answer to the event loop."""
        answer: Callable[[], None] = lambda: None  # noqa: E731 — nothing to tell
        try:
            answer = partial(self._arrived, self._drawn(wish))
        except _Overtaken:
            pass
        except Exception as error:  # noqa: BLE001 — whatever it is, it is said, and the next wish is drawn
            answer = partial(self._failed, sentence(error))
        assert self._loop is not None, "only a loop begins the work"
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._end, wish, answer)

    def _end(self, wish: _Wish, answer: Callable[[], None]) -> None:
        self._busy, newest = False, self._wish
        try:
            if newest is not None and newest.mesh is wish.mesh:  # of an earlier setting, perhaps: the newest follows
                answer()
        finally:
            with self._turn:
                if self._wish is not wish and self._timer is None:
                    self._begin()

    def _drawn(self, wish: _Wish) -> Preview:
        shape = self._prepared(wish)
        began = time.monotonic()
        style = finished_style(shape, wish.recipe)
        return Preview(shape, style, time.monotonic() - began, wish.recipe.restraint.protect)

    def _prepared(self, wish: _Wish) -> Shape:
        key = (wish.mesh.digest, wish.vertices)
        shape = _ready.pop(key, None) or shape_aside(wish.mesh, wish.vertices, lambda: self._go_on(wish))
        _ready[key] = shape
        for old in list(_ready)[:-READY]:
            _ready.pop(old, None)
        return shape

    def _go_on(self, wish: _Wish) -> None:
        newest = self._wish
        if newest is None or newest.mesh is not wish.mesh:
            raise _Overtaken
