"""A printed circuit board: copper tracks at right angles between solder pads."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

GRID, TRACK = 12.0, 3.8


def circuit(canvas: Canvas) -> Relief:
    """On a square grid every joint is a pad, a plain point or nothing, and tracks run between some neighbours."""
    unit = canvas.unit("tracks", TRACK)
    bond = canvas.bond(GRID * unit, GRID * unit, shift=0.0)
    x, y = bond.x * GRID, bond.y * GRID
    aside, up = np.abs(x), np.abs(y)
    # Around the middle of each side of a cell, the two halves of a track are one piece and so share their chance.
    level = canvas.pieces((up < 0.35 * GRID) & (aside > 0.15 * GRID))
    upright = canvas.pieces((aside < 0.35 * GRID) & (up > 0.15 * GRID))
    joint = canvas.pieces((aside < 0.42 * GRID) & (up < 0.42 * GRID))
    tracks = [
        smoothstep(0.75 * TRACK, 0.30 * TRACK, across) * (canvas.random(piece, salt) < chance) * (along > 0.15 * GRID)
        for across, along, piece, salt, chance in ((up, aside, level, "level", 0.55), (aside, up, upright, "upright", 0.55))
    ]
    middle = smoothstep(0.75 * TRACK, 0.30 * TRACK, np.maximum(aside, up))
    kind = canvas.random(joint, "kind")
    pad = smoothstep(1.15, 0.85, np.hypot(x, y) / (1.05 * TRACK)) * (kind < 0.40)
    hole = smoothstep(0.50, 0.22, np.hypot(x, y) / (1.05 * TRACK)) * (kind < 0.40)
    copper = np.max([*tracks, middle, pad], axis=0)
    mask = canvas.noise(30.0 * unit, 2, "mask")
    board = canvas.painted(ramp(["0a3a22", "0f5230", "1a6b40"], np.clip(0.5 + 0.6 * mask, 0.0, 1.0)))
    gold = ramp(["a87c2c", "d8b154", "f2d98c"], np.clip(0.45 + 0.35 * pad + 0.3 * mask, 0.0, 1.0))
    colour = mix(mix(board, mix(rgb("3fae6a"), gold, pad), copper), rgb("10150f"), hole)
    height = -0.55 + 0.05 * mask + 0.95 * copper + 0.45 * pad - 1.20 * hole
    return Relief(canvas.softened(height), canvas.softened(colour))


STYLE = Style(
    name="circuit",
    description="a printed circuit board with tracks at right angles between gilded pads",
    feature_mm=GRID,
    program=circuit,
)
