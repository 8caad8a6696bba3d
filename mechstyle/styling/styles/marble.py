"""Polished white marble with grey veins that cross and fade."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

VEIN = 4.0
# Distance of the sheets [mm], direction across them, how far they bend [sheets] and over which length [mm], width of the veins.
SHEETS = (
    (52.0, (0.55, 0.35, 0.76), 0.85, 60.0, 1.25 * VEIN),
    (34.0, (-0.70, 0.40, 0.59), 0.95, 48.0, VEIN),
    (26.0, (0.30, -0.75, 0.59), 0.95, 42.0, 0.75 * VEIN),
)


def marble(canvas: Canvas) -> Relief:
    """Bent sheets of grey minerals cut by the surface: few broad veins and finer ones across them, all fading here and there."""
    unit = canvas.unit("veins", VEIN, edges=2.2)
    cloud = canvas.noise(60.0 * unit, 3, "cloud")
    uneven = canvas.noise(34.0 * unit, 2, "uneven")
    veins = []
    for apart, across, bend, length, width in SHEETS:
        sheet = canvas.points @ np.array(across) / (apart * unit) + bend * canvas.noise(length * unit, 2, f"sheet {apart}")
        away = np.abs(sheet - np.round(sheet)) / np.maximum(canvas.softened(canvas.operators.slope(sheet)), 0.3 / (apart * unit))
        there = smoothstep(-0.60, 0.0, canvas.noise(40.0 * unit, 2, f"there {apart}"))
        veins.append(there * smoothstep(0.80 * width * unit, 0.0, away))
    vein = np.max([veins[0], 0.8 * veins[1], 0.6 * veins[2]], axis=0)
    halo = canvas.smoothed(vein, 7.0 * unit)
    sunk = canvas.smoothed(vein, 3.0 * unit)
    white = ramp(["b4b8be", "dadbde", "f0efec", "faf8f3"], np.clip(0.82 + 0.35 * cloud - 0.85 * halo, 0.0, 1.0))
    colour = mix(canvas.painted(white), rgb("565b64"), 0.85 * vein)
    colour = mix(colour, rgb("b8995f"), 0.50 * halo * smoothstep(0.0, 0.4, cloud))
    return Relief(canvas.softened(0.55 + 0.20 * uneven - 1.40 * vein - 0.45 * sunk), canvas.softened(colour))


STYLE = Style(
    name="marble",
    description="polished white marble with grey veins that cross and fade",
    feature_mm=24.0,
    program=marble,
)
