"""A square lattice of raised bars around deep pockets, as on a waffle."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import ramp, smoothstep
from mechstyle.styling.style import Relief, Style

PITCH, BAR = 13.0, 4.4


def grid(canvas: Canvas) -> Relief:
    """Bars of one width, level and upright, with hollows between."""
    unit = canvas.unit("bars", BAR, edges=2.2)
    bond = canvas.bond(PITCH * unit, PITCH * unit, shift=0.0)
    away = (0.5 - np.maximum(np.abs(bond.x), np.abs(bond.y))) * PITCH
    bar = smoothstep(0.68 * BAR, 0.32 * BAR, away)
    baked = canvas.noise(30.0 * unit, 3, "baked")
    crust = ramp(["8f5423", "bf7d36", "dfae62", "f3d79b"], np.clip(0.30 + 0.55 * bar + 0.25 * baked, 0.0, 1.0))
    deep = smoothstep(0.3 * BAR, 0.5 * PITCH, away)
    return Relief(canvas.softened(-0.75 + 1.75 * bar - 0.30 * deep + 0.06 * baked), canvas.softened(canvas.painted(crust)))


STYLE = Style(
    name="grid",
    description="a square lattice of raised bars around pockets, like a waffle",
    feature_mm=PITCH,
    program=grid,
)
