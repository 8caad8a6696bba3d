"""Hammered metal: round dents of a hammer, polished."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

DENT = 15.0


def hammered(canvas: Canvas) -> Relief:
    """Round bowls of uneven size, each with its own rim, some across others; flat metal is left between."""
    unit = canvas.unit("dents", DENT, edges=4.5)
    spacing = 0.62 * DENT * unit
    blows = canvas.stamps(canvas.scattered(spacing, "dents"), spacing, count=4)
    blow = canvas.random(blows.identity, "blow")
    reach = np.hypot(blows.x, blows.y) / ((0.34 + 0.12 * blow) * DENT * unit)
    bowls = (1.0 - np.clip(reach, 0.0, 1.0) ** 2) * (0.75 + 0.25 * blow) * smoothstep(0.2, 0.5, blows.facing)
    bowl = bowls.max(axis=1)
    rim = np.max(np.exp(-(((reach - 1.04) / 0.10) ** 2)), axis=1) * smoothstep(0.25, 0.0, bowl)
    cloud = canvas.noise(45.0 * unit, 2, "cloud")
    tone = np.clip(0.70 - 0.50 * bowl + 0.20 * rim + 0.12 * cloud, 0.0, 1.0)
    steel = ramp(["3b424b", "68717b", "9aa2aa", "cbd0d4", "f2f3f2"], tone)
    colour = mix(canvas.painted(steel), rgb("fbfaf5"), 0.55 * rim)
    return Relief(canvas.softened(0.80 - 1.75 * bowl + 0.20 * rim), canvas.softened(colour))


STYLE = Style(
    name="hammered",
    description="polished metal beaten into round dents with bright rims",
    feature_mm=DENT,
    program=hammered,
)
