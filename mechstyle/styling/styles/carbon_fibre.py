"""Carbon fibre: flat tows in a two-by-two twill under clear resin."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import ramp, smoothstep
from mechstyle.styling.style import Relief, Style

TOW = 7.0


def carbon_fibre(canvas: Canvas) -> Relief:
    """Each tow passes over two and under two, one step further in every row, which gives slanting steps."""
    unit = canvas.unit("tows", TOW, edges=2.6)
    bond = canvas.bond(4.0 * TOW * unit, 4.0 * TOW * unit, shift=0.0)
    x, y = 4.0 * bond.x, 4.0 * bond.y
    column, row = np.floor(x), np.round(y)
    # Four steps of the weave: an upright tow is on top for two rows, of which this is the first or the second.
    step = np.mod(column - row, 4.0)
    upright = (step < 0.5) | (step > 2.5)
    across = np.where(upright, x - column - 0.5, y - row)
    middle = np.where(upright, np.where(step < 0.5, y - row - 0.5, y - row + 0.5), np.where(step < 1.5, x - column - 1.0, x - column))
    arch = np.cos(0.5 * np.pi * np.clip(middle, -1.0, 1.0))
    tow = smoothstep(0.5, 0.36, np.abs(across))
    sheen = canvas.noise(60.0 * unit, 2, "sheen")
    tone = np.clip(0.10 + 0.34 * upright + 0.36 * arch * tow + 0.18 * sheen, 0.0, 1.0)
    colour = ramp(["08090a", "1d1f22", "3c4045", "6d737a"], tone)
    return Relief(canvas.softened(-1.0 + tow * (0.35 + 1.55 * arch) + 0.05 * sheen), canvas.softened(canvas.painted(colour)))


STYLE = Style(
    name="carbon_fibre",
    description="black tows of carbon fibre in a twill with slanting steps",
    feature_mm=2.0 * TOW,
    program=carbon_fibre,
)
