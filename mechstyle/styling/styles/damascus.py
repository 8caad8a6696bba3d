"""Damascus steel: light and dark layers folded into flowing bands and rings, etched."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import ramp, smoothstep
from mechstyle.styling.style import Relief, Style

LAYER, DROP = 3.4, 15.0


def damascus(canvas: Canvas) -> Relief:
    """Layers of many greys, drilled and forged flat again, which leaves rings; the etch eats the darker steel."""
    unit = canvas.unit("layers", LAYER, edges=2.2)
    x, y, z = canvas.points.T / unit
    pressed = canvas.noise(60.0 * unit, 2, "pressed")
    drops = canvas.stamps(canvas.scattered(2.2 * DROP * unit, "drops"), 2.2 * DROP * unit)
    drop = np.exp(-((drops.x[:, 0] ** 2 + drops.y[:, 0] ** 2) / (0.75 * DROP * unit) ** 2)) * smoothstep(0.0, 0.5, drops.facing[:, 0])
    layer = (0.20 * x + 0.12 * y + 0.97 * z + 9.0 * pressed + 14.0 * drop) / LAYER
    below = np.floor(layer)
    grey = [canvas.random(np.abs(below + step).astype(np.int64), "grey") * 0.15 + 0.85 * ((below + step) % 2) for step in (0.0, 1.0)]
    tone = grey[0] + (grey[1] - grey[0]) * smoothstep(0.25, 0.75, layer - below)
    # Where layers lie too close for the mesh they melt into one grey, as the finest ones of a blade do to the eye.
    tone = 0.5 + (tone - 0.5) * smoothstep(0.85, 0.60, canvas.operators.slope(layer) * canvas.edge)
    brushed = canvas.noise(6.0 * unit, 2, "brushed", at=canvas.points * [1.0, 1.0, 0.3])
    steel = ramp(["2c2f34", "5a5f66", "8b9097", "b9bdc2", "e4e6e7"], np.clip(0.04 + 0.92 * tone + 0.07 * brushed, 0.0, 1.0))
    return Relief(canvas.softened(-0.90 + 1.9 * tone + 0.05 * brushed), canvas.softened(canvas.painted(steel)))


STYLE = Style(
    name="damascus",
    description="flowing layers and rings of light and dark steel, folded and etched",
    feature_mm=2.0 * LAYER,
    program=damascus,
)
