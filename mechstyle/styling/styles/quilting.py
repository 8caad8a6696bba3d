"""Quilting: puffed diamonds between stitched seams, with a button where seams cross."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import folded
from mechstyle.styling.style import Relief, Style

LENGTH, HEIGHT, BUTTON = 24.0, 30.0, 2.9


def quilting(canvas: Canvas) -> Relief:
    """Cushions between slanting seams that pull them down, deepest at the buttons."""
    unit = canvas.unit("buttons", 2.0 * BUTTON, edges=2.4)
    bond = canvas.bond(LENGTH * unit, HEIGHT * unit, shift=0.0, grip=0.6)
    one, other = (1.0 - (1.0 - 2.0 * folded(phase)) ** 2 for phase in (bond.x + bond.y, bond.x - bond.y))
    puff = np.sqrt(one * other)
    # Seams cross in the middle of a cell and at its corners.
    cross = np.minimum(*(np.hypot(x * LENGTH, y * HEIGHT) for x, y in (bond[:2], (0.5 - np.abs(bond.x), 0.5 - np.abs(bond.y)))))
    button = smoothstep(1.15 * BUTTON, 0.80 * BUTTON, cross)
    sag, soft = np.exp(-((cross / (2.3 * BUTTON)) ** 2)), canvas.noise(30.0 * unit, 2, "soft")
    satin = ramp(["52203c", "86365e", "b8608a", "e7b3c9"], np.clip(0.12 + 0.66 * puff + 0.15 * soft - 0.15 * sag, 0.0, 1.0))
    colour = mix(canvas.painted(satin), rgb("d9b26a"), button)
    height = -0.90 + 1.95 * puff - 0.30 * sag + button * 0.85
    return Relief(canvas.softened(height + 0.05 * soft), canvas.softened(colour))


STYLE = Style(
    name="quilting",
    description="puffed diamonds between stitched seams, with a button where seams cross",
    feature_mm=0.5 * HEIGHT,
    program=quilting,
)
