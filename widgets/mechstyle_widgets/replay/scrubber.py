"""The slider over iterations. What it passes while it is dragged is drawn by the page itself; the kernel is asked when it rests."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import ipywidgets
import traitlets
from ipywidgets import widget_serialization

from mechstyle.errors import MechStyleError
from mechstyle.runs.report.markup import bundle
from mechstyle.runs.report.replay_data import ReplayData, replay_data
from mechstyle_widgets.jupyter.language import said
from mechstyle_widgets.jupyter.page_widget import PageWidget, static
from mechstyle_widgets.jupyter.throttle import in_a_thread, running_loop
from mechstyle_widgets.state.studio_state import StudioState

REST = 400
"""A key that was pressed has come to rest after so long [ms]; a mouse when it lets go."""


GROWTH, LEAST = 1.5, 10
"""While a run goes on its lane is packed anew when it has grown by this factor and by so many iterations at least."""
FOLLOWED = ("histories", "lane", "run", "status")


class Cache(ipywidgets.Widget):  # type: ignore[misc]  # ipywidgets has no types
    """A packed lane in the page. It is never changed: servers drop changes of more than some megabytes, but let what is made pass.

    It is no anywidget: those give up, and take the whole Studio with them, if a page that is loaded anew has no time for them within
    two seconds.
    """

    _header = traitlets.Dict().tag(sync=True)
    _payload = traitlets.Bytes().tag(sync=True)

    def __init__(self, data: ReplayData, digests: dict[int, str]) -> None:
        """Hold a lane whose checkpoints have these digests, by iteration."""
        self.digests = digests
        frames = [{**frame, "words": said(frame["words"])} if "words" in frame else frame for frame in data.header["frames"]]
        super().__init__(_header={**data.header, "frames": frames}, _payload=data.payload)


class Packer:
    """Packs the lane a state shows whenever it rests, and now and then while it grows; without an event loop nothing is packed."""

    def __init__(self, state: StudioState, packed: Callable[[Cache], None]) -> None:
        """Follow a state, and hand over each cache on the event loop."""
        self._state, self._packed = state, packed
        self._loop = running_loop()
        self._busy, self._closed = False, False
        self._digests: tuple[str, ...] = ()
        state.observe(self._look, FOLLOWED)
        self._look()

    def close(self) -> None:
        """Stop following the state."""
        self._closed = True
        self._state.unobserve(self._look, FOLLOWED)

    def _look(self, _change: object = None) -> None:
        run, wanted = self._state.run, digests_of(self._state)
        if self._loop is None or self._busy or self._closed or run is None or wanted == self._digests or not wanted:
            return
        going_on = self._state.status in ("running", "preparing") and wanted[: len(self._digests)] == self._digests
        if going_on and len(wanted) < max(GROWTH * len(self._digests), LEAST):
            return
        self._busy = True
        in_a_thread(self._loop, partial(replay_data, run), partial(self._end, wanted), partial(self._end, wanted))

    def _end(self, wanted: tuple[str, ...], data: ReplayData | Exception) -> None:
        self._busy, self._digests = False, wanted
        if isinstance(data, Exception):
            if not isinstance(data, MechStyleError):  # a damaged store is reported where it is read to be shown
                raise data
        elif not self._closed:
            self._packed(Cache(data, {at: digest for at, digest in enumerate(wanted) if at in data.iterations}))
            self._look()


def digests_of(state: StudioState) -> tuple[str, ...]:
    """Digests of the checkpoints of the lane on show, one for each iteration."""
    return tuple(row.digest for row in state.history)


def served(cache: Cache | None, state: StudioState) -> list[int]:
    """Iterations of the lane on show that a cache holds as they are now; a correction makes one anew."""
    if cache is None:
        return []
    return [row.iteration for row in state.history if cache.digests.get(row.iteration) == row.digest]


class Scrubber(PageWidget):
    """A slider from 0 to the newest iteration of a state.

    Attributes:
        value: Iteration it stands at; while it is dragged the page does not tell.
        max: Where it ends.
        rest: How long after a key the kernel is asked [ms].
    """

    _esm, _css = bundle(static("replay", "scrubber.js"), ("replay_data",)), static("replay", "scrubber.css")
    value = traitlets.Int(0).tag(sync=True)
    max = traitlets.Int(1).tag(sync=True)
    rest = traitlets.Int(REST).tag(sync=True)
    _cache = traitlets.Instance(Cache, None, allow_none=True).tag(sync=True, **widget_serialization)
    _served = traitlets.List(traitlets.Int()).tag(sync=True)
    _live = traitlets.Bool(False).tag(sync=True)
    _page = traitlets.Dict().tag(sync=True)

    def __init__(self, state: StudioState) -> None:
        """Follow the lane a state shows."""
        self._state = state
        self._view: Any = None
        self._packer: Packer | None = None
        super().__init__()
        self.on_msg(self._hear)
        state.observe(self._follow, FOLLOWED)
        self._packer = Packer(state, self._take)
        self._follow()

    def serve(self, view: Any) -> None:
        """Draw in a view of a run while it is dragged, whose `page` says what the page may fill; None for none."""
        if self._view is not None:
            self._view.unobserve(self._look, ("layer", "drawings"))
        self._view = view
        if view is not None:
            view.observe(self._look, ("layer", "drawings"))
        self._look()

    def close(self) -> None:
        """Close it and what the page holds; the state is not followed any more."""
        if self._packer is not None:
            self._packer.close()
            self.serve(None)
            self._state.unobserve(self._follow, FOLLOWED)
            self._packer = None
            if self._cache is not None:
                self._cache.close()
        super().close()

    def _take(self, cache: Cache) -> None:
        old, self._cache = self._cache, cache
        self._follow()
        if old is not None:
            old.close()

    def _follow(self, _change: object = None) -> None:
        """Tell the page which of its iterations are still those of the lane, and whether a run goes on."""
        self._served = served(self._cache, self._state)
        self._live = self._state.status in ("running", "preparing")

    def _hear(self, _widget: Any, message: Any, _buffers: Any) -> None:
        """A key was pressed: show the lane above or below, if there is one."""
        lanes = [branch.lane for branch in self._state.branches]
        if isinstance(message, dict) and message.get("kind") == "lane" and self._state.lane in lanes:
            at = lanes.index(self._state.lane) + int(message["by"])
            self._state.lane = lanes[min(max(at, 0), len(lanes) - 1)]

    def _look(self, _change: object = None) -> None:
        """Tell the page what it may fill, and what the kernel has drawn."""
        self._page = {} if self._view is None else self._view.page
