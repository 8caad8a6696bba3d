"""The lanes of a run: which there are, what each changed, a new one from any iteration, and two iterations compared."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import ipywidgets
import numpy as np
import traitlets

from mechstyle.errors import MechStyleError
from mechstyle.loop.history import Branch, Row
from mechstyle.records import Checkpoint
from mechstyle.records.load_cases import LoadCase
from mechstyle.records.material import Material
from mechstyle_widgets.settings.section import NARROW_LABEL, WIDE, Section, Words, table
from mechstyle_widgets.state.controller import Controller
from mechstyle_widgets.state.outcomes import LOOKS


class Branches(Section):
    """Choose a lane, branch from the iteration on show, compare two iterations.

    Attributes:
        lane: Lane on show, the state's.
        pinned: Lane and iteration to compare with, as (lane, iteration); None for none.
    """

    lane = traitlets.Unicode("main")
    pinned: Any = traitlets.Tuple(None, allow_none=True)

    def __init__(self, controller: Controller) -> None:
        """Show the lanes of what a controller's state shows."""
        self.controller, self.state = controller, controller.state
        self._choice = ipywidgets.Select(options=[], rows=4, tooltip="Lanes; choose one to show it", layout=WIDE)
        self._changes = Words()
        self._name = ipywidgets.Text(description="new lane", placeholder="named by number", style=NARROW_LABEL, layout=WIDE)
        self._branch = ipywidgets.Button(
            icon="code-fork", layout=WIDE, tooltip="A new lane from this iteration, with the settings at the left"
        )
        self._pin = ipywidgets.Button(icon="thumb-tack", layout=WIDE, tooltip="Remember this iteration and compare others with it")
        self._comparison = Words()
        super().__init__([self._choice, self._changes, self._name, self._branch, self._pin, self._comparison])
        traitlets.link((self.state, "lane"), (self, "lane"))
        self._choice.observe(self._choose, "value")
        self._branch.on_click(lambda _: self.branch())
        self._pin.on_click(lambda _: self.pin())
        self.state.observe(self._list, ("branches", "lane"))
        self.state.observe(self._redraw, ("checkpoint", "status", "settings"))
        self.state.observe(self._forget, "run")
        self.observe(self._redraw, "pinned")
        self._list()

    def branch(self) -> None:
        """A new lane from the iteration on show, with the settings of the left column.

        All of them are asked for: told the changed ones only, a branch adds what usually goes with them.
        """
        try:
            changed, wanted = self.controller.differs(), self.controller.wanted().recipe
        except MechStyleError as error:  # CLIP's weights may be missing, too
            self.state.message = str(error)
            return
        if not changed:
            self.complain("change a setting at the left first: this lane would be the same again")
            return
        self.complain("")
        self.controller.branch(self.state.iteration, self._name.value.strip(), **wanted.settings)
        self._name.value = ""

    def pin(self) -> None:
        """Remember the iteration on show, so that what is shown afterwards is compared with it; once more, forget it."""
        here = (self.state.lane, self.state.iteration)
        self.pinned = None if self.pinned == here else here

    def comparison(self) -> list[tuple[str, str, str]]:
        """Differences between the pinned and the current iteration: name, there, here; settings first."""
        if self.pinned is None or self.state.run is None:
            return []
        lane, iteration = self.pinned
        sides = [(self.state.row(iteration, lane), self.state.checkpoint_at(iteration, lane)), (self.state.row(), self.state.checkpoint)]
        if any(row is None or checkpoint is None for row, checkpoint in sides):
            return []
        store = self.state.run.store
        theirs, ours = (store.recipe(store.lane(name).recipe) for name in (lane, self.state.lane))
        settings = [(name.replace("_", " "), said(a), said(b)) for name, a, b in theirs.differences(ours, by_figure=True)]
        there, here = (results(row, checkpoint) for row, checkpoint in sides if row is not None and checkpoint is not None)
        return settings + [(name, there[name], here[name]) for name in here]

    def _list(self, _change: object = None) -> None:
        self._choice.unobserve(self._choose, "value")
        self._choice.options = [(_line(branch, self.state.histories[branch.lane]), branch.lane) for branch in self.state.branches]
        names = [branch.lane for branch in self.state.branches]
        self._choice.value = self.lane if self.lane in names else None
        self._choice.rows = min(max(len(names), 2), 6)
        self._choice.observe(self._choose, "value")
        shown = next((branch for branch in self.state.branches if branch.lane == self.lane), None)
        rows = [(name.replace("_", " "), said(before), said(after)) for name, before, after in shown.changes] if shown else []
        self._changes.say(table(("changed", shown.parent if shown else "", self.lane), rows) if rows else "")
        self._redraw()

    def _forget(self, change: dict[str, Any]) -> None:
        """Unpin: a pinned iteration belongs to the run it was pinned in."""
        if change["old"] is not None and change["new"] is not None and change["old"].store.root != change["new"].store.root:
            self.pinned = None

    def _choose(self, change: dict[str, Any]) -> None:
        if change["new"]:
            self.lane = change["new"]

    def _redraw(self, _change: object = None) -> None:
        state = self.state
        nothing = state.checkpoint is None
        self._branch.description = f"branch from iteration {state.iteration}"
        self._branch.disabled = nothing or state.status in ("preparing", "running", "paused")
        again = self.pinned == (state.lane, state.iteration)
        self._pin.description = "compare no longer" if again else f"compare others with iteration {state.iteration}"
        self._pin.disabled = nothing
        rows = self.comparison()
        if rows and self.pinned is not None:
            head = ("", f"{self.pinned[0]} · {self.pinned[1]}", f"{state.lane} · {state.iteration}")
            self._comparison.say(table(head, rows))
        else:
            self._comparison.say("")
        self.note("nothing to branch from yet: run something first" if nothing else "")


def _line(branch: Branch, rows: Sequence[Row]) -> str:
    """A lane in one line, with the mark of its newest verdict."""
    word = next((row.word for row in reversed(rows) if row.word), "")
    where = f"{branch.iteration} of {branch.iterations}" if branch.iteration < branch.iterations else f"{branch.iterations} iterations"
    origin = f", from {branch.parent} at {branch.forked_at}" if branch.forked_at is not None else ""
    return f"{LOOKS[word].mark if word else '·'} {branch.lane}: {where}{origin}"


def results(row: Row, checkpoint: Checkpoint) -> dict[str, str]:
    """Results of an iteration, as table cells."""
    return {
        "iteration": str(row.iteration),
        "simulated because": row.reason or "not simulated",
        "verdict": row.word or "–",
        "peak stress": "–" if row.peak is None else f"{row.peak:.1f} MPa",
        "limit": "–" if row.limit is None else f"{row.limit:.1f} MPa",
        "style loss": f"{row.style_loss:.3g}",
        "largest relief": f"{float(np.abs(checkpoint.displacement).max()):.2f} mm",
        "held back by more than half": f"{row.share:.1%}",
    }


def said(value: Any) -> str:
    """A setting's value as a table shows it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, tuple):  # of regions or load cases
        return "; ".join(one.name if isinstance(one, LoadCase) else one.words for one in value) or "–"
    return value.name if isinstance(value, Material) else str(value) or "–"
