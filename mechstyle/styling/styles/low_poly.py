"""Low poly: large flat triangles that meet in straight edges, as in an early computer game."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import ramp
from mechstyle.styling.style import Relief, Style

FACET = 21.0  # across a fan of triangles


def low_poly(canvas: Canvas) -> Relief:
    """Around scattered points that stand out the surface is a fan of flat faces, each of one tone."""
    unit = canvas.unit("facets", 0.4 * FACET, edges=2.5)
    fans = canvas.cells(0.8 * FACET * unit, "fans")
    rise = 0.75 + 0.50 * canvas.random(fans.identity, "rise")
    height = -1.0 + np.minimum(3.0 * rise * fans.edge / (0.8 * FACET * unit), 2.4)
    facet = canvas.random(fans.facet, "facet")
    tone = np.clip(0.20 + 0.20 * rise + 0.70 * (facet - 0.2), 0.0, 1.0)
    colour = ramp(["17525c", "23818a", "4fb3a5", "a8dfc0", "f0f4d6"], tone)
    return Relief(height, canvas.softened(canvas.painted(colour)))


STYLE = Style(
    name="low_poly",
    description="large flat triangles that meet in straight edges",
    feature_mm=FACET,
    program=low_poly,
)
