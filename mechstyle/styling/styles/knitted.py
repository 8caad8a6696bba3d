"""Stitches of thick yarn: knitting, cables and crochet."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Canvas, dome
from mechstyle.styling.drawing.colours import ramp
from mechstyle.styling.style import Relief, style

KNIT_LENGTH, KNIT_HEIGHT = 13.0, 8.5
LEG, YARN, LEAN = 13.5, 6.4, np.radians(30.0)


@style("columns of slanting stitches in thick, pale wool", feature_mm=KNIT_LENGTH)
def knit(canvas: Canvas) -> Relief:
    """Each stitch a V of two legs whose foot dips into the stitch below, stacked into columns with a furrow between."""
    unit = canvas.unit("strands of wool", YARN, edges=3.0)
    bond = canvas.bond(KNIT_LENGTH * unit, KNIT_HEIGHT * unit, shift=0.0, grip=0.6)
    x, y = np.abs(bond.x) * KNIT_LENGTH - 0.24 * KNIT_LENGTH, bond.y * KNIT_HEIGHT
    # Legs are longer than a row is high: each comes out of the stitch below, whose head shows on both sides of it.
    legs = []
    for row in (-1.0, 0.0, 1.0):
        along = x * np.sin(LEAN) + (y - row * KNIT_HEIGHT) * np.cos(LEAN)
        across = x * np.cos(LEAN) - (y - row * KNIT_HEIGHT) * np.sin(LEAN)
        # It comes out from under the stitch below and lies on the foot of the one above.
        legs.append(dome(np.hypot(2.0 * along / LEG, 2.0 * across / YARN)) * (0.85 + 0.30 * np.clip(2.0 * along / LEG, -1.0, 1.0)))
    furrow = np.exp(-(((0.5 - np.abs(bond.x)) * KNIT_LENGTH / 1.7) ** 2))
    fluff = canvas.noise(6.0 * unit, 2, "fluff")
    heather = canvas.noise(40.0 * unit, 2, "heather")
    lift = np.max(legs, axis=0) * (1.0 - 0.55 * furrow)
    tone = 0.02 + 0.85 * lift + 0.12 * fluff + 0.06 * heather
    colour = canvas.painted(ramp(["6b5a44", "a8947a", "d8c9b0", "f4ecdc"], tone))
    return Relief(canvas.softened(-1.1 + 2.2 * lift + 0.06 * fluff), canvas.softened(colour))


WIDTH, TURN, STRAND = 30.0, 30.0, 9.0
SWAY = 5.4


@style("plaits of thick strands crossing over each other, as on an Aran jumper", feature_mm=0.5 * WIDTH)
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
    tone = 0.10 + 0.55 * lift + 0.12 * fluff
    colour = canvas.painted(ramp(["5e6b6a", "9caaa4", "d3d9cf", "f4f3ea"], tone))
    return Relief(canvas.softened(-1.05 + 1.55 * lift + 0.06 * fluff), canvas.softened(colour))


CROCHET_LENGTH, CROCHET_HEIGHT = 14.0, 9.6
LEG_LENGTH, LEG_WIDTH, LEG_LEAN = 11.6, 6.4, np.radians(30.0)


@style("rows of plump V-shaped stitches in thick yarn", feature_mm=CROCHET_HEIGHT)
def crochet(canvas: Canvas) -> Relief:
    """Two plump legs a stitch, leaning apart upwards, the foot of each V between the legs of the one below."""
    unit = canvas.unit("strands of yarn", LEG_WIDTH, edges=3.0)
    bond = canvas.bond(CROCHET_LENGTH * unit, CROCHET_HEIGHT * unit, shift=0.0, grip=0.3)
    x, y = np.abs(bond.x) * CROCHET_LENGTH - 0.25 * CROCHET_LENGTH, bond.y * CROCHET_HEIGHT
    strand = np.max([leg(x, y - rows * CROCHET_HEIGHT) for rows in (-1.0, 0.0, 1.0)], axis=0)
    groove = 1.0 - 0.15 * np.exp(-(((np.abs(bond.y) - 0.5) * CROCHET_HEIGHT / 1.6) ** 2))
    lift = strand * groove
    fluff = canvas.noise(6.0 * unit, 2, "fluff")
    heather = canvas.noise(45.0 * unit, 2, "heather")
    tone = 0.02 + 0.82 * lift + 0.10 * fluff + 0.10 * heather
    colour = canvas.painted(ramp(["6a2238", "9f3a4e", "cf5f69", "eda3a0"], tone))
    return Relief(canvas.softened(-1.0 + 2.0 * lift + 0.06 * fluff), canvas.softened(colour))


def leg(x: Floats, y: Floats) -> Floats:
    """Height of a leg of yarn, half an ellipsoid leaning outwards, over its thickness, at places from its middle [mm]."""
    along = x * np.sin(LEG_LEAN) + y * np.cos(LEG_LEAN)
    across = x * np.cos(LEG_LEAN) - y * np.sin(LEG_LEAN)
    return np.asarray(np.sqrt(np.clip(1.0 - (2.0 * along / LEG_LENGTH) ** 2 - (2.0 * across / LEG_WIDTH) ** 2, 0.0, 1.0)))
