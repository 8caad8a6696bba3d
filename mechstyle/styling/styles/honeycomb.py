"""Hexagonal cells of wax, some of them full of honey, some capped."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, smoothstep
from mechstyle.styling.style import Relief, Style

CELL, WALL = 15.0, 3.6
ROW = 0.5 * 3.0**0.5 * CELL


def honeycomb(canvas: Canvas) -> Relief:
    """Regular hexagons in staggered rows: raised walls around hollow, filled or capped cells."""
    unit = canvas.unit("walls of wax", WALL)
    bond = canvas.bond(CELL * unit, ROW * unit, grip=0.6)
    x, y = np.abs(bond.x) * CELL, np.abs(bond.y) * ROW
    # A place beyond the slanting border belongs to the cell of the next row, half a cell aside.
    beyond = 0.5 * x + y * ROW / CELL > 0.5 * CELL
    x, y = np.where(beyond, 0.5 * CELL - x, x), np.where(beyond, ROW - y, y)
    border = np.minimum(0.5 * CELL - x, 0.5 * CELL - (0.5 * x + y * ROW / CELL))
    wall = smoothstep(0.85 * WALL, 0.25 * WALL, border)
    identity = canvas.pieces(border > 0.2 * WALL, bond.odd ^ beyond)
    kind, tone = canvas.random(identity, "kind"), canvas.random(identity, "tone")
    capped, full = smoothstep(0.74, 0.76, kind), smoothstep(0.34, 0.36, kind)
    wax = canvas.noise(7.0 * unit, 3, "wax")
    deep = smoothstep(0.5 * WALL, 0.45 * CELL, border)
    honey = ramp(["5a2604", "9a4c08", "d68212", "f0ae2c"], np.clip(0.15 + 0.40 * full + 0.30 * tone - 0.25 * deep * (1.0 - full), 0.0, 1.0))
    cap = ramp(["b98436", "d6a957", "e6c480"], np.clip(0.5 + 0.5 * (tone - 0.5) + 0.45 * wax, 0.0, 1.0))
    rim = ramp(["e0ac48", "f6d47c", "fff0bc"], np.clip(0.5 + 0.6 * wax, 0.0, 1.0))
    floor = -0.90 + 0.45 * full + capped * (0.55 + 0.35 * deep + 0.20 * wax)
    height = floor + wall * (0.85 + 0.10 * wax - floor)
    colour = mix(mix(honey, cap, capped), rim, wall)
    return Relief(canvas.softened(height), canvas.softened(canvas.painted(colour)))


STYLE = Style(
    name="honeycomb",
    description="hexagonal cells of wax, hollow, full of honey or capped",
    feature_mm=CELL,
    program=honeycomb,
)
