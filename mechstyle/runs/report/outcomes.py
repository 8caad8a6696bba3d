"""How an outcome looks in a report: its class, its mark and its badge, which differ in grey as well."""

from __future__ import annotations

from mechstyle.records import sentences
from mechstyle.runs.report.markup import Markup, fill, joined

SHAPES = {
    "HOLDS": '<circle r="6"/>',
    "NO WORSE": '<path d="M0-7 7 6-7 6Z"/>',
    "FAILS": '<path d="M-6-6 6 6M-6 6 6-6"/>',
    "UNKNOWN": '<path d="M0-7 7 0 0 7-7 0Z"/>',
}
"""A mark for each outcome: known by its shape, and only then by its colour."""

RING = '<circle class="doubt" r="10"/>'
"""Around the mark of an outcome that is not sure."""


def kind(outcome: str) -> str:
    """The class of an outcome in the style sheet."""
    return outcome.lower().replace(" ", "-")


def mark(outcome: str, *, sure: bool) -> Markup:
    """The shape of an outcome, in a ring if it is not sure."""
    return Markup(SHAPES[outcome] + ("" if sure or outcome == "UNKNOWN" else RING))


def badge(outcome: str, *, sure: bool = True) -> Markup:
    """An outcome in its colour, and in amber that it is not sure."""
    doubt = sentences.marked(outcome, sure=sure).removeprefix(outcome)
    more = fill('<span class="unknown">{doubt}</span>', doubt=doubt) if doubt else ""
    return fill('<span class="{kind}">{outcome}</span>{more}', kind=kind(outcome), outcome=outcome, more=more)


def legend() -> Markup:
    """Every mark with its outcome."""
    shown = [(kind(outcome), Markup(shape), outcome) for outcome, shape in SHAPES.items()]
    shown.append(("unknown", Markup(RING), sentences.NOT_SURE.strip("()")))
    return joined(
        fill('<svg viewBox="-11 -11 22 22" class="mark {kind}">{shape}</svg> {word}', kind=name, shape=shape, word=word)
        for name, shape, word in shown
    )
