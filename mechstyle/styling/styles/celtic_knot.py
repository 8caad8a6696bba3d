"""Celtic knotwork: bands that pass over and under each other and turn back without an end."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, smoothstep
from mechstyle.styling.style import Relief, Style

CELL, BAND = 46.0, 0.32  # a cell holds eight crossings; width of a band over the distance of crossings along it


def celtic_knot(canvas: Canvas) -> Relief:
    """Slanting bands that weave; at some crossings they are cut and joined to arcs instead, which closes them to knots."""
    unit = canvas.unit("bands of the knot", 0.35 * BAND * CELL, edges=2.2)
    bond = canvas.bond(CELL * unit, CELL * unit, shift=0.0)
    rise, fall = 2.0 * (bond.x + bond.y), 2.0 * (bond.x - bond.y)
    a, b = rise - np.round(rise), fall - np.round(fall)
    x, y = 0.5 * (np.round(rise) + np.round(fall)), 0.5 * (np.round(rise) - np.round(fall))
    # The crossing in the middle of a cell's upper side turns bands back up and down, the one in the middle of its flank sideways.
    level, upright = (x == 0.0) & (np.abs(y) == 1.0), (np.abs(x) == 1.0) & (y == 0.0)
    arc_level = np.minimum(np.abs(np.hypot(a - 0.5, b + 0.5) - 0.5), np.abs(np.hypot(a + 0.5, b - 0.5) - 0.5))
    arc_upright = np.minimum(np.abs(np.hypot(a - 0.5, b - 0.5) - 0.5), np.abs(np.hypot(a + 0.5, b + 0.5) - 0.5))
    rising_over = np.mod(np.round(2.0 * x), 2.0) == 0.0
    over = np.where(rising_over, np.abs(a), np.abs(b))
    under = np.where(rising_over, np.abs(b), np.abs(a))
    turned = level | upright
    over = np.where(level, arc_level, np.where(upright, arc_upright, over))
    along = np.where(turned, 0.5, under)  # distance from the crossing along the upper band
    top = smoothstep(0.5 * BAND + 0.04, 0.5 * BAND - 0.04, over)
    dive = smoothstep(0.5 * BAND + 0.05, 0.5 * BAND + 0.20, over)
    low = smoothstep(0.5 * BAND + 0.04, 0.5 * BAND - 0.04, under) * ~turned
    furrow = smoothstep(0.05, 0.0, np.where(top > 0.5, over, under))
    lift = np.where(top > 0.0, top * (1.65 + 0.35 * smoothstep(0.5, 0.0, along)), 0.0)
    lift = np.maximum(lift, low * (0.55 + 1.10 * dive)) - 0.35 * furrow * np.maximum(top, low)
    patina = canvas.noise(30.0 * unit, 3, "patina")
    ground = ramp(["0f2a22", "1c4a3a", "2f6b54"], np.clip(0.5 + 0.5 * patina, 0.0, 1.0))
    gold = canvas.painted(ramp(["7a5a1c", "b88d34", "e2c067", "f6e6b0"], np.clip(0.05 + 0.45 * lift + 0.15 * patina, 0.0, 1.0)))
    return Relief(canvas.softened(-1.0 + lift + 0.05 * patina), canvas.softened(mix(ground, gold, np.maximum(top, low))))


STYLE = Style(
    name="celtic_knot",
    words=("celtic", "celt", "knot", "knotwork", "interlace", "interlaced", "viking"),
    description="golden bands that pass over and under each other and turn back without an end",
    feature_mm=0.3 * CELL,
    program=celtic_knot,
)
