"""Bark of an old tree: long plates between deep, branching furrows."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

PLATE = 25.0
STRETCH = np.array([1.0, 1.0, 0.40])  # plates are longer upwards


def bark(canvas: Canvas) -> Relief:
    """Furrows wind upwards and meet; finer ones split the plates between, and a few cracks run across."""
    unit = canvas.unit("furrows", 0.15 * PLATE, edges=2.0)
    broad = np.abs(canvas.noise(PLATE * unit, 2, "furrows", at=canvas.points * STRETCH))
    narrow = np.abs(canvas.noise(0.45 * PLATE * unit, 2, "splits", at=canvas.points * STRETCH))
    across = np.abs(canvas.noise(0.55 * PLATE * unit, 2, "cracks", at=canvas.points * [0.6, 0.6, 1.0]))
    plate, split, crack = smoothstep(0.0, 0.22, broad), smoothstep(0.0, 0.22, narrow), smoothstep(0.0, 0.16, across)
    scaly = canvas.noise(6.0 * unit, 2, "scaly")
    height = -1.1 + 0.90 * plate + plate * (0.65 * split + 0.55 * crack) + 0.10 * scaly
    tone = np.clip(0.05 + 0.42 * plate + 0.28 * split + 0.20 * crack + 0.22 * scaly, 0.0, 1.0)
    colour = mix(rgb("20150d"), canvas.painted(ramp(["3a2819", "64482f", "917255", "c2aa88"], tone)), smoothstep(0.0, 0.5, plate))
    return Relief(canvas.softened(height), canvas.softened(colour))


STYLE = Style(
    name="bark",
    description="long plates of bark between deep, branching furrows",
    feature_mm=PLATE,
    program=bark,
)
