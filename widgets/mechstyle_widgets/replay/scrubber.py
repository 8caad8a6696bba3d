"""The slider over iterations. What it passes while it is dragged is drawn by the page itself; the kernel is asked when it rests."""

from __future__ import annotations

from typing import Any, Protocol

import traitlets
from ipywidgets import widget_serialization

from mechstyle.runs.report.markup import bundle
from mechstyle_widgets.jupyter.page_widget import PageWidget
from mechstyle_widgets.replay.cache import FOLLOWED, Cache, Packer, served
from mechstyle_widgets.replay.replay import own
from mechstyle_widgets.state.studio_state import StudioState

REST = 400
"""A key that was pressed has come to rest after so long [ms]; a mouse when it lets go."""


class View(Protocol):
    """A view of a run in pythreejs whose buffers the page may fill."""

    @property
    def page(self) -> dict[str, Any]:
        """What the page needs to fill them: ids of models, layer and iteration drawn; empty while it is to leave them alone."""

    def observe(self, handler: Any, names: Any) -> None:
        """As of a widget."""

    def unobserve(self, handler: Any, names: Any) -> None:
        """As of a widget."""


class Scrubber(PageWidget):
    """A slider from 0 to the newest iteration of a state.

    Attributes:
        value: Iteration it stands at; while it is dragged the page does not tell.
        max: Where it ends.
        rest: How long after a key the kernel is asked [ms].
    """

    _esm, _css = bundle(own("scrubber.js"), ("replay_data",)), own("scrubber.css")
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
        self._view: View | None = None
        self._packer: Packer | None = None
        super().__init__()
        self.on_msg(self._hear)
        state.observe(self._follow, FOLLOWED)
        self._packer = Packer(state, self._take)
        self._follow()

    def serve(self, view: View | None) -> None:
        """Draw in a view while it is dragged; None for none."""
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
