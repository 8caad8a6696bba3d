"""An organic net: round ribs around deep, flat cells."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, smoothstep
from mechstyle.styling.drawing.tilings import dome
from mechstyle.styling.style import Relief, Style

CELL, RIB = 19.0, 4.6


def voronoi(canvas: Canvas) -> Relief:
    """Round ribs along the borders of Voronoi cells, with flat deep floors that change their hue along the part."""
    unit = canvas.unit("ribs", RIB, edges=2.4)
    cells = canvas.cells(CELL * unit, "cells")
    # Smoothing rounds the corners of the cells, and pins the ribs where three meet.
    edge = canvas.smoothed(cells.edge, unit) / unit
    rib = dome(np.clip(edge / (0.62 * RIB), 0.0, 1.0))
    deep = smoothstep(0.40 * RIB, 1.20 * RIB, edge)
    own = canvas.random(cells.identity, "tone") - 0.5
    drift = canvas.noise(70.0 * unit, 2, "drift")
    floor = ramp(["33306b", "3f5f9e", "3f9fae", "7fcfa6", "e6e08c"], np.clip(0.5 + 0.75 * drift + 0.35 * own, 0.0, 1.0))
    floor = floor * (1.10 - 0.50 * deep)[:, None]
    net = ramp(["d9d5cc", "f6f3ec"], smoothstep(0.3, 1.0, rib))
    height = -0.45 - 0.50 * deep + 1.40 * rib + 0.10 * own * deep
    return Relief(canvas.softened(height), canvas.softened(np.clip(mix(canvas.painted(floor), net, rib), 0.0, 1.0)))


STYLE = Style(
    name="voronoi",
    description="a pale organic net of round ribs around deep, coloured cells",
    feature_mm=CELL,
    program=voronoi,
)
