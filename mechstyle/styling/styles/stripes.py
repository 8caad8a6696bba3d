"""Level bands with hollow grooves between."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, rgb, smoothstep
from mechstyle.styling.drawing.tilings import dome
from mechstyle.styling.style import Relief, Style

PERIOD = 11.0


def stripes(canvas: Canvas) -> Relief:
    """Raised bands and grooves of one width, in two colours."""
    unit = canvas.unit("stripes", 0.5 * PERIOD)
    bond = canvas.bond(10.0 * PERIOD * unit, PERIOD * unit, shift=0.0)
    away = np.abs(bond.y) * PERIOD
    band = smoothstep(0.31 * PERIOD, 0.19 * PERIOD, away)
    groove = dome(np.clip((0.5 * PERIOD - away) / (0.27 * PERIOD), 0.0, 1.0))
    cloth = canvas.noise(40.0 * unit, 2, "cloth")
    colour = mix(rgb("f4f0e6"), canvas.painted(np.tile(rgb("b5403a"), (len(away), 1))), band)
    height = 1.1 * band - (1.0 - band) * (0.55 + 0.45 * groove) + 0.06 * cloth
    colour = np.clip(colour * (1.0 + 0.05 * cloth)[:, None], 0.0, 1.0)
    return Relief(canvas.softened(height), canvas.softened(colour))


STYLE = Style(
    name="stripes",
    description="level raised bands with hollow grooves between, in red and white",
    feature_mm=PERIOD,
    program=stripes,
)
