"""Small overlapping leaves, low in relief, in many greens."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

SPACING, LEAF, WIDTH = 11.0, 23.0, 13.0


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
    cover = smoothstep(-0.10, 0.30, inside)
    shadow = smoothstep(-0.65, -0.05, inside) * smoothstep(-0.2, 0.1, along) * smoothstep(1.2, 0.9, along)
    age = canvas.random(stamps.identity, "age")

    colour, height = np.tile(rgb("14301d"), (len(x), 1)), np.full(len(x), -0.6)
    for k in range(x.shape[1]):
        rib = np.exp(-((across[:, k] / 0.20) ** 2)) * smoothstep(1.0, 0.75, along[:, k])
        blade = mix(ramp(["23552c", "3a7a38", "5f9c43", "8cbb56", "b3cc6c"], age[:, k]), rgb("c4dba0"), 0.5 * rib)
        colour = mix(colour, 0.45 * colour, shadow[:, k])
        colour = mix(colour, blade, cover[:, k])
        height += cover[:, k] * (0.10 + 0.45 * along[:, k] - 0.20 * rib - 0.55 * height)
    return Relief(0.7 * height, canvas.painted(canvas.softened(colour)))


STYLE = Style(
    name="green",
    words=("leaf", "leafy", "foliage", "ivy", "plant", "verdant", "botanical", "greenery"),
    description="small overlapping leaves in many greens, low in relief",
    feature_mm=SPACING,
    program=green,
    yields=True,
)
