"""Cable knitting: plaits of thick strands that cross over each other, between furrows."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import ramp
from mechstyle.styling.drawing.tilings import dome
from mechstyle.styling.style import Relief, Style

WIDTH, TURN, STRAND = 30.0, 30.0, 9.0
SWAY = 5.4


def cable_knit(canvas: Canvas) -> Relief:
    """Two strands wind around each other in the middle of each column; beside them purl stitches lie in the furrows."""
    unit = canvas.unit("strands of the cable", STRAND, edges=4.0)
    bond = canvas.bond(WIDTH * unit, TURN * unit, shift=0.0, grip=0.6)
    x, turn = bond.x * WIDTH, 2.0 * np.pi * bond.y
    strands = []
    for side in (1.0, -1.0):
        across = (x - side * SWAY * np.sin(turn)) / np.hypot(1.0, 2.0 * np.pi * SWAY / TURN * np.cos(turn))
        # The strand that rises to the right is the upper one where they cross, so that the cable always turns one way.
        body = dome(across / (0.5 * STRAND))
        ply = np.cos(2.0 * np.pi * (bond.y * TURN / 6.0 + side * across / 9.0))
        strands.append(body * (1.0 + 0.50 * side * np.cos(turn) + 0.22 * ply))
    cable = np.max(strands, axis=0)
    beside = np.abs(x) - 0.5 * WIDTH
    purl = dome(np.abs(beside) / 4.4) * (0.55 + 0.45 * np.cos(2.0 * np.pi * bond.y * TURN / 6.0))
    lift = np.maximum(cable, 0.62 * purl)
    fluff = canvas.noise(6.0 * unit, 2, "fluff")
    tone = np.clip(0.10 + 0.55 * lift + 0.12 * fluff, 0.0, 1.0)
    colour = canvas.painted(ramp(["5e6b6a", "9caaa4", "d3d9cf", "f4f3ea"], tone))
    return Relief(canvas.softened(-1.05 + 1.55 * lift + 0.06 * fluff), canvas.softened(colour))


STYLE = Style(
    name="cable_knit",
    description="plaits of thick strands crossing over each other, as on an Aran jumper",
    feature_mm=0.5 * WIDTH,
    program=cable_knit,
)
