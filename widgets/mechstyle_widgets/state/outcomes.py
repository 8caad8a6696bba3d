"""Looks of the outcomes: colour, shape and word wherever one is shown; green, amber and red mean nothing else."""

from __future__ import annotations

from typing import NamedTuple


class Look(NamedTuple):
    """Look of an outcome: a letter of its shape, the shape as plotly calls it, and three colours.

    They are those of a mark on the ground of either theme (3:1 at least), of a badge, and of words on the badge (4.5:1 at least).
    """

    mark: str
    symbol: str
    line: str
    fill: str
    ink: str


UNTESTED = Look("◆", "diamond", "#7d8188", "#5f6368", "#ffffff")
"""Look of no test, and of the test of another iteration."""
LOOKS = {
    "HOLDS": Look("●", "circle", "#2a8a52", "#1b6e3c", "#ffffff"),
    "NO WORSE": Look("■", "square", "#6b8e23", "#cfe3a6", "#1f2d05"),
    "FAILS": Look("✕", "x", "#d1453b", "#b3261e", "#ffffff"),
    "UNKNOWN": Look("▲", "triangle-up", "#b67a0c", "#f5b82e", "#1a1a1a"),
}
"""By the outcome of a verdict."""
DOUBT = LOOKS["UNKNOWN"].line
"""Colour around an outcome that is not sure."""
