"""Seigaiha: overlapping rounds of waves, each a fan of arcs."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import fans
from mechstyle.styling.style import Relief, Style

RADIUS, ARCS = 18.0, 3


def waves(canvas: Canvas) -> Relief:
    """Rows of half rounds, every row in front of the one above it; the arcs of a round are crests, the outermost foams."""
    unit = canvas.unit("arcs of waves", RADIUS / (ARCS + 0.5), edges=2.6)
    bond = canvas.bond(2.0 * RADIUS * unit, 0.5 * RADIUS * unit, grip=0.3)
    here, _ = fans(bond)
    arc = (1.0 - here) * (ARCS + 0.5)
    crest = 0.5 + 0.5 * np.cos(2.0 * np.pi * (arc - 0.5))
    foam = smoothstep(1.0, 0.7, arc)
    swell = canvas.noise(50.0 * unit, 2, "swell")
    spray = canvas.noise(6.0 * unit, 2, "spray")
    tone = np.clip(0.08 + 0.45 * crest + 0.22 * swell + 0.30 * here * crest, 0.0, 1.0)
    sea = canvas.painted(ramp(["0f2c52", "1c4f82", "3a86b4", "8cc4d8"], tone))
    colour = mix(sea, rgb("f4f2e6"), crest * (0.35 + 0.65 * foam) * (1.0 + 0.15 * spray))
    return Relief(canvas.softened(-0.95 + 1.45 * crest + 0.60 * here + 0.08 * spray), canvas.softened(colour))


STYLE = Style(
    name="waves",
    description="overlapping rounds of waves in blue with crests of foam, as on Japanese cloth",
    feature_mm=RADIUS / ARCS * 1.5,
    program=waves,
)
