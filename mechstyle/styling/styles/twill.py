"""Twill: cloth with slanting ribs, as denim."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import ramp
from mechstyle.styling.drawing.tilings import dome, folded
from mechstyle.styling.style import Relief, Style

RIB = 10.0


def twill(canvas: Canvas) -> Relief:
    """Slanting ribs of short plump threads, each a step further than the one below."""
    unit = canvas.unit("ribs of the cloth", RIB, edges=3.0)
    bond = canvas.bond(2.0 * RIB * unit, 2.0 * RIB * unit, shift=0.0)
    rib = 2.0 * (bond.x + bond.y)
    across = 2.0 * folded(rib)
    along = 2.0 * folded((bond.x - bond.y) * 2.0 + 0.5 * np.round(rib))
    plump = (1.0 - across**2) * (0.30 + 0.70 * dome(along))
    faded, heather = canvas.noise(45.0 * unit, 3, "faded"), canvas.noise(6.0 * unit, 2, "heather")
    tone = np.clip(0.10 + 0.62 * plump + 0.25 * faded + 0.14 * heather, 0.0, 1.0)
    colour = ramp(["141f38", "28406c", "4f72a3", "a9bfd8"], tone)
    return Relief(canvas.softened(-1.1 + 2.2 * plump + 0.06 * heather), canvas.softened(canvas.painted(colour)))


STYLE = Style(
    name="twill",
    description="cloth with slanting ribs of plump thread, like denim",
    feature_mm=RIB,
    program=twill,
)
