"""Overlapping leaves in many greens."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

SPACING, LEAF, WIDTH = 13.0, 27.0, 17.0


def green(canvas: Canvas) -> Relief:
    """Leaves hanging every which way, mostly down, laid over each other from the lowest to the uppermost."""
    unit = canvas.unit("leaf tips", 4.0)
    points = canvas.scattered(SPACING * unit, "leaves")
    stamps = canvas.stamps(points, SPACING * unit, count=8)
    x, y = stamps.x / unit, stamps.y / unit
    turn = np.pi * (1.5 + 0.9 * (canvas.random(stamps.identity, "turn") - 0.5))
    along = (x * np.cos(turn) + y * np.sin(turn)) / LEAF + 0.45
    across = np.abs(y * np.cos(turn) - x * np.sin(turn)) / (0.5 * WIDTH)
    # A pointed oval, widest before its middle.
    inside = 2.4 * np.clip(along, 0.0, 1.0) ** 0.55 * np.clip(1.0 - along, 0.0, 1.0) ** 0.75 - across
    here = smoothstep(0.25, 0.50, stamps.facing)
    cover = smoothstep(0.0, 0.16, inside) * here
    shadow = smoothstep(-0.40, 0.0, inside) * smoothstep(-0.2, 0.1, along) * smoothstep(1.2, 0.9, along) * here
    age = canvas.random(stamps.identity, "age")

    colour, height = np.tile(rgb("14301d"), (len(x), 1)), np.full(len(x), -0.9)
    for k in range(x.shape[1]):
        rib = np.exp(-((across[:, k] / 0.20) ** 2)) * smoothstep(1.0, 0.75, along[:, k])
        blade = mix(ramp(["23552c", "3a7a38", "5f9c43", "8cbb56", "b3cc6c"], age[:, k]), rgb("c4dba0"), 0.5 * rib)
        colour = mix(mix(colour, 0.45 * colour, shadow[:, k]), blade, cover[:, k])
        # A leaf lies on the others at its stalk, stands off at its tip, is folded along its rib and leaves a gap around it.
        leaf = -0.35 + 1.25 * along[:, k] - 0.30 * across[:, k] ** 2 - 0.65 * rib
        height += cover[:, k] * (leaf - height) - 0.40 * shadow[:, k] * (1.0 - cover[:, k]) * (height > -0.6)
    return Relief(canvas.softened(height), canvas.painted(canvas.softened(colour)))


STYLE = Style(
    name="green",
    description="overlapping leaves in many greens, their tips standing off",
    feature_mm=WIDTH,
    program=green,
)
