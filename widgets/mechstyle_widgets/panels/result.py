"""What will happen, and what has come of it: always in sight, whatever else is looked into."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

from mechstyle.loop.history import standing
from mechstyle.records import Row, sentences
from mechstyle.runs.run import Run
from mechstyle.runs.summary import on_little
from mechstyle.simulation.estimate import falls_of_a_test, landings_on_the_way, plan_of
from mechstyle.simulation.printed import plastic_share
from mechstyle_widgets.jupyter.language import said, word
from mechstyle_widgets.panels.branches import kept, said_of
from mechstyle_widgets.settings.section import WIDE, Words, table
from mechstyle_widgets.state.on_show import OnShow, on_show, summary_of
from mechstyle_widgets.state.studio_state import StudioState

LANES = ("run", "outcome", "kept")
MOST = 4
"""Tests that are shown, the worst of them, before all are asked for."""


class Result(Words):
    """The steps of a run before there is one, then three figures of what is on show, and behind them all that is known of it."""

    def __init__(self, state: StudioState) -> None:
        """Tell of what a state shows."""
        self._state = state
        super().__init__(layout=WIDE)
        self.add_class("mechstyle-result")
        state.observe(self._tell, ("histories", "checkpoint", "lane", "settings", "run", "status", "title", "another", "price"))
        self._tell()

    def _tell(self, _change: object = None) -> None:
        shown = on_show(self._state)
        if shown is None:
            plan = (" · ".join(filter(None, (said(step), falls(count, more)))) for step, count, more in steps(self._state.settings))
            items = "".join(f"<li>{escape(line)}</li>" for line in plan)
            self.say(f"<b>{escape(word('What will happen'))}</b><ol>{items}</ol>")
            return
        head = said(self._state.headed(shown.title) or "Result")
        lanes = list(self._judged())
        judged, doubt = of_show(shown)
        more = f"{judged}{table(LANES, lanes) if lanes else ''}{self._notes()}"
        folded = f"<details><summary>{escape(word('More about it'))}</summary>{more}</details>"
        self.say(f"<b>{escape(head)}: {escape(said(shown.words))}</b>{figures(shown, *self._weight())}{doubt}{folded}")

    def _weight(self) -> tuple[str, str, str]:
        """What the part on show weighs as printed, how that is, and in a few words the plain one and its filament; "" for a sheet."""
        run, shown = self._state.run, self._state.checkpoint
        if run is None or shown is None or (plain := run.part.surface.volume) <= 0.0:
            return "", "", ""
        density, price = run.recipe.test.material.density * plastic_share(run.part.tets, run.recipe), self._state.price
        styled = run.part.surface.displaced(shown.displacement).volume
        digits = 0 if density * plain >= 20.0 else 1
        costs = word("{} of your currency").format(f"{1e-3 * price * density * styled:.2f}") if price else ""
        beside = word("plain {} g").format(f"{density * plain:.{digits}f}")
        how = word("printed solid" if run.recipe.printed.solid else "printed as asked")
        return f"{density * styled:.{digits}f} g", how, ", ".join(filter(None, (costs, beside)))

    def _notes(self) -> str:
        """HTML of what else is known of the finished lane on show, "" before its end; the badge says how little is left of its style."""
        run, shown = self._state.run, on_show(self._state)
        if run is None or shown is None or shown.kept is None:
            return ""
        notes = summary_of(run).notes
        items = "".join(f"<li>{escape(said(note))}</li>" for note in notes if note != on_little(notes))
        return f"<ul>{items}</ul>" if items else ""

    def _judged(self) -> Iterator[tuple[str, str, str]]:
        """Name, outcome and relief kept of each lane that was tested since it began."""
        run = self._state.run
        for lane, rows in self._state.histories.items():
            tested = [row for row in rows if row.verdict is not None and row.iteration > 0]
            if tested and run is not None:
                row, verdict = standing(tested)
                yield self._state.called(lane), said_of(verdict), kept(Run(run.store, lane, run.device), row)


def figures(shown: OnShow, weight: str = "", how: str = "", beside: str = "") -> str:
    """HTML of three figures of what is on show, each with a few words: what stays bent, the style that is left, what it weighs."""
    row = None if shown.verdict is None else shown.verdict.deciding
    bent, about = "–", said(shown.words) if shown.verdict is not None else ""  # what was not tested says so above
    if row is not None:
        plain = [] if row.plain_permanent_set is None else [word("plain {}").format(sentences.bend(row.plain_permanent_set))]
        bent, _, cracks = said(sentences.found(row)).partition(", ")  # a large figure is short, or it takes three lines
        about = ", ".join(filter(None, [cracks, word("allowed {}").format(sentences.allowed(row)), *plain]))
    kept = ("–", word("known at the end")) if shown.kept is None else (f"{shown.kept:.0%}", "")
    named = [(bent, "stays bent" if row is None or row.stress is None else "largest stress", about), (kept[0], "style kept", kept[1])]
    if weight:
        named.append((weight, how, beside))
    cells = (
        f"<div><dt>{escape(word(name))}</dt><dd>{figure}</dd><dd><small>{escape(more)}</small></dd></div>" for figure, name, more in named
    )
    return f'<dl class="mechstyle-figures">{"".join(cells)}</dl>'


def of_show(shown: OnShow) -> tuple[str, str]:
    """HTML of the verdict on what is on show: the outcome in a sentence, its worst tests, how much it carries; and of its doubt."""
    if shown.verdict is None:
        return "", ""
    verdict = shown.verdict
    (headings, rows), doubt = sentences.tabulated(verdict), sentences.doubt(verdict)
    falls = table(headings, rows) if rows else ""
    if len(rows) > MOST:  # a standard has 27
        decides, others = verdict.deciding, zip(verdict.rows, rows, strict=True)
        worst = sorted(others, key=lambda pair: (pair[0] is not decides, -pair[0].used))[:MOST]
        every = escape(word("all {} tests").format(len(rows)))
        falls = f"{table(headings, [cells for _, cells in worst])}<details><summary>{every}</summary>{falls}</details>"
    falls = f'<div class="mechstyle-tests">{falls}</div>' if falls else ""
    for words in filter(None, map(carried, verdict.rows)):
        falls += f'<div class="mechstyle-note">{escape(said(words))}</div>'
    unsure = f'<div class="mechstyle-warning" role="status">{escape(said(doubt))}</div>' if doubt else ""
    return f"<div>{escape(said(verdict.head))}</div>{falls}", unsure


def carried(row: Row) -> str:
    """How much of a load the part carries, "" for a landing."""
    if row.carries is None:
        return ""
    return f"it carries {'at least ' if row.most_tried else ''}{row.carries:.2f} times the load {row.load!r}"


def falls(count: int, more: int = 0) -> str:
    """So many falls, and so many more if the part is corrected, in the language spoken; "" for none."""
    words = word("1 fall") if count == 1 else word("about {} falls").format(count) if count else ""
    return f"{words}, {word('{} more if it is corrected').format(more)}" if more else words


def steps(settings: Mapping[str, Any]) -> list[tuple[str, int, int]]:
    """What a run with these settings does, one thing after the other, with its falls, and those of one correction."""
    plan, loads = plan_of(settings), settings.get("loads", ())
    if plan is None:
        return []
    between, landings = len(plan.places) - 1, landings_on_the_way(settings)
    about, budget = "" if plan.certain else "about ", settings.get("strengthen", 0.0)
    others = settings.get("orientations", 1) - 1
    ways = ["flat", *(["nearly flat"] if settings.get("nearly_flat", True) else [])]
    ways += [f"in {others} other landing{'s' if others > 1 else ''}"] if others else []
    how = " and ".join(filter(None, (", ".join(ways[:-1]), ways[-1])))
    carried, times = ", and load it" if loads else "", "once" if between == 1 else f"{between} times"
    whole, steering = falls_of_a_test(settings), between * (landings + len(loads))
    return [
        *([(f"Thicken it by up to {budget:g} mm where it does not hold as it is", 0, 0)] if budget else []),
        (f"Drop the plain part {how}{carried}", whole, 0),
        (f"Style it in {plan.places[-1]} small steps", 0, 0),
        *([(f"Drop it on the way, {about}{times}, in {landings} landing{'s' if landings > 1 else ''}", steering, 0)] if between else []),
        (f"Drop what has come of it {how}{carried}", whole, whole if settings.get("guarantee", True) else 0),
    ]
