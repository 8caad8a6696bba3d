"""The story of a run on one line: what was simulated and why, how near the limit it came, and which lane branched where."""

from __future__ import annotations

from typing import Any

import ipywidgets
import traitlets

from mechstyle_widgets.jupyter.cell_output import OncePerCell
from mechstyle_widgets.jupyter.closing import close_family
from mechstyle_widgets.jupyter.frame import Framed, unseen
from mechstyle_widgets.jupyter.looks import lean, sharing, show
from mechstyle_widgets.jupyter.throttle import Paced
from mechstyle_widgets.replay.scrubber import Scrubber
from mechstyle_widgets.state.schedule_forecast import plan_of
from mechstyle_widgets.state.studio_state import Linked, StudioState
from mechstyle_widgets.timeline import figure as timeline_figure
from mechstyle_widgets.timeline.curves import Curves
from mechstyle_widgets.timeline.figure import CURVES, TEMPLATES


class Timeline(Linked, Framed, OncePerCell, ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """Iterations from left to right: lanes with their simulations on top, stress against its limit, and one curve to choose.

    A click, or the arrow keys on the slider, shows another iteration; a click on another lane shows that lane. Before there is
    an iteration, it shows where the schedule that is asked for will simulate.
    `iteration` and `lane` are those of the state, both ways.

    Attributes:
        scrubber: The slider, which may draw in a view what it passes.
        curve: What the lowest row shows, one of `CURVES`.
        theme: `light` or `dark`.
    """

    curve = traitlets.Enum(tuple(CURVES), "")
    theme = traitlets.Enum(tuple(TEMPLATES), "light")

    @sharing()
    def __init__(self, state: StudioState, *, theme: str = "light", width: int = 900) -> None:
        """Tell the story of a state's run.

        Args:
            state: What is shown.
            theme: `light` or `dark`.
            width: Width of the timeline [pixels].
        """
        self._state, self.theme = state, theme
        self._width = width
        self._curves = Curves(self._clicked)
        self._draw_curves()
        self.scrubber = Scrubber(state)
        options = [(label, name) for name, label in CURVES.items()]
        choice = unseen(lean(
            ipywidgets.Dropdown,
            options=options, value="", description="curve", tooltip="What is drawn besides the stress", layout={"width": "160px"},
        ))  # fmt: skip
        self.scrubber.layout.flex = "1 1 300px"
        self._bar = lean(ipywidgets.HBox, [self.scrubber, choice], layout={"justify_content": "space-between", "flex_flow": "row wrap"})
        super().__init__([self._bar, self._curves])
        self.add_class("mechstyle-timeline")
        self._redraw, self._point = Paced(self._draw, state.alert), Paced(self._move_line, state.alert)
        self.link(state)
        traitlets.link((self, "curve"), (choice, "value"))
        state.observe(self._grown, ("histories", "branches", "lane"))
        state.observe(self._replanned, "settings")
        self.observe(lambda _: self._redraw(), ("curve", "theme"))
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
            self._state.unobserve(self._grown, ("histories", "branches", "lane"))
            self._state.unobserve(self._replanned, "settings")
        close_family(self)
        super().close()

    # what is drawn

    def _grown(self, _change: object) -> None:
        self._redraw()

    def _replanned(self, _change: object) -> None:
        if not self._begun:
            self._redraw()

    @property
    def _begun(self) -> bool:
        return any(self._state.histories.values())

    def _draw(self) -> None:
        self._draw_curves()
        self._move_line()

    def _draw_curves(self) -> None:
        """Draw what the state holds."""
        state, lane = self._state, self._state.lane
        if self._begun:
            traces, layout = timeline_figure.contents(state.histories, state.branches, lane, self.curve, self.theme)
        else:
            name = "Freestyle" if state.settings.get("control") == "none" else "MechStyle"
            traces, layout = timeline_figure.before(plan_of(state.settings), name, self.curve, self.theme, self._width)
        self._curves.show(*timeline_figure.filled(traces, {**layout, "width": self._width}))

    def _move_line(self) -> None:
        self._set_slider()
        self._curves.head = self.iteration

    def _set_slider(self) -> None:
        """Show the iteration on the slider; its end goes first, in a message of its own: browsers send a value beyond it back cut off."""
        self.scrubber.unobserve(self._slid, "value")  # a shorter lane cuts the value off as well
        self.scrubber.max = max(self._state.iterations_done, self.iteration, 1)
        self.scrubber.value = self.iteration
        show(self._bar, self._begun)  # there is nowhere to go yet
        self.scrubber.observe(self._slid, "value")

    # what the user does

    def _slid(self, change: dict[str, Any]) -> None:
        self.iteration = change["new"]
        if self.iteration != change["new"]:  # a lane of one iteration leaves the slider room that the lane has not
            self._point()

    def _clicked(self, trace: int, point: int) -> None:
        """Show the lane and the iteration of a point."""
        marks = self._curves.data[trace]
        if "customdata" in marks:
            [self._state.lane] = marks["customdata"][point]
            self.iteration = int(marks["x"][point])
