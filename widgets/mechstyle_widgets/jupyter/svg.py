"""Tiny plots as inline SVG: drawn at once, in the colours of the notebook's theme, readable by a screen reader."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import ArrayLike

from mechstyle_widgets.jupyter.language import said

INK = "var(--jp-ui-font-color1, #333)"
FAINT = "var(--jp-ui-font-color2, #666)"
RULE = "var(--jp-border-color1, #bbb)"
ACCENT = "var(--jp-brand-color1, #1565c0)"
LETTER = 5.2  # width of a letter of the small print, on average [pixels]
OTHER = "#d55e00"  # vermilion of Okabe and Ito, not the accent to the colour-blind; it is dashed or hollow besides


@dataclass(frozen=True)
class Frame:
    """Frame of a drawing: from data, `low` to `high` across and 0 to `top` up, to pixels inside its margins."""

    low: float
    high: float
    top: float = 1.0
    width: int = 264
    height: int = 112
    left: int = 26
    above: int = 14
    right: int = 10
    below: int = 28

    @property
    def floor(self) -> float:
        """Position of 0, from above [pixels]."""
        return self.height - self.below

    def x(self, value: float) -> float:
        """Place across [pixels]."""
        share = (min(max(value, self.low), self.high) - self.low) / (self.high - self.low)
        return round(self.left + share * (self.width - self.left - self.right), 1)

    def y(self, value: float) -> float:
        """Place down [pixels]."""
        return round(self.floor - min(max(value / self.top, 0.0), 1.0) * (self.floor - self.above), 1)

    def axes(self, label: str, ticks: Sequence[float], upright: Sequence[tuple[float, str]] = ()) -> str:
        """A base line with numbers and a label under it, and marks at the left."""
        marks = "".join(text(self.x(tick), self.floor + 12, f"{tick:.3g}") for tick in ticks)
        sides = "".join(text(self.left - 4, self.y(value) + 3, words, "end") for value, words in upright)
        name = text(self.left + (self.width - self.left - self.right) / 2, self.height - 3, label, colour=FAINT)
        return line(self.left, self.floor, self.width - self.right, self.floor, RULE) + marks + sides + name

    def curve(self, across: ArrayLike, up: ArrayLike) -> str:
        """A filled curve."""
        places = [f"{self.x(a)},{self.y(b)}" for a, b in zip(np.asarray(across), np.asarray(up), strict=True)]
        area = f"{self.x(self.low)},{self.floor} {' '.join(places)} {self.x(self.high)},{self.floor}"
        fill = f'<polygon points="{area}" fill="{ACCENT}" opacity="0.13"/>'
        return fill + f'<polyline points="{" ".join(places)}" fill="none" stroke="{ACCENT}" stroke-width="2"/>'

    def bars(self, heights: ArrayLike, *, hollow: bool = False) -> str:
        """Bars side by side over the whole width; hollow ones may stand in front of full ones."""
        given = np.asarray(heights, dtype=np.float64)
        edges = np.linspace(self.low, self.high, len(given) + 1)
        look = f'fill="none" stroke="{OTHER}" stroke-width="1.5"' if hollow else f'fill="{ACCENT}" opacity="0.45"'
        parts = [
            f'<rect x="{self.x(a) + 0.5:.1f}" y="{self.y(h)}" width="{max(self.x(b) - self.x(a) - 1, 0.5):.1f}" '
            f'height="{self.floor - self.y(h):.1f}" {look}/>'
            for a, b, h in zip(edges[:-1], edges[1:], given, strict=True)
            if h > 0
        ]
        return "".join(parts)

    def mark(self, value: float, words: str = "") -> str:
        """A dashed upright line with words at its head."""
        x, half = self.x(value), 0.5 * LETTER * len(said(words))
        head = text(min(max(x, half + 2), self.width - half - 2), self.above - 4, words, "middle", OTHER)
        return line(x, self.above - 2, x, self.floor, OTHER, "4 3") + head


def drawing(frame: Frame, parts: Sequence[str], description: str) -> str:
    """The parts as one picture that a screen reader tells by its description."""
    size = f'viewBox="0 0 {frame.width} {frame.height}" style="width:100%;max-width:{round(1.3 * frame.width)}px;display:block"'
    return f'<svg role="img" aria-label="{escape(said(description))}" {size} font-family="var(--jp-ui-font-family)">{"".join(parts)}</svg>'


def line(x0: float, y0: float, x1: float, y1: float, colour: str = INK, dashes: str = "") -> str:
    """A thin line."""
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    return f'<line x1="{x0}" y1="{y0}" x2="{x1}" y2="{y1}" stroke="{colour}"{dashed}/>'


def text(x: float, y: float, words: str, anchor: str = "middle", colour: str = INK) -> str:
    """Small print."""
    return f'<text x="{x}" y="{y}" font-size="10" text-anchor="{anchor}" fill="{colour}">{escape(said(words))}</text>'


def shares(values: ArrayLike, low: float, high: float, count: int) -> np.ndarray:
    """Share of the values in each of `count` equal bins from `low` to `high`; what lies outside counts to the nearest, shape [count]."""
    inside = np.clip(np.asarray(values, dtype=np.float64), low, high)
    return np.histogram(inside, bins=count, range=(low, high))[0] / max(inside.size, 1)
