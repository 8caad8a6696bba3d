"""Every sentence about a verdict, in one place: the head, the table, the doubt and the explanation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from mechstyle.records.written import written

if TYPE_CHECKING:
    from mechstyle.records.verdict import Doubt, Row, Verdict

COLUMNS = ("test", "plain", "styled", "allowed", "strain", "outcome")
"""Headings of the table of tests."""

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


def bend(permanent_set: float, digits: int = 0) -> str:
    """A permanent set [mm] as people read it, with so many digits behind the point or more."""
    return "0 mm" if permanent_set < NOTHING else f"{permanent_set:.{max(digits, 2 if permanent_set < 9.95 else 0)}f} mm"


def _digits(row: Row) -> int:
    """Digits behind the point with which what is too much also reads as more than what is allowed."""
    found, allowed = row.permanent_set, row.allowed
    return next((n for n in range(6) if found <= allowed or bend(found, n) != bend(allowed, n)), 6)


def bend_in(row: Row, permanent_set: float) -> str:
    """The same at one place in the test of a row, with as many digits as the row's own figure has."""
    return bend(permanent_set, _digits(row))


def floor(contact_stiffness: float) -> str:
    """The floor of the published method: its stiffness at each node [N/mm], 0 for a rigid one."""
    return f"a penalty floor of {contact_stiffness:g} N/mm a node" if contact_stiffness else "a rigid floor"


def short(verdict: Verdict) -> str:
    """The outcome in a few words."""
    decides = verdict.deciding
    if decides is None or verdict.outcome == "UNKNOWN":
        return verdict.outcome
    if decides.test == "published rule":
        return f"{verdict.outcome} by the published rule"
    if verdict.outcome == "NO WORSE":
        return "NO WORSE than the plain part"
    failed = f"the load {decides.load!r}" if verdict.outcome == "FAILS" and decides.load else ""
    return f"{verdict.outcome} {failed or f'a fall of {written(verdict.fall)}'}"


def title(verdict: Verdict) -> str:
    """The outcome in a few words, and that it is not sure if it is not: what stands over a picture."""
    return marked(short(verdict), sure=verdict.sure)


def head(verdict: Verdict) -> str:
    """The outcome in one sentence: what was asked, the worst that stays bent, where, and in which test."""
    decides = verdict.deciding
    if decides is None or verdict.outcome == "UNKNOWN":
        return f"UNKNOWN: {verdict.failure.rstrip('.')}."
    if decides.stress is not None:  # which the published rule reads
        side = "at most" if decides.outcome == "HOLDS" else "above"
        strength = f"the {verdict.strength:.1f} MPa at which {verdict.material} yields"
        known = f"the largest element stress is {decides.stress:.1f} MPa, {side} {strength}"
        return f"{verdict.outcome} by the published rule: {known}, on {floor(verdict.contact_stiffness)}."
    loads = [row.load for row in verdict.rows if row.load]
    asked = f"a fall of {written(verdict.fall)}"
    if verdict.outcome == "FAILS":
        asked = f"the load {decides.load!r}" if decides.load else asked
    elif loads:
        asked += f" and the load {loads[0]!r}" if len(loads) == 1 else f" and {len(loads)} loads"
    outcome = "NO WORSE than the plain part in" if verdict.outcome == "NO WORSE" else verdict.outcome
    return f"{outcome} {asked}: {_at_worst(decides, verdict)}. {print_meant(verdict)}."


def print_meant(verdict: Verdict) -> str:
    """Material and how the part is printed inside."""
    if verdict.printed == "solid":
        return f"Solid {verdict.material}"
    return f"Printed in {verdict.material}: {verdict.printed}"


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
        return f"it cracks, {landed(row)}, with {strain}, and {bend(row.permanent_set)} stays bent{beside}"
    cracks = f", and it cracks: {strain}" if row.cracks else ""
    at_worst = "at worst " if verdict.outcome == "HOLDS" else ""
    return f"{at_worst}{bend(row.permanent_set, _digits(row))} stays bent{place}, {landed(row)}{beside}{cracks}"


def landed(row: Row) -> str:
    """The test of a row in the middle of a sentence."""
    if row.load:
        return f"under the load {row.load!r}"
    return {"flat": f"landing {row.landing}", "nearly flat": row.landing}.get(row.test, f"in the landing {row.landing!r}")


def doubt(verdict: Verdict) -> str:
    """Why the outcome is not sure and what to do, "" if it is sure."""
    reasons, near = list[str](), [one for one in verdict.doubts if one.about == "limit"]
    if near:
        tests = [{"load": f"the load {one.load!r}", "published rule": "the published rule"}.get(one.test, one.landing) for one in near]
        several, side = f"{len(tests)} tests" if len(tests) > 3 else _listed(tests), "pass" if verdict.passes else "fail"
        side += "" if len(near) > 1 else "es" if verdict.passes else "s"
        reasons.append(f"{several} {side} more closely than the test repeats; another mesh may say otherwise")
    reasons += [f"{one.value:.0f} of {one.of} landings were not dropped, as it grows" for one in verdict.doubts if one.about == "landings"]
    larger = (one.value for one in verdict.doubts if one.about == "pattern")
    reasons += [f"the pattern is {times:.1f} times larger than asked; with more vertices the part may bend more" for times in larger]
    missed = list(filter(None, map(_missed, verdict.doubts)))
    if missed:
        reasons.append(f"{_listed(missed)}; a lower relief is followed more closely")
    return f"Not sure: {'; '.join(reasons)}." if reasons else ""


def _listed(words: Sequence[str]) -> str:
    return " and ".join([*([", ".join(words[:-1])] if len(words) > 1 else []), words[-1]])


def _missed(one: Doubt) -> str:
    """What the mesh has not of the part, "" for another doubt."""
    known, what = {
        "relief": (f"between the relief the mesh is {one.value:.0%} thicker than the part", "how thick the mesh is between the relief"),
        "base": (f"only {one.value:.0%} of the base is on the floor in the mesh, too", "what of the base is on the floor in the mesh"),
        "volume": (f"the volume of the mesh is {one.value:+.1%} off that of the part", "the volume of the mesh"),
    }.get(one.about, ("", ""))
    return known if math.isfinite(one.value) else what and f"{what} is not known"


def worst_of_each(verdict: Verdict) -> list[tuple[Row, int]]:
    """The worst row of each kind of landing with the number of rows of that kind, and every load."""
    kinds: dict[tuple[str, str], list[Row]] = {}
    for row in verdict.rows:
        kinds.setdefault((row.test, row.load), []).append(row)
    return [(max(rows, key=lambda row: row.severity), len(rows)) for rows in kinds.values()]


def tabulated(verdict: Verdict, *, briefly: bool = False) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Headings and rows of the table of tests as text; a dash stands for what is not known.

    A part that is tested by itself has one column of figures: what stays bent, by the published rule the largest stress. Briefly, each kind
    of landing has one row, its worst.
    """
    shown = worst_of_each(verdict) if briefly else [(row, 1) for row in verdict.rows]
    rows: list[tuple[str, ...]] = [
        (
            f"{row.test}, worst of {many}" if many > 1 else label(row),
            "–" if row.plain_permanent_set is None else bend(row.plain_permanent_set), found(row), allowed(row),
            "–" if row.stress is not None else f"{row.plastic_strain:.1%}", row.outcome,
        )
        for row, many in shown
    ]  # fmt: skip
    if any(row.plain_permanent_set is not None for row in verdict.rows):
        return COLUMNS, rows
    figure = "largest stress" if any(row.stress is not None for row in verdict.rows) else "stays bent"
    return ("test", figure, *COLUMNS[3:]), [(row[0], *row[2:]) for row in rows]


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


def marked(outcome: str, *, sure: bool) -> str:
    """An outcome, with NOT_SURE if it leaves a doubt."""
    return outcome if sure or outcome.startswith("UNKNOWN") else f"{outcome} {NOT_SURE}"


def untested(since: int | None) -> str:
    """What stands for the outcome of a surface that was not tested; `since` is the iteration of the last test before, None for none."""
    return f"{NOT_TESTED} since iteration {since}" if since else NOT_TESTED


def least(verdict: Verdict) -> str:
    """What stays bent of plain and styled part in the worst test, "" where there is none."""
    if (row := verdict.deciding) is None:
        return ""
    plain = "" if row.plain_permanent_set is None else f"plain {bend(row.plain_permanent_set)}, {verdict.style or 'styled'} "
    return f"{label(row)}: {plain}{found(row)}"


def note(verdict: Verdict) -> str:
    """The outcome in a few words, and the figures of the test that decides: a line under a picture of that test."""
    row = verdict.deciding
    return "UNKNOWN: this test gave no answer" if row is None else f"{title(verdict)}; {figures(row)}"


def figures(row: Row) -> str:
    """What a test found and what it allows."""
    value, comma, more = found(row).partition(", ")
    return f"{label(row)}: {value} of {allowed(row)}{comma}{more}"
