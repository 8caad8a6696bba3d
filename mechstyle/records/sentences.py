"""Every sentence about a verdict, in one place: the head, the table, the doubt and the explanation."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from mechstyle.records.written import written

if TYPE_CHECKING:
    from mechstyle.records.verdict import Row, Verdict

COLUMNS = ("test", "plain", "styled", "allowed", "strain", "outcome")
"""Headings of `table`."""

EXPLANATION = (
    "We let the plain part and the styled part fall in the same ways, in simulation, and put the same loads on both.",
    "Where the stress reaches the yield strength the material gives way, as the real one does.",
    "For each fall and each load we ask: how many millimetres of bend stay when all is at rest, and does the material crack?",
    "No more may stay than the tolerance, and nothing may crack.",
    "If that is so in every test, the part HOLDS; if no more stays than of the plain part, it is NO WORSE; else it FAILS.",
)
"""How the part is judged, in five sentences."""

MEANINGS = {
    "HOLDS": "After every fall and load that was asked for, no more than the tolerance stays bent, and nothing cracks.",
    "NO WORSE": "In one test more than the tolerance stays bent, but hardly more than of the plain part.",
    "FAILS": "In one test more than the tolerance stays bent, and more than of the plain part, or the material cracks.",
    "UNKNOWN": "The test gave no answer. Never read that as survived.",
}
"""What each outcome means."""

NOT_SURE, NOT_TESTED = "(not sure)", "NOT TESTED"
"""What follows an outcome that leaves a doubt, and what replaces that of no test."""

NOTHING = 0.005
"""Permanent set that counts as none [mm]."""
ALIKE = 0.9
"""Share of the other's relief from which on a part looks like it."""
LITTLE = 0.7
"""Share of the style's relief below which it is said how more of it may be had."""
SAME = 0.02
"""Difference up to which two permanent sets are about the same [mm]."""


# --- figures ------------------------------------------------------------------------------------------------------


def bend(permanent_set: float, digits: int = 0) -> str:
    """A permanent set [mm] as people read it, with so many digits behind the point or more."""
    if permanent_set < NOTHING:
        return "0 mm"
    return f"{permanent_set:.{max(digits, 2 if permanent_set < 9.95 else 0)}f} mm"


def _digits(row: Row) -> int:
    """Digits behind the point with which what is too much also reads as more than what is allowed."""
    found, allowed = row.permanent_set, row.allowed
    return next((n for n in range(6) if found <= allowed or bend(found, n) != bend(allowed, n)), 6)


def stress(value: float | None, limit: float | None) -> str:
    """A stress and its limit, a dash where there was no answer."""
    return "–" if value is None or limit is None else f"{value:.1f} of {limit:.1f} MPa"


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
    """The outcome in one sentence: what was asked, the worst that stays bent, where, and in which test."""
    decides = verdict.deciding
    if decides is None or verdict.outcome == "UNKNOWN":
        return f"UNKNOWN: {verdict.failure.rstrip('.')}."
    if decides.test == "published rule":
        assert decides.stress is not None, "the published rule reads a stress"
        side = "at most" if decides.outcome == "HOLDS" else "above"
        strength = f"the {verdict.strength:.1f} MPa at which {verdict.material} yields"
        return f"{verdict.outcome} by the published rule: the largest element stress is {decides.stress:.1f} MPa, {side} {strength}."
    loads = [row.load for row in verdict.rows if row.load]
    asked = f"a fall of {written(verdict.fall)}"
    if verdict.outcome == "FAILS":
        asked = f"the load {decides.load!r}" if decides.load else asked
    elif loads:
        asked += f" and the load {loads[0]!r}" if len(loads) == 1 else f" and {len(loads)} loads"
    outcome = "NO WORSE than the plain part in" if verdict.outcome == "NO WORSE" else verdict.outcome
    return f"{outcome} {asked}: {_at_worst(decides, verdict)}. Solid {verdict.material}."


def _at_worst(row: Row, verdict: Verdict) -> str:
    """What stays bent in the worst test, where, and beside the plain part."""
    if row.collapses:
        known = "" if row.carries is None else f", at {row.carries:.2f} times the load"
        return f"the part gives way{f' {row.place}' if row.place else ''}{known}"
    if row.permanent_set < NOTHING and verdict.outcome == "HOLDS":
        return "nothing stays bent"
    place = f" {row.place}" if row.place else ""
    figures = [f"plain part {bend(row.plain_permanent_set)}"] if row.plain_permanent_set is not None else []
    if verdict.outcome != "HOLDS":
        figures.append(f"{allowed(row)} allowed")
    strain = f"{row.plastic_strain:.1%} of strain where {row.elongation:.1%} break it"
    beside = f" ({', '.join(figures)})" if figures else ""
    if row.cracks and row.permanent_set <= row.allowed:  # what decides comes first
        return f"it cracks, {_landed(row)}, with {strain}, and {bend(row.permanent_set)} stays bent{beside}"
    cracks = f", and it cracks: {strain}" if row.cracks else ""
    at_worst = "at worst " if verdict.outcome == "HOLDS" else ""
    return f"{at_worst}{bend(row.permanent_set, _digits(row))} stays bent{place}, {_landed(row)}{beside}{cracks}"


def _landed(row: Row) -> str:
    """The test of a row in the middle of a sentence."""
    if row.load:
        return f"under the load {row.load!r}"
    if row.test == "nearly flat":
        return row.landing
    return f"landing {row.landing}" if row.test == "flat" else f"in the landing {row.landing!r}"


def doubt(verdict: Verdict) -> str:
    """Why the outcome is not sure and what to do, "" if it is sure."""

    def listed(words: Sequence[str]) -> str:
        return " and ".join([*([", ".join(words[:-1])] if len(words) > 1 else []), words[-1]])

    reasons, near = list[str](), [one for one in verdict.doubts if one.about == "limit"]
    if near:
        tests = [{"load": f"the load {one.load!r}", "published rule": "the published rule"}.get(one.test, one.landing) for one in near]
        several = f"{len(tests)} tests" if len(tests) > 3 else listed(tests)
        side, many = "pass" if verdict.passes else "fail", len(near) > 1
        changes = f"{several} {side if many else f'{side}es' if verdict.passes else f'{side}s'} more closely than the test repeats"
        reasons.append(f"{changes}; another mesh may say otherwise")
    reasons += [f"{one.value:.0f} of {one.of} landings were not dropped, as it grows" for one in verdict.doubts if one.about == "landings"]
    missed = list[str]()
    for one in verdict.doubts:
        if one.about == "relief":
            known = f"between the relief the mesh is {one.value:.0%} thicker than the part"
            missed.append(known if math.isfinite(one.value) else "how thick the mesh is between the relief is not known")
        elif one.about == "base":
            known = f"only {one.value:.0%} of the base is on the floor in the mesh, too"
            missed.append(known if math.isfinite(one.value) else "what of the base is on the floor in the mesh is not known")
        elif one.about == "volume":
            known = f"the volume of the mesh is {one.value:+.1%} off that of the part"
            missed.append(known if math.isfinite(one.value) else "the volume of the mesh is not known")
    if missed:
        reasons.append(f"{listed(missed)}; a lower relief is followed more closely")
    return f"Not sure: {'; '.join(reasons)}." if reasons else ""


# --- its table ----------------------------------------------------------------------------------------------------


def table(verdict: Verdict) -> list[tuple[str, ...]]:
    """The table of tests as text, a row each, under COLUMNS; a dash stands for what is not known."""
    return [
        (
            label(row), "–" if row.plain_permanent_set is None else bend(row.plain_permanent_set), found(row), allowed(row),
            "–" if row.stress is not None else f"{row.plastic_strain:.1%}", row.outcome,
        )
        for row in verdict.rows
    ]  # fmt: skip


def tabulated(verdict: Verdict) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Headings and rows of the table of tests; a part that is tested by itself has one column of figures."""
    rows = table(verdict)
    if any(row.plain_permanent_set is not None for row in verdict.rows):
        return COLUMNS, rows
    headings = tuple({"styled": "stays bent"}.get(name, name) for name in COLUMNS if name != "plain")
    return headings, [(row[0], *row[2:]) for row in rows]


def in_full(verdict: Verdict) -> str:
    """How a part is judged, the outcome, every figure of the table and the doubt, a line each."""
    headings, rows = tabulated(verdict)
    lines = [f"{row[0]}: {', '.join(f'{name} {cell}' for name, cell in zip(headings[1:], row[1:], strict=True))}" for row in rows]
    return "\n".join(filter(None, (" ".join(EXPLANATION), head(verdict), *lines, doubt(verdict))))


def stays_bent(verdict: Verdict) -> dict[str, str]:
    """What stays bent in each test, by the name of the test."""
    return {label(row): found(row) for row in verdict.rows}


def paired(styled: Sequence[Verdict]) -> list[tuple[str, ...]]:
    """The tests of several runs of one part, a row each: test, the plain part, each run, and what is allowed."""
    tests = dict.fromkeys((row.landing, row.load) for verdict in styled for row in verdict.rows)
    lines = []
    for landing, load in tests:
        rows = [verdict.row(landing=landing, load=load) for verdict in styled]
        there = [row for row in rows if row is not None]
        plain = next((bend(row.plain_permanent_set) for row in there if row.plain_permanent_set is not None), "–")
        cells = ("–" if row is None else f"{found(row)} {row.outcome}" for row in rows)
        lines.append((label(there[0]), plain, *cells, allowed(there[0])))
    return lines


def label(row: Row) -> str:
    """A test as a table names it."""
    return f"load {row.load}" if row.load else "published rule" if row.test == "published rule" else row.landing


def found(row: Row) -> str:
    """What a test found, in a cell."""
    if row.stress is not None:
        return f"{row.stress:.1f} MPa"
    return "gives way" if row.collapses else bend(row.permanent_set, _digits(row)) + (", cracks" if row.cracks else "")


def allowed(row: Row) -> str:
    """What a test allows, in a cell."""
    return f"{row.limit:.1f} MPa" if row.limit is not None else bend(row.allowed, _digits(row))


# --- before a run -------------------------------------------------------------------------------------------------


def planned(height: float, falls: int, seconds: float) -> str:
    """The test of a run that has not begun, and how long it will take [s]."""
    return f"We let it fall from {written(height)}, in simulation, about {falls} times: about {duration(_rounded(seconds))}."


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
    """What stays bent of plain and styled part in the worst test, "" where there is none."""
    row = verdict.deciding
    if row is None:
        return ""
    plain = "" if row.plain_permanent_set is None else f"plain {bend(row.plain_permanent_set)}, {verdict.style or 'styled'} "
    return f"{label(row)}: {plain}{found(row)}"


def carried(row: Row) -> str:
    """How much of a load the part carries, "" for a landing."""
    if row.carries is None:
        return ""
    return f"it carries {'at least ' if row.most_tried else ''}{row.carries:.2f} times the load {row.load!r}"


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
        return f"{alike}Largest stress: {names[0]} {found(first)}, {names[1]} {found(second)}; {allowed(first)} is allowed."
    where = _landed(first)
    each = ("gives way" if row.collapses else f"stays bent by {found(row)}" for row in (first, second))
    compared = f"{' and '.join(f'{name} {does}' for name, does in zip(names, each, strict=True))}, {where}"
    if abs(second.permanent_set - first.permanent_set) <= SAME and not any(row.cracks or row.collapses for row in (first, second)):
        compared = f"Of both {found(first)} stays bent, {where}"
    return f"{alike}{compared}; {allowed(first)} is allowed."


def little_left(kept: float, side: str) -> str:
    """What to try where little of a relief is left, "" where enough is left or it only goes outwards."""
    if kept >= LITTLE or side == "outwards":
        return ""
    return f"only {kept:.0%} of the style is left: cuts into a wall weaken it, so try relief that only goes outwards (--side outwards)"


def least_left(lane: str, verdict: Verdict, there: Mapping[str, str]) -> str:
    """What a mark at the worst place says; `there` are the figures of each lane at that place."""
    known = ", ".join(f"{name} {figure}" for name, figure in there.items())
    worst = "is loaded" if verdict.criterion == "paper" else "stays bent"
    return f"✕ marks where {lane} {worst} most ({least(verdict)}); there, each in its worst test: {known}."


def note(verdict: Verdict) -> str:
    """The outcome in a few words, and the figures of the test that decides: a line under a picture of that test."""
    row = verdict.deciding
    return "UNKNOWN: this test gave no answer" if row is None else f"{marked(short(verdict), sure=verdict.sure)}; {figures(row)}"


def figures(row: Row) -> str:
    """What a test found and what it allows."""
    return f"{label(row)}: {found(row)} of {allowed(row)}"
