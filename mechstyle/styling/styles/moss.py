"""Moss: round cushions, close together, of small leaves on end."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import ramp, smoothstep
from mechstyle.styling.drawing.tilings import dome
from mechstyle.styling.style import Relief, Style

LEAF, MOUND = 4.6, 22.0
SIZES = (1.0, 0.6)  # of the generations of cushions over the largest


def moss(canvas: Canvas) -> Relief:
    """Round cushions side by side with dark gaps between, each of them all small leaves that stand on end."""
    unit = canvas.unit("leaves of moss", LEAF, edges=2.4)
    mound = np.zeros(len(canvas.points))
    for size in SIZES:
        spacing = size * MOUND * unit
        stamps = canvas.stamps(canvas.scattered(spacing, f"cushions {size}"), spacing, count=3)
        radius = (0.50 + 0.16 * canvas.random(stamps.identity, "radius")) * spacing
        cushions = dome(np.hypot(stamps.x, stamps.y) / radius) * smoothstep(0.2, 0.5, stamps.facing)
        mound = np.maximum(mound, (0.25 + 0.75 * size) * cushions.max(axis=1))
    leaves = canvas.cells(LEAF * unit, "leaves")
    leaf, own = np.clip(leaves.edge / (0.48 * LEAF * unit), 0.0, 1.0), canvas.random(leaves.identity, "own") - 0.5
    damp = canvas.noise(35.0 * unit, 3, "damp")
    tone = np.clip(0.05 + 0.50 * mound + 0.25 * leaf + 0.25 * own + 0.20 * damp, 0.0, 1.0)
    colour = ramp(["1d2c10", "3f5a1c", "6c8a2c", "a3b84e", "cbd27c"], tone)
    height = -1.1 + 1.00 * mound + (0.45 + 0.75 * mound) * leaf * (0.9 + 0.3 * own)
    return Relief(canvas.softened(height), canvas.softened(canvas.painted(colour)))


STYLE = Style(
    name="moss",
    description="round green cushions of moss, rough with small leaves",
    feature_mm=0.9 * MOUND,
    program=moss,
)
