"""Celtic knotwork: bands that pass over and under each other and turn back without an end."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Bond, Canvas
from mechstyle.styling.drawing.colours import mix, ramp, smoothstep
from mechstyle.styling.style import Relief, Style

CELL, BAND = 46.0, 0.32  # a cell holds eight crossings; width of a band over the distance of crossings along it


def celtic_knot(canvas: Canvas) -> Relief:
    """Slanting bands with a furrow along their middle, the lower one diving under the upper one where they cross."""
    unit = canvas.unit("bands of the knot", 0.35 * BAND * CELL, edges=2.2)
    over, under, away = woven(canvas.bond(CELL * unit, CELL * unit, shift=0.0))
    top, low = (smoothstep(0.5 * BAND + 0.04, 0.5 * BAND - 0.04, aside) for aside in (over, under))
    dive = smoothstep(0.5 * BAND + 0.20, 0.5 * BAND + 0.05, over)
    furrow = smoothstep(0.05, 0.0, np.where(top > 0.5, over, under))
    band = np.maximum(top, low)
    arch = top * (1.65 + 0.35 * smoothstep(0.5, 0.0, away))
    lift = np.maximum(arch, low * (1.65 - 1.10 * dive)) - 0.35 * furrow * band
    patina = canvas.noise(30.0 * unit, 3, "patina")
    ground = ramp(["0f2a22", "1c4a3a", "2f6b54"], np.clip(0.5 + 0.5 * patina, 0.0, 1.0))
    gold = canvas.painted(ramp(["7a5a1c", "b88d34", "e2c067", "f6e6b0"], np.clip(0.05 + 0.45 * lift + 0.15 * patina, 0.0, 1.0)))
    return Relief(canvas.softened(-1.0 + lift + 0.05 * patina), canvas.softened(mix(ground, gold, band)))


def woven(bond: Bond) -> tuple[Floats, Floats, Floats]:
    """Two sets of slanting bands, eight crossings a cell; at two of these they are cut and joined to arcs, which closes them to knots.

    Returns:
        Distance from the middle of the upper band, from that of the lower one (infinite where bands turn), and along the upper band
        from the middle of their crossing, over the distance of crossings, shape [n] each.
    """
    rise, fall = 2.0 * (bond.x + bond.y), 2.0 * (bond.x - bond.y)
    a, b = rise - np.round(rise), fall - np.round(fall)
    x, y = 0.5 * (np.round(rise) + np.round(fall)), 0.5 * (np.round(rise) - np.round(fall))  # of the crossing, in half cells
    odd = np.mod(np.round(2.0 * x), 2.0) == 1.0
    over, under = np.where(odd, np.abs(b), np.abs(a)), np.where(odd, np.abs(a), np.abs(b))
    # In the middle of a cell's upper side bands are turned back upwards and downwards, in the middle of its flank to the sides.
    level, upright = (x == 0.0) & (np.abs(y) == 1.0), (np.abs(x) == 1.0) & (y == 0.0)
    over, under = np.where(level, _arcs(a, -b), np.where(upright, _arcs(a, b), over)), np.where(level | upright, np.inf, under)
    return over, under, np.minimum(under, 0.5)


def _arcs(a: Floats, b: Floats) -> Floats:
    """Distance from two quarter circles of radius ½ around opposite corners of the square from -½ to ½."""
    return np.asarray(np.minimum(np.abs(np.hypot(a - 0.5, b - 0.5) - 0.5), np.abs(np.hypot(a + 0.5, b + 0.5) - 0.5)))


STYLE = Style(
    name="celtic_knot",
    description="golden bands that pass over and under each other and turn back without an end",
    feature_mm=0.3 * CELL,
    program=celtic_knot,
)
