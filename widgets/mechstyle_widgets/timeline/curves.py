"""A plotly figure in a page, without plotly's scripts in its state.

A `FigureWidget` brings them with it, 5 MB each: a page that is loaded anew asks for the state of every widget and waits for it, and
what comes later than a few seconds it does not find. Here a page asks for the scripts once, when it has something to draw.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files
from typing import Any

import traitlets
from plotly.offline import get_plotlyjs

from mechstyle_widgets.jupyter.page_widget import PageWidget


class Curves(PageWidget):
    """A figure that is drawn by plotly in the page.

    Attributes:
        data: The traces, as plotly's scripts read them.
        frame: The layout that goes with them, which is sent when it changes; its first shape is an upright line.
        head: Where that line stands, in units of the axis across.
    """

    _esm = files("mechstyle_widgets.timeline").joinpath("static", "curves.js").read_text(encoding="utf-8")
    data: Any = traitlets.List().tag(sync=True)
    frame = traitlets.Dict().tag(sync=True)
    head = traitlets.Float(0.0).tag(sync=True)

    def __init__(self, clicked: Callable[[int, int], None]) -> None:
        """Draw nothing yet; `clicked` is called with the numbers of the trace and of the point in it."""
        super().__init__()
        self._told = clicked
        self.on_msg(self._hear)

    def show(self, data: list[dict[str, Any]], frame: dict[str, Any]) -> None:
        """Draw these traces in this layout."""
        with self.hold_sync():
            self.data, self.frame = data, frame

    def _hear(self, _widget: Any, message: Any, _buffers: Any) -> None:
        kind = message.get("kind") if isinstance(message, dict) else None
        if kind == "plotly":
            self.send({"kind": "plotly"}, [get_plotlyjs().encode()])
        elif kind == "click":
            self._told(int(message["trace"]), int(message["point"]))
