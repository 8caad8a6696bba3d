"""Flat strips woven over and under each other."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

STRIP, GAP = 11.0, 2.4
UPRIGHT = 0.40  # width of an upright over the length of a cell


def basket_weave(canvas: Canvas) -> Relief:
    """Plain weave: level strips pass over every second upright, those of the next row over the others."""
    unit = canvas.unit("gaps between strips", GAP, edges=1.3)
    # A cell is two uprights wide: in its middle the level strip is over, at its ends the upright is.
    bond = canvas.bond(2.0 * STRIP * unit, STRIP * unit, grip=0.6)
    over = np.abs(bond.x) < 0.5 - 0.5 * UPRIGHT
    aside, up = np.where(over, 0.5 * np.abs(bond.x) / (0.5 - 0.5 * UPRIGHT), (0.5 - np.abs(bond.x)) / UPRIGHT), np.abs(bond.y)
    along, across = np.where(over, aside, up), np.where(over, up, aside)
    width = np.where(over, STRIP, 2.0 * UPRIGHT * STRIP)
    # The strip on top bulges and dives under at both ends; beside it shows a gap.
    strip = smoothstep(0.0, GAP, (0.5 - across) * width)
    arch = np.cos(np.pi * along)
    split = np.cos(4.0 * np.pi * across) * over
    identity = canvas.pieces(strip > 0.3, over)
    own, fibre = canvas.random(identity, "tone") - 0.5, canvas.noise(5.0 * unit, 2, "fibre")
    top = -0.40 + 1.05 * arch + 0.15 * strip - 0.14 * split + 0.10 * own + 0.06 * fibre
    tone = np.clip(0.22 + 0.25 * over + 0.30 * arch + 0.26 * own + 0.20 * fibre - 0.10 * split, 0.0, 1.0)
    reed = canvas.painted(ramp(["6b4420", "a3713a", "cfa161", "e8cb96"], tone))
    colour = mix(rgb("3a2411"), reed, strip)
    return Relief(canvas.softened(-0.95 + (0.95 + top) * strip), canvas.softened(colour))


STYLE = Style(
    name="basket_weave",
    description="flat strips woven over and under each other like a basket",
    feature_mm=STRIP,
    program=basket_weave,
)
