"""Topographic lines: raised contour lines of a hilly land."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import folded
from mechstyle.styling.style import Relief, Style

HILL, LEVELS, LINE = 58.0, 10, 3.6


def topographic(canvas: Canvas) -> Relief:
    """A ridge along every contour, land that rises between them; the colours are those of a map, from the sea to the snow."""
    unit = canvas.unit("contour lines", LINE, edges=1.8)
    land = 0.5 + 0.72 * canvas.noise(HILL * unit, 2, "land")
    step = np.clip(land, 0.0, 1.0) * LEVELS
    # The lines are of one width, however gentle the hill.
    away = folded(step) / np.maximum(canvas.softened(canvas.operators.slope(step)), 0.3 / (HILL * unit))
    line = smoothstep(0.75 * LINE * unit, 0.20 * LINE * unit, away) * (np.round(step) > 0.0) * (np.round(step) < LEVELS)
    level = (np.floor(step + 0.5) + smoothstep(-0.5, 0.5, step - np.floor(step + 0.5))) / LEVELS
    colour = ramp(["2f6f8f", "6fb0a8", "8fbf7a", "d6d08a", "c79a62", "9a6a4a", "f2efe8"], np.clip(level, 0.0, 1.0))
    colour = mix(canvas.painted(colour), rgb("4a3a2a"), 0.8 * line)
    return Relief(canvas.softened(-0.8 + 0.45 * level + 1.45 * line), canvas.softened(colour))


STYLE = Style(
    name="topographic",
    description="raised contour lines of a hilly land in the colours of a map",
    feature_mm=0.25 * HILL,
    program=topographic,
)
