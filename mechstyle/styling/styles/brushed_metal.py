"""Brushed metal: long level scratches of uneven depth."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import ramp
from mechstyle.styling.style import Relief, Style

SCRATCH = 3.8


def brushed_metal(canvas: Canvas) -> Relief:
    """Bundles of scratches along the level, coarse and fine, worn through here and there."""
    unit = canvas.unit("scratches", SCRATCH, edges=2.0)
    level = canvas.points * [0.06, 0.06, 1.0]
    fine, coarse = canvas.noise(SCRATCH * unit, 2, "fine", at=level), canvas.noise(2.6 * SCRATCH * unit, 2, "coarse", at=level)
    cut = np.clip(2.6 * fine + 0.6 * coarse, -1.0, 1.0)
    sheen = canvas.noise(55.0 * unit, 2, "sheen", at=canvas.points * [1.0, 1.0, 0.5])
    steel = ramp(["70767c", "9da3a8", "c3c8cb", "eceeee"], np.clip(0.52 + 0.38 * cut + 0.25 * sheen, 0.0, 1.0))
    return Relief(canvas.softened(0.05 + 1.05 * cut), canvas.softened(canvas.painted(steel)))


STYLE = Style(
    name="brushed_metal",
    description="long level scratches on bright metal",
    feature_mm=2.6 * SCRATCH,
    program=brushed_metal,
)
