"""The timeline as SVG: what stays bent at each simulation and what may, and below it how much of the surface is held back."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

from mechstyle.loop.history import Step
from mechstyle.records import sentences
from mechstyle.runs.report.markup import Markup, fill, joined, kind, mark

WIDTH, HEIGHT = 960, 330
LEFT, RIGHT = 62, 944
BEND_TOP, BEND_BOTTOM = 34, 204
HELD_TOP, HELD_BOTTOM = 244, 296
NAME = (96, 14)
"""Width and height of the name of the limit, at most."""
OVER, UNDER = -7, 16
"""Where its letters stand over and under the line."""
HIGHEST = 5.0
"""Most that the axis reaches over what is allowed: what lies above it is drawn at the top."""
REACH, ROOM = 11.0, 3.0
"""How far a mark reaches with its ring, and what is to be free between the name and whatever is drawn."""


def timeline(tests: Sequence[Step], last: int) -> Markup:
    """The chart of a lane that stands at iteration `last`, of at least one simulation; marks carry `data-iteration` for the script."""
    span = max(last, 1)
    most = max(_allowed(step) for step in tests)
    top = 1.12 * max(most, min(max(_found(step) for step in tests), HIGHEST * most))
    published = any(step.verdict.deciding is not None and step.verdict.deciding.stress is not None for step in tests)
    unit = "MPa" if published else "mm"
    x = {step.iteration: LEFT + (RIGHT - LEFT) * step.iteration / span for step in tests}

    def height(value: float) -> float:
        return BEND_BOTTOM - (BEND_BOTTOM - BEND_TOP) * min(value / top, 1.0)

    known = [step for step in tests if step.verdict.outcome != "UNKNOWN"]
    line = [(x[step.iteration], height(_found(step))) for step in known]
    peaks = " ".join(f"{right:.1f},{down:.1f}" for right, down in line)
    limit = _allowed(tests[-1])
    allowed = f"M{LEFT} {height(_allowed(tests[0])):.1f}"
    allowed += "".join(f"H{x[step.iteration]:.1f}V{height(_allowed(step)):.1f}" for step in tests)
    marks = []
    for step in tests:
        figures = "" if step.verdict.deciding is None else f", {sentences.figures(step.verdict.deciding)}"
        words = f"iteration {step.iteration}: {sentences.marked(step.outcome, sure=step.verdict.sure)}{figures}; {step.reason}"
        marks.append(
            fill(
                '<g class="mark {kind}" transform="translate({x} {y})" data-iteration="{iteration}"'
                ' role="button" tabindex="0" aria-label="{words}">'
                '<title>{words}</title><circle class="reach" r="14"/>{shape}</g>',
                kind=kind(step.outcome), x=f"{x[step.iteration]:.1f}", y=f"{height(_found(step)):.1f}", iteration=step.iteration,
                words=words, shape=mark(step.outcome, sure=step.verdict.sure),
            )
        )  # fmt: skip
    beside, name = _free_place(height(limit), line, [(x[step.iteration], height(_found(step))) for step in tests])
    return fill(
        '<svg class="timeline" viewBox="0 0 {width} {height}" role="group" tabindex="0"'
        ' data-left="{left}" data-right="{right}" data-last="{last}"'
        ' aria-label="Timeline: what stays bent and what is held back at each simulation. Arrow keys move the replay.">'
        '{axes}<path class="limit" d="{allowed}H{right}"/>'
        '<text class="limit-name" x="{beside}" y="{name}" text-anchor="end">allowed {limit} {unit}</text>'
        '{held}<polyline class="peaks" points="{peaks}"/>{marks}'
        '<g class="cursor"><line y1="{top}" y2="{bottom}"/></g></svg>',
        width=WIDTH, height=HEIGHT, left=LEFT, right=RIGHT, last=span,
        beside=beside, allowed=allowed, name=f"{name:.1f}",
        limit=f"{limit:.1f}" if unit == "MPa" else f"{limit:.2f}", unit=unit, peaks=peaks, axes=_axes(span, top, unit),
        held=_held(tests, x, RIGHT if last else LEFT),
        marks=joined(marks),
        top=BEND_TOP - 8, bottom=HELD_BOTTOM,
    )  # fmt: skip


def ticks(top: float, about: int) -> Iterator[float]:
    """Round numbers from 0 to `top`, about so many, in steps of 1, 2 or 5 times a power of ten."""
    rough = top / about
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= rough * (1 - 1e-9))
    for k in range(int(top / step + 1e-9) + 1):
        yield k * step


def _free_place(limit: float, line: Sequence[tuple[float, float]], marks: Sequence[tuple[float, float]]) -> tuple[int, float]:
    """Where the name of a limit ends and stands: as far to the right as neither line nor marks are in its way, else where most is free."""
    drawn = [(x, y, REACH) for x, y in marks]
    for (x, y), (right, down) in itertools.pairwise(line):  # and places on the line, a few units apart
        count = 1 + int(math.hypot(right - x, down - y) / 3)
        drawn += [(x + (right - x) * k / count, y + (down - y) * k / count, 0.0) for k in range(count + 1)]
    best, most = (RIGHT - 10, limit + OVER), -math.inf
    for right in range(RIGHT - 10, LEFT + 10 + NAME[0], -10):
        for base in (limit + OVER, limit + UNDER):
            free = min((_distance(x, y, right, base) - reach for x, y, reach in drawn), default=math.inf)
            if free > most and base <= BEND_BOTTOM:
                best, most = (right, base), free
            if most >= ROOM:
                return best
    return best


def _distance(x: float, y: float, right: float, base: float) -> float:
    """From a place to the name that ends at `right` and stands on `base`, along the axis where it is farther; 0 within it."""
    return max(right - NAME[0] - x, x - right, base + 3 - NAME[1] - y, y - base - 3, 0.0)


def _found(step: Step) -> float:
    """What stays bent in the worst test [mm], its stress [MPa] by the published rule, 0 without an answer."""
    worst = step.verdict.deciding
    return 0.0 if worst is None else worst.permanent_set if worst.stress is None else worst.stress


def _allowed(step: Step) -> float:
    """What may be there, the tolerance or the yield strength without an answer."""
    verdict, worst = step.verdict, step.verdict.deciding
    if worst is None:
        return verdict.strength if verdict.criterion == "paper" else verdict.tolerance or 1.0
    return worst.allowed if worst.limit is None else worst.limit


def _axes(span: int, top: float, unit: str) -> Markup:
    """Names, round numbers and faint lines."""
    name = "what stays bent in the worst test [mm]" if unit == "mm" else "largest stress in an element [MPa]"
    parts = [
        fill('<text class="axis" x="{x}" y="{y}">{name}</text>', x=4, y=y, name=name)
        for y, name in ((BEND_TOP - 16, name), (HELD_TOP - 12, "vertices held back"))
    ]
    parts += [_rung(BEND_BOTTOM - (BEND_BOTTOM - BEND_TOP) * value / top, f"{value:g}") for value in ticks(top, 4)]
    parts += [_rung(HELD_BOTTOM, "0 %"), _rung(HELD_TOP, "100 %")]
    template = '<text x="{x:.1f}" y="{y}" text-anchor="middle">{name:g}</text>'
    whole = (value for value in ticks(span, 10) if value == int(value))
    parts += [Markup(template.format(x=LEFT + (RIGHT - LEFT) * value / span, y=HELD_BOTTOM + 20, name=value)) for value in whole]
    return joined(parts)


def _rung(y: float, name: str) -> Markup:
    return fill(
        '<line class="rung" x1="{left}" x2="{right}" y1="{y}" y2="{y}"/><text x="{beside}" y="{middle}" text-anchor="end">{name}</text>',
        left=LEFT, right=RIGHT, y=f"{y:.1f}", beside=LEFT - 10, middle=f"{y + 4:.1f}", name=name,
    )  # fmt: skip


def _held(tests: Sequence[Step], x: dict[int, float], end: float) -> Markup:
    """The share held back as a staircase: it changes at simulations only."""
    path = f"M{LEFT} {HELD_BOTTOM}"
    for step in tests:
        path += f"H{x[step.iteration]:.1f}V{HELD_BOTTOM - (HELD_BOTTOM - HELD_TOP) * step.share:.1f}"
    return fill('<path class="held" d="{path}"/>', path=f"{path}H{end}V{HELD_BOTTOM}Z")
