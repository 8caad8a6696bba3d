"""Every sentence about a verdict, in one place: the head, the table, the doubt and the explanation."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from mechstyle.records.written import written

if TYPE_CHECKING:
    from mechstyle.records.verdict import Row, Verdict

COLUMNS = ("test", "plain", "styled", "asked", "reserve", "outcome")
"""Headings of `table`."""

EXPLANATION = (
    "We let the plain part and the styled part fall in the same ways, in simulation.",
    "For each way we ask: from how high may it fall before a piece as large as a cube of 4 mm is bent for good?",
    "That height must be at least the fall you asked for, or nearly that of the plain part.",
    "We ask the same of a load: how much of it can the part carry before a cube of 2 mm begins to yield?",
    "If every test passes, the part HOLDS; if one passes only because the plain part survives no more, it is NO WORSE; else it FAILS.",
)
"""How the part is judged, in five sentences."""

MEANINGS = {
    "HOLDS": "The part survives the fall and the loads that were asked for.",
    "NO WORSE": "In one test the styled part survives less than was asked for, but nearly as much as the plain part at least.",
    "FAILS": "In one test a piece of the part is bent for good, and the plain part survives clearly more or was not compared.",
    "UNKNOWN": "The test gave no answer. Never read that as survived.",
}
"""What each outcome means."""

NOT_SURE, NOT_JUDGED, NOT_TESTED = "(not sure)", "not judged", "NOT TESTED"
"""What follows an outcome that leaves a doubt, and what replaces that of a test that does not decide, and of none."""

HIGHEST = 10_000.0
"""Heights above are all shown as more than this [mm]."""
ALIKE = 0.9
"""Share of the other's relief from which on a part looks like it."""
LITTLE = 0.7
"""Share of the style's relief below which it is said how more of it may be had."""
SAME = 0.05
"""Relative difference up to which two figures are about the same."""


# --- figures ------------------------------------------------------------------------------------------------------


def length(height: float) -> str:
    """A height [mm] in the unit a person would use."""
    if height > HIGHEST:
        return f"more than {HIGHEST / 1000:.0f} m"
    if height >= 995.0:
        return f"{height / 1000:.1f} m" if height < 9950.0 else "10 m"
    return f"{height / 10:.0f} cm" if height >= 9.5 else f"{height:.0f} mm"


def stress(value: float | None, limit: float | None) -> str:
    """A stress and its limit, a dash where there was no answer."""
    return "–" if value is None or limit is None else f"{value:.1f} of {limit:.1f} MPa"


def _value(row: Row, value: float) -> str:
    """A height or a factor."""
    return length(value) if row.height is not None else f"{value:.2f} ×"


def _figures(row: Row, verdict: Verdict) -> str:
    """What plain and styled part survive."""
    survives = _value(row, row.survived)
    return survives if row.original is None else f"plain {_value(row, row.original)}, {verdict.style or 'styled'} {survives}"


def duration(seconds: float) -> str:
    """A time for people: 40 s, 3 min, 2 h."""
    if seconds < 90:
        return f"{max(round(seconds), 1)} s"
    return f"{round(seconds / 60)} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


# --- one verdict --------------------------------------------------------------------------------------------------


def short(verdict: Verdict) -> str:
    """The outcome in a few words."""
    decides = verdict.deciding
    if decides is None or verdict.outcome == "UNKNOWN":
        return verdict.outcome
    if decides.test == "published rule":
        return f"{verdict.outcome} by the published rule"
    if verdict.outcome == "NO WORSE":
        return "NO WORSE than the plain part"
    failed = verdict.outcome == "FAILS" and decides.load
    return f"{verdict.outcome} {f'the load {decides.load!r}' if failed else f'a fall of {written(verdict.fall)}'}"


def head(verdict: Verdict) -> str:
    """The outcome in one sentence, and the material in another."""
    decides = verdict.deciding
    if decides is None or verdict.outcome == "UNKNOWN":
        return f"UNKNOWN: {verdict.failure.rstrip('.')}."
    if decides.test == "published rule":
        side = "at most" if decides.outcome == "HOLDS" else "above"
        strength = f"the {verdict.strength:.1f} MPa at which {verdict.material} yields"
        return f"{verdict.outcome} by the published rule: the largest element stress is {decides.stress:.1f} MPa, {side} {strength}."
    return f"{verdict.outcome} {_clauses(verdict)}. Solid {verdict.material}, which yields at {verdict.strength:.1f} MPa."


def _clauses(verdict: Verdict) -> str:
    """What a part holds, or in what it is no worse than the plain part, or what it fails; and how it lands flat if it passes that."""
    flat = verdict.rows[0]
    if verdict.outcome == "HOLDS":  # of several loads the one that is nearest to its limit is named
        loads = sorted((row for row in verdict.rows if row.test == "load"), key=lambda row: row.reserve)
        if len(loads) > 1:
            return f"{_clause(flat, verdict)} and all {len(loads)} loads, of which {_clause(loads[0], verdict)} has the least reserve"
        return " and ".join(_clause(row, verdict) for row in (flat, *loads))
    decide = [row for row in verdict.rows if row.decides and row.outcome == verdict.outcome]
    if verdict.outcome == "NO WORSE":
        clauses = [f"flat it holds {_clause(flat, verdict)}"] if flat.outcome == "HOLDS" else []
        for row in decide:
            below = f"below {written(verdict.fall)}" if row.height is not None else "before all of it acts"
            clauses.append(f"{_where(row)} it begins to yield {below} ({_figures(row, verdict)})")
        return f"than the plain part: {'; '.join(clauses)}"
    fails = ", and also ".join([_clause(decide[0], verdict), *(f"{_where(row)} ({_figures(row, verdict)})" for row in decide[1:])])
    if flat in decide:
        return fails
    passes = "it holds" if flat.outcome == "HOLDS" else "it is no worse than the plain part in"
    return f"{fails}; flat {passes} {_clause(flat, verdict)}"


def _clause(row: Row, verdict: Verdict) -> str:
    """What is asked of a part in a test, and what it survives."""
    what = f"the load {row.load!r}" if row.load else f"a fall of {written(verdict.fall)}"
    where = "" if row.test in ("flat", "load") else f" {_where(row)}"
    figures = _figures(row, verdict)
    return f"{what}{where} ({figures if row.original is not None else f'it survives {figures}'})"


def _where(row: Row) -> str:
    """A test in the middle of a sentence."""
    return {"load": f"under the load {row.load!r}", "any landing": "in the mean of other landings"}.get(row.test, row.landing)


def doubt(verdict: Verdict) -> str:
    """Why the outcome is not sure and what to do, "" if it is sure."""

    def listed(words: Sequence[str]) -> str:
        return " and ".join([*([", ".join(words[:-1])] if len(words) > 1 else []), words[-1]])

    reasons, tests, near = list[str](), list[str](), [one for one in verdict.doubts if one.about == "limit"]
    for one in near:
        test = {"load": f"the load {one.load!r}", "published rule": "the published rule"}.get(one.test, one.landing or one.test)
        share = abs(one.value - 1.0)
        tests.append(f"{test} {'passes' if one.value >= 1.0 else 'fails'} by {f'{share:.0%}' if share >= 0.005 else 'less than 1%'}")
    if near:
        dropped, loaded = any(not one.load for one in near), any(one.load for one in near)
        ways = " or ".join(["less relief"] * bool(verdict.style) + ["a lower fall"] * dropped + ["a smaller load"] * loaded)
        repeats = "the test repeats" if len(near) == 1 else "these tests repeat"
        reasons.append(f"{listed(tests)}, closer than {repeats}; {f'ask for {ways}' if verdict.passes else f'{ways} may pass'}")
    missed = list[str]()
    for one in verdict.doubts:
        if one.about == "relief":
            known = f"the mesh follows only {one.value:.0%} of the relief"
            missed.append(known if math.isfinite(one.value) else "what the mesh follows of the relief is not known")
        elif one.about == "volume":
            known = f"the volume of the mesh is {one.value:+.1%} off that of the part"
            missed.append(known if math.isfinite(one.value) else "the volume of the mesh is not known")
    if missed:
        reasons.append(f"{listed(missed)}; ask for more vertices")
    return f"Not sure: {'; '.join(reasons)}." if reasons else ""


# --- its table ----------------------------------------------------------------------------------------------------


def table(verdict: Verdict) -> list[tuple[str, ...]]:
    """The table of tests as text, a row each, under COLUMNS; a dash stands for what is not known."""
    return [
        (
            _label(row), "–" if row.original is None else _value(row, row.original), _value(row, row.survived),
            written(row.asked) if row.height is not None else "1 ×", f"{row.reserve - 1.0:+.0%}", _judged(row),
        )
        for row in verdict.rows
    ]  # fmt: skip


def tabulated(verdict: Verdict) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Headings and rows of the table of tests; a part that is tested by itself has one column of figures."""
    rows = table(verdict)
    if any(row.original is not None for row in verdict.rows):
        return COLUMNS, rows
    headings = tuple({"styled": "survives"}.get(name, name) for name in COLUMNS if name != "plain")
    return headings, [(row[0], *row[2:]) for row in rows]


def in_full(verdict: Verdict) -> str:
    """How a part is judged, the outcome, every figure of the table and the doubt, a line each."""
    headings, found = tabulated(verdict)
    lines = [f"{row[0]}: {', '.join(f'{name} {cell}' for name, cell in zip(headings[1:], row[1:], strict=True))}" for row in found]
    return "\n".join(filter(None, (" ".join(EXPLANATION), head(verdict), *lines, doubt(verdict))))


def survived(verdict: Verdict) -> dict[str, str]:
    """What a part survives in each test, by the name of the test."""
    return {_kind(row): _value(row, row.survived) for row in verdict.rows}


def paired(styled: Sequence[Verdict]) -> list[tuple[str, ...]]:
    """The tests of several runs of one part, a row each: test, what the plain part survives, what each run's does, what is asked."""
    found = dict.fromkeys((row.test, row.load) for verdict in styled for row in verdict.rows)
    lines = []
    for test, load in sorted(found, key=lambda kind: kind[0] == "published rule"):
        rows = [verdict.row(test, load) for verdict in styled]
        there = [row for row in rows if row is not None]
        plain = next((_value(row, row.original) for row in there if row.original is not None), "–")
        cells = ("–" if row is None else f"{_value(row, row.survived)} {_judged(row)}" for row in rows)
        asked = written(there[0].asked) if there[0].height is not None else "1 ×"
        lines.append((_kind(there[0]), plain, *cells, asked))
    return lines


def _kind(row: Row) -> str:
    """A test without the landing that decides it."""
    return f"load {row.load}" if row.load else row.test


def _label(row: Row) -> str:
    """A test as a table names it, with the landing that decides it."""
    return f"{row.test}: {row.landing}" if row.test in ("nearly flat", "any landing") else _kind(row)


def _judged(row: Row) -> str:
    return row.outcome if row.decides else NOT_JUDGED


# --- before a run -------------------------------------------------------------------------------------------------


def planned(height: float, falls: int, seconds: float) -> str:
    """The test of a run that has not begun, and how long it will take [s]."""
    return f"We let it fall from {written(height)}, in simulation, about {falls} times: about {duration(_rounded(seconds))}."


def measured_out(falls: int, seconds: float) -> str:
    """The tests before any correction, now that the tetrahedra are known, and how long they will take [s]."""
    known = f"Its tetrahedra are known now: before any correction it falls about {falls} times"
    return f"{known}, which takes about {duration(_rounded(seconds))}."


def _rounded(seconds: float) -> float:
    """An estimate to one or two figures."""
    step = 5.0 if seconds < 90 else 60.0
    return max(step * round(seconds / step), step)


# --- beside other things ------------------------------------------------------------------------------------------


def marked(outcome: str, *, sure: bool) -> str:
    """An outcome, with NOT_SURE if it leaves a doubt."""
    return outcome if sure or outcome.startswith("UNKNOWN") else f"{outcome} {NOT_SURE}"


def tested_at(iteration: int) -> str:
    """When a part was tested, beside another iteration of it."""
    return f"tested at iteration {iteration}"


def weighed(styled: float, plain: float) -> str:
    """What a part printed solid weighs beside the plain part [g]."""
    figures = 0 if plain >= 20.0 else 1
    return f"Printed solid it weighs {styled:.{figures}f} g, the plain part {plain:.{figures}f} g."


def least(verdict: Verdict) -> str:
    """What plain and styled part survive in the test with the least reserve, "" where there is none."""
    row = verdict.deciding
    return "" if row is None else f"{_label(row)}: {_figures(row, verdict)}"


def side_by_side(names: tuple[str, str], verdicts: tuple[Verdict, Verdict], kept: tuple[float | None, float | None]) -> str:
    """How two runs of one part and style compare, in two short sentences: how they look, and what each survives where they differ most.

    `kept` are the shares of the relief that are left, None where that is not known.
    """
    pairs = [(one, other) for one in verdicts[0].rows if one.decides and (other := verdicts[1].row(one.test, one.load)) is not None]
    if not pairs or any(verdict.outcome == "UNKNOWN" for verdict in verdicts):
        return "One of the two gave no answer, so there is nothing to compare."
    first, second = min(pairs, key=lambda pair: min(row.reserve for row in pair))
    alike, (free, fed) = "", kept
    if free is not None and fed is not None and free > 0.0:
        alike = "Both look alike. " if fed >= ALIKE * free else f"{names[1]} keeps {fed:.0%} of the relief, {names[0]} {free:.0%}. "
    asked = written(verdicts[0].fall) if first.height is not None else "once"
    what = f"carry the load {first.load!r}" if first.load else "pass the published rule" if first.height is None else "fall from"
    where = {"nearly flat": ", landing nearly flat", "any landing": ", landing any way up"}.get(first.test, "")
    here, there = (length(row.survived) if row.height is not None else f"{row.survived:.2f} times" for row in (first, second))
    again = "from " if first.height is not None else ""
    survive = f"{names[0]} may {what} {here}, {names[1]} {again}{there}{where}"
    if abs(second.survived - first.survived) <= SAME * max(first.survived, second.survived):
        survive = f"{names[0]} and {names[1]} may both {what} {here}{where}"
    return f"{alike}{survive}; {asked} was asked for."


def little_left(kept: float, side: str) -> str:
    """What to try where little of a relief is left, "" where enough is left or it only goes outwards."""
    if kept >= LITTLE or side == "outwards":
        return ""
    return f"only {kept:.0%} of the style is left: cuts into a wall weaken it, so try relief that only goes outwards (--side outwards)"


def least_left(lane: str, verdict: Verdict, stresses: Mapping[str, float]) -> str:
    """What a mark at the place with the least reserve says; `stresses` are those of each lane there [MPa]."""
    known = ", ".join(f"{name} {there:.0f} MPa" for name, there in stresses.items())
    return f"✕ marks where {lane} has least left ({least(verdict)}); stress there, each in the test that decides: {known}."


def note(verdict: Verdict) -> str:
    """The outcome in a few words, and the stress of the test that decides: a line under a picture of that test."""
    row = verdict.deciding
    return "UNKNOWN: this test gave no answer" if row is None else f"{marked(short(verdict), sure=verdict.sure)}; {figures(row)}"


def figures(row: Row) -> str:
    """The stress of a test and what it may at most be."""
    if row.test == "any landing":
        return f"{row.landing}; the mean of all other landings is {stress(row.stress, row.limit)}"
    return f"{named(row)}: {stress(row.stress, row.limit)}"


def most(row: Row) -> str:
    """What a picture of a test says of its greatest stress: what is judged, which all that is above it is shown as."""
    return f"{'largest in an element' if row.test == 'published rule' else 'σ_V'} {row.stress:.1f} MPa"


def named(row: Row) -> str:
    """The landing or load that a picture of a test shows."""
    return {"load": f"load {row.load}", "published rule": "published rule"}.get(row.test, row.landing)
