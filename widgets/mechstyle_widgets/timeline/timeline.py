"""The story of a run on one line: what was simulated and why, what stayed bent, and which lane branched where."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ipywidgets
import traitlets

from mechstyle.loop.history import Row
from mechstyle.simulation.estimate import plan_of
from mechstyle_widgets.jupyter.cell_output import OncePerCell
from mechstyle_widgets.jupyter.frame import Framed, unseen
from mechstyle_widgets.jupyter.looks import close_family, lean, sharing, show, unheard
from mechstyle_widgets.jupyter.page_widget import PageWidget, static
from mechstyle_widgets.jupyter.throttle import Throttled
from mechstyle_widgets.state.on_show import on_show
from mechstyle_widgets.state.studio_state import Linked, StudioState
from mechstyle_widgets.timeline import figure as timeline_figure
from mechstyle_widgets.timeline.figure import TEMPLATES


class Curves(PageWidget):
    """A figure that is drawn by plotly in the page from traces and layout, as its scripts read them.

    Attributes:
        head: Where the first shape of the layout, an upright line, stands; mouse and keys move it, to whole numbers.
        last: The furthest to which they do.
        story: HTML of what is said under the figure while the mouse points at none of its marks.
    """

    _esm = static("timeline", "curves.js")
    data: Any = traitlets.List().tag(sync=True)
    frame = traitlets.Dict().tag(sync=True)
    head = traitlets.Float(0.0).tag(sync=True)
    last = traitlets.Int(0).tag(sync=True)
    story = traitlets.Unicode("").tag(sync=True)

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
            self.send({"kind": "plotly"}, [timeline_figure.plotly_file("plotly.min.js").encode()])
        elif kind == "click":
            self._told(int(message["trace"]), int(message["point"]))


class Timeline(Linked, Framed, OncePerCell, ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """Iterations from left to right: lanes with their simulations, and what stayed bent beside what may.

    The mouse drags the line, and the arrow keys move it, to another iteration; a click on another lane shows that lane. Before there is
    an iteration, it shows where the schedule that is asked for will simulate.
    `iteration` and `lane` are those of the state, both ways.

    Attributes:
        theme: `light` or `dark`.
    """

    theme = traitlets.Enum(tuple(TEMPLATES), "light")

    @sharing()
    def __init__(self, state: StudioState, *, theme: str = "light", width: int = 900) -> None:
        """Tell the story of a state's run, so wide [pixels]."""
        self._state, self.theme = state, theme
        self._width = width
        self._curves = Curves(self._clicked)
        self._draw_curves()
        look = {"show_repeat": False, "layout": {"width": "auto"}}
        self._play = unseen(lean(ipywidgets.Play, description="iteration", tooltip="Play, and stop", max=1, **look))
        self._links_in_page = [
            ipywidgets.jsdlink((self._curves, "last"), (self._play, "max")),
            ipywidgets.jslink((self._play, "value"), (self._curves, "head")),
        ]  # fmt: skip
        self._curves.observe(self._slid, "head")
        super().__init__([self._curves, self._play])
        self.add_class("mechstyle-timeline")
        self._redraw, self._point = Throttled(self._draw, state.alert), Throttled(self._move_line, state.alert)
        self.link(state)
        state.observe(self._heard, ("histories", "branches", "lane", "settings"))
        state.observe(self._whose, ("another", "status"))
        self.observe(lambda _: self._redraw(), "theme")
        self.observe(lambda _: self._point(), "iteration")
        self._move_line()

    def __repr__(self) -> str:
        """Lane and iteration."""
        return f"Timeline(lane={self.lane!r}, iteration={self.iteration})"

    def resize(self, width: int) -> None:
        """Take another width [pixels]."""
        if width != self._width:
            self._width = width
            self._redraw()

    def close(self) -> None:
        """Close it and every widget it is made of; the state is not followed any more."""
        self._redraw.cancel()
        self._point.cancel()
        if self._links:
            self.unlink()
            self._state.unobserve(self._heard, ("histories", "branches", "lane", "settings"))
            self._state.unobserve(self._whose, ("another", "status"))
        close_family(self, *self._links_in_page)
        super().close()

    # what is drawn

    def _heard(self, change: dict[str, Any]) -> None:
        if change["name"] != "settings" or not self._begun:  # before a run its plan is on show
            self._redraw()

    def _whose(self, _change: object) -> None:
        self._point()

    @property
    def _begun(self) -> bool:
        return any(self._state.histories.values())

    def _draw(self) -> None:
        self._draw_curves()
        self._move_line()

    def _draw_curves(self) -> None:
        state, lane = self._state, self._state.lane
        if self._begun:
            traces, layout = timeline_figure.contents(state.histories, state.branches, lane, self.theme)
        else:
            name = "Freestyle" if state.settings.get("control") == "none" else "MechStyle"
            traces, layout = timeline_figure.before(plan_of(state.settings), name, self.theme, self._width)
        self._curves.show(*timeline_figure.filled(traces, {**layout, "width": self._width}))

    def _move_line(self) -> None:
        """Show the iteration, and what is said of it; the end goes first, in a message of its own."""
        row = self._state.row(self.iteration)
        self._curves.last = self._state.iterations_done
        with unheard(self._curves, self._slid, "head"):
            self._curves.head = self.iteration
        self._curves.story = "" if row is None else self._story(row)
        show(self._play, self._begun)  # there is nowhere to go yet

    def _story(self, row: Row) -> str:
        """What is said of an iteration under the curves, and whose it is where another run is asked for."""
        shown = on_show(self._state)
        return timeline_figure.story(self._state.called(self.lane), row, self._state.headed("" if shown is None else shown.title))

    # what the user does

    def _slid(self, change: dict[str, Any]) -> None:
        self.iteration = round(change["new"])
        if self.iteration != change["new"]:  # it is not there
            self._point()

    def _clicked(self, trace: int, point: int) -> None:
        marks = self._curves.data[trace]
        if "customdata" in marks:
            [lane] = marks["customdata"][point]
            self._state.go_to(lane, int(marks["x"][point]))
