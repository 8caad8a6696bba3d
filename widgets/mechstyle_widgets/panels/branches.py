"""The lanes of a run: which there are, what each changed, a new one from any iteration, and two iterations compared."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import Any

import ipywidgets
import numpy as np
import traitlets

from mechstyle.errors import MechStyleError
from mechstyle.loop.history import Branch, Row
from mechstyle.pictures.fields import stays_bent
from mechstyle.records import Checkpoint, Verdict, sentences
from mechstyle.records import Row as Judged
from mechstyle.records.load_cases import LoadCase
from mechstyle.records.material import Material
from mechstyle.runs.run import Run
from mechstyle_widgets.jupyter.frame import unseen
from mechstyle_widgets.jupyter.language import said as translated
from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show, unheard
from mechstyle_widgets.settings.control import MEASURES, STRATEGIES
from mechstyle_widgets.settings.section import WIDE, Section, Words, control, table
from mechstyle_widgets.state.controller import Controller
from mechstyle_widgets.state.on_show import share_kept
from mechstyle_widgets.state.outcomes import LOOKS
from mechstyle_widgets.state.studio_state import FREE
from mechstyle_widgets.viewer.badge import worst_vertex

SPOKEN = {**STRATEGIES, **MEASURES}
"""Values of settings that people read, by how recipes call them."""
ALIKE = 0.9
"""Share of the other's relief from which on a part looks like it."""
SAME = 0.02
"""Difference up to which two permanent sets are about the same [mm]."""


class Branches(Section):
    """Choose a lane, branch from the iteration on show, compare two iterations.

    Attributes:
        lane: Lane on show, the state's.
        pinned: Lane and iteration to compare with, as (lane, iteration), the state's; None for none.
        third: The same for a third pane.
    """

    lane = traitlets.Unicode("main")
    pinned: Any = traitlets.Tuple(None, allow_none=True)
    third: Any = traitlets.Tuple(None, allow_none=True)

    def __init__(self, controller: Controller) -> None:
        """Show the lanes of what a controller's state shows."""
        self.controller, self.state = controller, controller.state
        lanes = lean(ipywidgets.Select, options=[], rows=4, description="lanes", tooltip="Lanes; choose one to show it", layout=WIDE)
        self._choice = unseen(lanes)
        self._changes = lean(Words)
        self._name = control(ipywidgets.Text, "new lane", placeholder="named by number")
        self._branch = lean(
            ipywidgets.Button, icon="code-fork", layout=WIDE, tooltip="A new lane from this iteration, with the settings at the left"
        )
        self._pin = lean(ipywidgets.Button, icon="thumb-tack", layout=WIDE, tooltip="Remember this iteration and compare others with it")
        self._also = lean(ipywidgets.Button, icon="plus", layout=WIDE, tooltip="A third pane, which stays as it is")
        self._comparison = lean(Words)
        super().__init__([self._choice, self._changes, self._name, self._branch, self._pin, self._also, self._comparison])
        for name in ("lane", "pinned", "third"):
            traitlets.link((self.state, name), (self, name))
        self._choice.observe(self._choose, "value")
        self._branch.on_click(lambda _: self.branch())
        self._pin.on_click(lambda _: self.pin())
        self._also.on_click(lambda _: self.keep_beside())
        self.state.observe(self._list, ("branches", "lane"))
        self.state.observe(self._redraw, ("checkpoint", "status", "settings"))
        self.state.observe(self._unpin, "run")
        self.state.observe(self._change_places, "lane")
        self.state.observe(lambda _: self.complain(""), ("lane", "iteration", "settings"))
        self.observe(self._redraw, ("pinned", "third"))
        self._list()

    def branch(self) -> None:
        """A new lane from the iteration on show, with the settings of the left column.

        All of them are asked for: given the changed ones only, a branch adds what usually goes with them.
        """
        self.complain("")
        try:
            changed, wanted = self.controller.differs(), self.controller.wanted().recipe
        except MechStyleError as error:  # CLIP's weights may be missing, too
            self.complain(str(error))
            return
        if not changed:
            lane = self.state.called(self.lane)
            self.complain(word("Nothing differs from {}: change a setting first, or move the slider under What if.").format(lane))
            return
        if self.state.iteration >= wanted.schedule.iterations:
            self.complain(word("Iteration {} is the end: go to an earlier one, or ask for more iterations.").format(self.state.iteration))
            return
        if self.pinned is not None and self.third is None and self.pinned[0] != self.lane:
            self.third = (self.lane, self.state.iterations_done)  # what is branched from stays in sight
        self.controller.branch(self.state.iteration, self._name.value.strip(), self.complain, **wanted.settings)
        self._name.value = ""

    def pin(self) -> None:
        """Remember the iteration on show, so that what is shown afterwards is compared with it; once more, forget it."""
        here = (self.state.lane, self.state.iteration)
        self.pinned, self.third = (None if self.pinned == here else here), None

    def keep_beside(self) -> None:
        """Let the iteration on show stand in a third pane from now on; once more, not any more."""
        self.third = (self.state.lane, self.state.iteration) if self.third is None else None

    def comparison(self) -> list[tuple[str, ...]]:
        """Differences of the pinned, the third and the current iteration: name, there, here; results first."""
        sides = self.sides()
        if len(sides) < 2 or self.state.run is None:
            return []
        store = self.state.run.store
        found = [results(*side) for side in sides]
        recipes = [store.recipe(store.lane(lane).recipe) for lane, _ in self.places]
        other = [{name: (theirs, ours) for name, theirs, ours in recipe.differences(recipes[-1], by_figure=True)} for recipe in recipes]
        ours = {name: here for differing in other for name, (_, here) in differing.items()}
        settings = [(name, *(differing.get(name, (here,))[0] for differing in other)) for name, here in ours.items()]
        names = dict.fromkeys(name for one in found for name in one)
        cells = [(name, *(one.get(name, "–") for one in found)) for name in names]
        rows = [row for row in cells if set(row[1:]) != {"–"}]
        return rows + [(name.replace("_", " "), *map(said, values)) for name, *values in settings]

    @property
    def places(self) -> list[tuple[str, int]]:
        """Lane and iteration of each that is compared: the pinned one, the third, the one on show."""
        beside = [place for place in (self.pinned, self.third) if place is not None]
        return [*beside, (self.state.lane, self.state.iteration)] if self.pinned is not None else []

    def sides(self) -> list[tuple[Run, Row, Checkpoint]]:
        """What is compared; nothing if any of it is not there."""
        state, found = self.state, []
        for lane, iteration in self.places:
            row, checkpoint = state.row(iteration, lane), state.checkpoint_at(iteration, lane)
            if row is None or checkpoint is None or state.run is None:
                return []
            found.append((Run(state.run.store, lane, state.run.device), row, checkpoint))
        return found

    def decisive(self) -> tuple[int, str] | None:
        """The vertex that decides in the one of the compared that stays bent most, and a sentence on it."""
        sides = [(side, side[1].verdict) for side in self.sides()]
        judged = [(side, verdict) for side, verdict in sides if verdict is not None and verdict.outcome != "UNKNOWN"]
        if len(judged) < 2:
            return None
        (run, _, checkpoint), verdict = max(judged, key=lambda one: one[1].deciding.used if one[1].deciding else 0.0)
        styled, tested = run.part.surface.displaced(checkpoint.displacement), self.state.simulation(run.store, checkpoint)
        vertex, called = worst_vertex(styled, checkpoint, tested, verdict), self.state.called
        there = {called(one.lane): self._there(one, state, its, vertex) for (one, _, state), its in judged}
        return vertex, most_bent(called(run.lane), verdict, there)

    def _there(self, run: Run, state: Checkpoint, verdict: Verdict, vertex: int) -> str:
        """What the test that decides found at a vertex: what stays bent there, by the published rule the stress."""
        row = verdict.deciding
        if row is None or row.stress is not None:
            return f"{state.stress[vertex]:.0f} MPa"
        return sentences.bend_in(row, float(stays_bent(row).values_in(self.state.simulation(run.store, state))[vertex]))

    def insight(self) -> str:
        """How Freestyle and what is shown beside it compare at their ends, in a sentence or two; "" where they are not compared."""
        sides = {run.lane: (run, row) for run, row, _ in self.sides()}
        if len(sides) < 2 or FREE not in sides or self.lane == FREE:
            return ""
        (free, one), (fed, other) = sides[FREE], sides[self.lane]
        if one.verdict is None or other.verdict is None:
            return ""
        names = self.state.called(FREE), self.state.called(self.lane)
        return side_by_side(names, (one.verdict, other.verdict), (_share_kept(free, one), _share_kept(fed, other)))

    def _list(self, _change: object = None) -> None:
        names, called = [branch.lane for branch in self.state.branches], self.state.called
        with unheard(self._choice, self._choose):
            histories = self.state.histories
            self._choice.options = [(_line(one, histories[one.lane], called), one.lane) for one in self.state.branches]
            self._choice.value = self.lane if self.lane in names else None
            self._choice.rows = min(max(len(names), 2), 6)
        shown = next((branch for branch in self.state.branches if branch.lane == self.lane), None)
        rows = [(name.replace("_", " "), said(before), said(after)) for name, before, after in shown.changes] if shown else []
        self._changes.say(table(("changed", called(shown.parent) if shown else "", called(self.lane)), rows) if rows else "")
        self._redraw()

    def _change_places(self, change: dict[str, Any]) -> None:
        """Where the end of a lane stands beside another and comes to the front, the other stands beside it from now on."""
        ends = {lane: (lane, rows[-1].iteration) for lane, rows in self.state.histories.items() if rows}
        if self.pinned is not None and self.pinned == ends.get(change["new"]) and change["old"] in ends:
            self.pinned = ends[change["old"]]

    def _unpin(self, change: dict[str, Any]) -> None:
        """A pinned iteration belongs to the run it was pinned in."""
        if change["old"] is not None and change["new"] is not None and change["old"].store.place != change["new"].store.place:
            self.pinned = self.third = None

    def _choose(self, change: dict[str, Any]) -> None:
        if change["new"]:
            self.state.go_to(change["new"])
            self._list()

    def _redraw(self, _change: object = None) -> None:
        state = self.state
        nothing = state.checkpoint is None
        self._branch.description = word("branch from iteration {}").format(state.iteration)
        self._branch.disabled = nothing or state.status in ("preparing", "running", "paused")
        again = self.pinned == (state.lane, state.iteration)
        self._pin.description = word("stop comparing") if again else word("compare others with iteration {}").format(state.iteration)
        self._pin.disabled = nothing
        keep = word("keep {} · {} in a third pane").format(state.called(state.lane), state.iteration)
        self._also.description = word("two panes again") if self.third else keep
        show(self._also, self.pinned is not None)
        rows, decisive = self.comparison(), self.decisive()
        lines = [("", *(f"{state.called(lane)} · {iteration}" for lane, iteration in self.places)), *rows]
        head, *body = [(cells[0], *cells[-1:], *cells[1:-1]) for cells in lines]  # as the panes stand, what is on show at the left
        why = f'<div class="mechstyle-note">{escape(translated(decisive[1]))}</div>' if decisive else ""
        self._comparison.say(why + table(head, body) if rows else "")
        self.note(word("Nothing to branch from yet: run something first.") if nothing else "")


def _line(branch: Branch, rows: Sequence[Row], called: Callable[[str], str]) -> str:
    outcome = next((row.outcome for row in reversed(rows) if row.outcome), "")
    where = f"{branch.iteration} of {branch.iterations}" if branch.iteration < branch.iterations else f"{branch.iterations}"
    origin = f", from {called(branch.parent)} · {branch.forked_at}" if branch.forked_at and branch.parent else ""  # 0 is the plain part
    return f"{LOOKS[outcome].mark if outcome else '·'} {called(branch.lane)} · {translated(where + origin)}"


def side_by_side(names: tuple[str, str], verdicts: tuple[Verdict, Verdict], kept: tuple[float | None, float | None]) -> str:
    """How two runs of one part and style compare, in two short sentences: how they look, and what stays bent where they differ most.

    `kept` are the shares of the relief that are left, None where that is not known.
    """
    pairs = [(one, other) for one in verdicts[0].rows if (other := verdicts[1].row(landing=one.landing, load=one.load)) is not None]
    if not pairs or any(verdict.outcome == "UNKNOWN" for verdict in verdicts):
        return "One of the two gave no answer, so there is nothing to compare."
    first, second = max(pairs, key=lambda pair: max(row.used for row in pair))
    alike, (free, fed) = "", kept
    if free is not None and fed is not None and free > 0.0:
        alike = "Both look alike. " if fed >= ALIKE * free else f"{names[1]} keeps {fed:.0%} of the relief, {names[0]} {free:.0%}. "
    if first.stress is not None:
        stresses = ", ".join(f"{name} {sentences.found(row)}" for name, row in zip(names, (first, second), strict=True))
        return f"{alike}Largest stress: {stresses}; {sentences.allowed(first)} is allowed."
    where = sentences.landed(first)
    both = ", " if first.cracks or second.cracks else " and "
    compared = f"{both.join(f'{name} {_does(row)}' for name, row in zip(names, (first, second), strict=True))}, {where}"
    if abs(second.permanent_set - first.permanent_set) <= SAME and not any(row.cracks or row.collapses for row in (first, second)):
        compared = f"Of both {sentences.found(first)} stays bent, {where}"
    return f"{alike}{compared}; {sentences.allowed(first)} is allowed."


def _does(row: Judged) -> str:
    """What a part does in a test, after its name."""
    return "gives way" if row.collapses else f"stays bent by {sentences.bend(row.permanent_set)}{' and cracks' if row.cracks else ''}"


def most_bent(lane: str, verdict: Verdict, there: Mapping[str, str]) -> str:
    """What a mark at the worst place says; `there` are the figures of each lane at that place."""
    known = ", ".join(f"{name} {figure}" for name, figure in there.items())
    worst = "is loaded" if verdict.criterion == "paper" else "stays bent"
    return f"✕ marks where {lane} {worst} most ({sentences.least(verdict)}); there, each in its worst test: {known}."


def results(run: Run, row: Row, checkpoint: Checkpoint) -> dict[str, str]:
    """Results of an iteration of a lane, as table cells."""
    verdict = row.verdict
    decides = None if verdict is None else verdict.deciding
    return {
        "tested because": row.reason or "not tested",
        "outcome": "–" if verdict is None else said_of(verdict),
        **({} if verdict is None else {sentences.label(test): sentences.found(test) for test in verdict.rows}),
        "allowed": "–" if decides is None else sentences.allowed(decides),
        "relief kept": kept(run, row),
        "style loss": f"{row.style_loss:.3g}",
        "largest relief": f"{float(np.abs(checkpoint.displacement).max()):.2f} mm",
        "held back by more than half": f"{row.share:.1%}",
    }


def said_of(verdict: Verdict) -> str:
    """An outcome with its mark, and whether it is sure, as a table cell."""
    return f"{LOOKS[verdict.outcome].mark}\N{NO-BREAK SPACE}{sentences.marked(verdict.outcome, sure=verdict.sure)}"


def kept(run: Run, row: Row) -> str:
    """Share of the relief that is left at the end of a lane, as a table cell."""
    share = _share_kept(run, row)
    return "–" if share is None else f"{share:.0%}"


def _share_kept(run: Run, row: Row) -> float | None:
    return share_kept(run) if row.iteration == run.recipe.schedule.iterations else None


def said(value: Any) -> str:
    """A setting's value as a table shows it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, tuple):  # of regions or load cases
        return "; ".join(one.name if isinstance(one, LoadCase) else one.words for one in value) or "–"
    return value.name if isinstance(value, Material) else SPOKEN.get(str(value), str(value)) or "–"
