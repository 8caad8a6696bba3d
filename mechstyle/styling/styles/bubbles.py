"""Bubbles of many sizes crowded together, as in froth."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import dome
from mechstyle.styling.style import Relief, Style

LARGE = 14.0
SIZES = (1.0, 0.62)  # radii of the generations of bubbles over the largest
SHARE = 0.42  # radius of a bubble over the distance of its generation


def bubbles(canvas: Canvas) -> Relief:
    """Small half balls fill the room between large ones; the highest is in front."""
    unit = canvas.unit("small bubbles", SIZES[-1] * LARGE, edges=4.5)
    height, glint = np.full(len(canvas.points), -1.0), np.zeros(len(canvas.points))
    own = np.zeros(len(canvas.points))
    for size in SIZES:
        spacing = size * LARGE * unit
        stamps = canvas.stamps(canvas.scattered(spacing, f"bubbles {size}"), spacing, count=3)
        radius = (SHARE + 0.14 * canvas.random(stamps.identity, "radius")) * spacing
        ball = dome(np.hypot(stamps.x, stamps.y) / radius) * smoothstep(0.2, 0.5, stamps.facing)
        spark = np.exp(-((np.hypot(stamps.x + 0.25 * radius, stamps.y - 0.35 * radius) / (0.28 * radius)) ** 2))
        for k in range(ball.shape[1]):
            higher = -1.0 + (1.05 + 1.05 * size) * ball[:, k]
            front = higher > height
            height, glint = np.where(front, higher, height), np.where(front, spark[:, k], glint)
            own = np.where(front, canvas.random(stamps.identity[:, k], f"hue {size}"), own)
    tone = np.clip(0.15 + 0.30 * (height + 1.0) + 0.30 * (own - 0.5), 0.0, 1.0)
    water = canvas.painted(ramp(["12507e", "2f8fc0", "7fcbe2", "d6f2f4"], tone))
    return Relief(canvas.softened(height), canvas.softened(mix(water, rgb("ffffff"), 0.75 * glint)))


STYLE = Style(
    name="bubbles",
    description="round bubbles of many sizes crowded together",
    feature_mm=LARGE,
    program=bubbles,
)
