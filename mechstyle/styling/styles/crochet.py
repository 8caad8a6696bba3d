"""Rows of single crochet: plump V-shaped stitches in thick yarn."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import ramp
from mechstyle.styling.style import Relief, Style

LENGTH, HEIGHT = 14.0, 9.6
LEG_LENGTH, LEG_WIDTH, LEG_LEAN = 11.6, 6.4, np.radians(30.0)


def crochet(canvas: Canvas) -> Relief:
    """Two plump legs a stitch, leaning apart upwards, the foot of each V between the legs of the one below."""
    unit = canvas.unit("strands of yarn", LEG_WIDTH, edges=3.0)
    bond = canvas.bond(LENGTH * unit, HEIGHT * unit, shift=0.0, grip=0.3)
    x, y = np.abs(bond.x) * LENGTH - 0.25 * LENGTH, bond.y * HEIGHT
    strand = np.max([leg(x, y - rows * HEIGHT) for rows in (-1.0, 0.0, 1.0)], axis=0)
    groove = 1.0 - 0.15 * np.exp(-(((np.abs(bond.y) - 0.5) * HEIGHT / 1.6) ** 2))
    lift = strand * groove
    fluff = canvas.noise(6.0 * unit, 2, "fluff")
    heather = canvas.noise(45.0 * unit, 2, "heather")
    tone = np.clip(0.02 + 0.82 * lift + 0.10 * fluff + 0.10 * heather, 0.0, 1.0)
    colour = canvas.painted(ramp(["6a2238", "9f3a4e", "cf5f69", "eda3a0"], tone))
    return Relief(canvas.softened(-1.0 + 2.0 * lift + 0.06 * fluff), canvas.softened(colour))


def leg(x: Floats, y: Floats) -> Floats:
    """Height of a leg of yarn, half an ellipsoid leaning outwards, over its thickness, at places from its middle [mm]."""
    along = x * np.sin(LEG_LEAN) + y * np.cos(LEG_LEAN)
    across = x * np.cos(LEG_LEAN) - y * np.sin(LEG_LEAN)
    return np.asarray(np.sqrt(np.clip(1.0 - (2.0 * along / LEG_LENGTH) ** 2 - (2.0 * across / LEG_WIDTH) ** 2, 0.0, 1.0)))


STYLE = Style(
    name="crochet",
    description="rows of plump V-shaped stitches in thick yarn",
    feature_mm=HEIGHT,
    program=crochet,
)
