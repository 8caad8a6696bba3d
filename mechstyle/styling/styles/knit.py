"""Stockinette: columns of long, slanting stitches in thick wool."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import ramp
from mechstyle.styling.drawing.tilings import dome
from mechstyle.styling.style import Relief, Style

LENGTH, HEIGHT = 13.0, 8.5
LEG, YARN, LEAN = 13.5, 6.4, np.radians(30.0)


def knit(canvas: Canvas) -> Relief:
    """Each stitch a V of two legs whose foot dips into the stitch below, stacked into columns with a furrow between."""
    unit = canvas.unit("strands of wool", YARN, edges=3.0)
    bond = canvas.bond(LENGTH * unit, HEIGHT * unit, shift=0.0, grip=0.6)
    x, y = np.abs(bond.x) * LENGTH - 0.24 * LENGTH, bond.y * HEIGHT
    # Legs are longer than a row is high: each comes out of the stitch below, whose head shows on both sides of it.
    legs = []
    for row in (-1.0, 0.0, 1.0):
        along = x * np.sin(LEAN) + (y - row * HEIGHT) * np.cos(LEAN)
        across = x * np.cos(LEAN) - (y - row * HEIGHT) * np.sin(LEAN)
        # It comes out from under the stitch below and lies on the foot of the one above.
        legs.append(dome(np.hypot(2.0 * along / LEG, 2.0 * across / YARN)) * (0.85 + 0.30 * np.clip(2.0 * along / LEG, -1.0, 1.0)))
    furrow = np.exp(-(((0.5 - np.abs(bond.x)) * LENGTH / 1.7) ** 2))
    fluff = canvas.noise(6.0 * unit, 2, "fluff")
    heather = canvas.noise(40.0 * unit, 2, "heather")
    lift = np.max(legs, axis=0) * (1.0 - 0.55 * furrow)
    tone = np.clip(0.02 + 0.85 * lift + 0.12 * fluff + 0.06 * heather, 0.0, 1.0)
    colour = canvas.painted(ramp(["6b5a44", "a8947a", "d8c9b0", "f4ecdc"], tone))
    return Relief(canvas.softened(-1.1 + 2.2 * lift + 0.06 * fluff), canvas.softened(colour))


STYLE = Style(
    name="knit",
    description="columns of slanting stitches in thick, pale wool",
    feature_mm=LENGTH,
    program=knit,
)
