"""Diamond knurling: small pyramids in rows, as rolled on a tool's handle."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import ramp, smoothstep
from mechstyle.styling.drawing.tilings import folded
from mechstyle.styling.style import Relief, Style

LENGTH, HEIGHT = 7.6, 9.6


def knurling(canvas: Canvas) -> Relief:
    """Two sets of slanting V grooves leave pyramids, their tips a little worn."""
    unit = canvas.unit("grooves of the knurl", 0.5 * HEIGHT)
    bond = canvas.bond(LENGTH * unit, HEIGHT * unit, shift=0.0)
    pyramid = np.minimum(0.5 - folded(bond.x + bond.y), 0.5 - folded(bond.x - bond.y)) * 2.0
    tip = smoothstep(0.0, 0.85, pyramid)
    worn = canvas.noise(30.0 * unit, 3, "worn")
    colour = ramp(["23262a", "5b6168", "9aa1a8", "dfe3e6"], np.clip(0.05 + 0.85 * tip + 0.12 * worn, 0.0, 1.0))
    return Relief(canvas.softened(-1.0 + 2.3 * np.minimum(pyramid, 0.9) + 0.05 * worn), canvas.softened(canvas.painted(colour)))


STYLE = Style(
    name="knurling",
    description="diamond knurling, small pyramids in slanting rows as on the handle of a tool",
    feature_mm=HEIGHT,
    program=knurling,
)
