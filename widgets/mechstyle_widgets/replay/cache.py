"""Every iteration of a lane for a page to draw by itself, made off the kernel's own thread and brought up to date as the lane grows."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial

import ipywidgets
import traitlets

from mechstyle.errors import MechStyleError
from mechstyle.runs.report.replay_data import ReplayData, replay_data
from mechstyle.runs.run import Run
from mechstyle_widgets.jupyter.language import said
from mechstyle_widgets.jupyter.throttle import running_loop
from mechstyle_widgets.state.studio_state import StudioState

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
        threading.Thread(target=self._work, args=(run, wanted), name="mechstyle-packer", daemon=True).start()

    def _work(self, run: Run, wanted: tuple[str, ...]) -> None:
        """In the thread: pack, and bring it to the event loop."""
        data = None
        try:
            data = replay_data(run)
        except MechStyleError:  # a damaged store is reported where it is read to be shown
            pass
        finally:
            assert self._loop is not None, "only a loop begins the work"
            if not self._loop.is_closed():
                self._loop.call_soon_threadsafe(partial(self._end, data, wanted))

    def _end(self, data: ReplayData | None, wanted: tuple[str, ...]) -> None:
        self._busy, self._digests = False, wanted
        if data is not None and not self._closed:
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
