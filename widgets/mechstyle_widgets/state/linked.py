"""Mixin of widgets that follow a run: lane and iteration are linked with the state, both ways."""

from __future__ import annotations

from typing import Any

import traitlets

from mechstyle_widgets.state.studio_state import StudioState


class Linked(traitlets.HasTraits):
    """A view of a state; mixed into a widget.

    Attributes:
        lane: Name of the lane on show.
        iteration: Iteration on show; held within those the lane has.
    """

    lane = traitlets.Unicode("main")
    iteration = traitlets.Int(0)
    _links: tuple[Any, ...] = ()

    def link(self, state: StudioState, *names: str) -> None:
        """Link lane, iteration and the given traits to a state, both ways, until `unlink`."""
        self._state = state
        self._links = tuple(traitlets.link((state, name), (self, name)) for name in ("lane", "iteration", *names))

    def unlink(self) -> None:
        """Undo `link`."""
        for link in self._links:
            link.unlink()
        self._links = ()

    @traitlets.validate("iteration")
    def _within_lane(self, proposal: dict[str, Any]) -> int:
        return max(0, min(proposal["value"], self._state.iterations_done))
