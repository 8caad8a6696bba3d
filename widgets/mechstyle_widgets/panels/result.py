"""What will happen, and what has come of it: always in sight, whatever else is looked into."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from html import escape
from typing import Any

from mechstyle.errors import MechStyleError
from mechstyle.loop.history import Row
from mechstyle.runs.run import Run
from mechstyle_widgets.panels.branches import kept
from mechstyle_widgets.settings.section import WIDE, Words, table
from mechstyle_widgets.state.outcomes import LOOKS
from mechstyle_widgets.state.schedule_forecast import plan_of
from mechstyle_widgets.state.studio_state import StudioState

HEAD = ("run", "verdict", "factor", "value and limit", "kept")


class Result(Words):
    """The steps of a run before there is one, then the last verdict of each lane beside that of the part as it came."""

    def __init__(self, state: StudioState) -> None:
        """Tell of what a state shows."""
        self._state = state
        super().__init__(layout=WIDE)
        self.add_class("mechstyle-result")
        state.observe(self._tell, ("histories", "settings", "run", "status"))
        self._tell()

    def _tell(self, _change: object = None) -> None:
        rows = [(_name(one), *cells) for one, cells in self._judged()]
        if rows:
            told = informing(self._state.run)
            self.say(f"<b>Result</b>{table(HEAD, rows)}" + (f'<div class="mechstyle-note">{escape(told)}</div>' if told else ""))
        else:
            self.say(f"<b>What will happen</b><ol>{''.join(f'<li>{escape(step)}</li>' for step in steps(self._state.settings))}</ol>")

    def _judged(self) -> Iterator[tuple[str, tuple[str, ...]]]:
        """Name and cells of the part as it came and of each lane that was tested since."""
        run, histories = self._state.run, self._state.histories
        if run is None:
            return
        first = next((rows[0] for rows in histories.values() if rows and rows[0].iteration == 0), None)
        if first is not None and first.verdict is not None:
            yield "", _cells(first, "–")
        for lane, rows in histories.items():
            tested = next((row for row in reversed(rows) if row.verdict is not None and row.iteration > 0), None)
            if tested is not None:
                yield lane, _cells(tested, kept(Run(run.store, lane, run.device), tested))


def informing(run: Run | None) -> str:
    """What decides nothing but tells what a fall may do, beside the part as it came: known at the end of a lane, "" before.

    The worst landing, and how many random drops begin to yield the part.
    """
    said = []
    with suppress(MechStyleError):  # there is no summary before the end
        if run is not None:
            before, now = run.summary.baseline, run.summary.result
            if now.worst is not None and before.worst is not None:
                said.append(f"Worst landing of {run.lane}: {now.worst:.0f} MPa, {now.worst_landing}; as it came {before.worst:.0f} MPa.")
            chance, first = now.failure_probability, before.failure_probability
            if chance is not None and first is not None:
                said.append(f"{chance:.0%} of random drops begin to yield it, {first:.0%} as it came.")
    return " ".join(said)


def steps(settings: Mapping[str, Any]) -> list[str]:
    """What a run with these settings does, one thing after the other."""
    plan, drops = plan_of(settings), settings.get("orientations", 1) + settings.get("tilts", 0)
    if plan is None:
        return []
    between = len(plan.places) - 1
    about, budget = "" if plan.certain else "about ", settings.get("strengthen", 0.0)
    return [
        *([f"Thicken it by up to {budget:g} mm where it does not hold as it came"] if budget else []),
        "Drop the part as it came",
        f"Style it in {plan.places[-1]} small steps",
        *([f"Drop it on the way, {about}{_times(between)}"] if between else []),
        f"Drop what has come of it, {_times(drops)}",
    ]


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _name(lane: str) -> str:
    return lane or "as\N{NO-BREAK SPACE}it\N{NO-BREAK SPACE}came"


def _cells(row: Row, left: str) -> tuple[str, ...]:
    verdict = row.verdict
    assert verdict is not None, "only what was tested is told of"
    told = ("–", "–") if verdict.outcome == "UNKNOWN" else (f"{verdict.safety_factor:.2f}", verdict.tightest.short)
    return (f"{LOOKS[verdict.word].mark}\N{NO-BREAK SPACE}{verdict.word}", *told, left)
