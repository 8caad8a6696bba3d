"""Board-marked concrete: the print of rough planks, pores, and the holes of the formwork's ties."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

BOARD, SEAM, HOLE = 17.0, 2.8, 3.6


def concrete(canvas: Canvas) -> Relief:
    """Every board stood a little differently; grout ran out between them and stands as a seam."""
    unit = canvas.unit("seams between boards", SEAM, edges=1.6)
    bond = canvas.bond(4.0 * BOARD * unit, BOARD * unit, margin=0.5 * SEAM * unit, grip=0.3)
    off = np.minimum((0.5 - np.abs(bond.y)) * BOARD, (0.5 - np.abs(bond.x)) * 4.0 * BOARD)
    seam = smoothstep(0.85 * SEAM, 0.25 * SEAM, off)
    identity = canvas.pieces(off > 0.5 * SEAM, bond.odd)
    own, tone = canvas.random(identity, "set") - 0.5, canvas.random(identity, "tone") - 0.5
    grain = canvas.noise(8.0 * unit, 2, "grain", at=canvas.points * [0.22, 0.22, 1.0])
    pore = smoothstep(0.36, 0.50, canvas.noise(8.0 * unit, 2, "pores"))
    tie = np.hypot(bond.x * 4.0 * BOARD, bond.y * BOARD)
    hole, ring = smoothstep(1.1 * HOLE, 0.7 * HOLE, tie), np.exp(-(((tie - 1.35 * HOLE) / (0.35 * HOLE)) ** 2))
    stain = canvas.noise(40.0 * unit, 3, "stain")
    height = 0.05 + 0.80 * own + 0.50 * grain + 0.75 * seam - 0.95 * pore + 0.20 * ring - 1.25 * hole
    grey = ramp(["6f6f6c", "96958f", "b5b3ab", "d0cec5"], np.clip(0.5 + 0.30 * stain + 0.30 * tone + 0.20 * grain, 0.0, 1.0))
    colour = mix(canvas.painted(grey), rgb("4c4b48"), np.maximum(0.55 * pore, 0.80 * hole))
    return Relief(canvas.softened(np.clip(height, -1.1, 1.3)), canvas.softened(colour))


STYLE = Style(
    name="concrete",
    description="grey concrete with the print of boards, pores and round tie holes",
    feature_mm=BOARD,
    program=concrete,
)
