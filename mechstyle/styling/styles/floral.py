"""Open flowers of many colours over leaves."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

SPACING, FLOWER, LEAF = 29.0, 16.0, 26.0
PETALS = ("c8385f", "e88aa6", "f4b640", "f6efe2", "8f63b8", "e2663c")


def floral(canvas: Canvas) -> Relief:
    """A bed of leaves, and on it flowers with five or six petals, each turned and coloured its own way."""
    unit = canvas.unit("petals", 6.0, edges=2.5)
    colour, height = _leaves(canvas, unit)
    points = canvas.scattered(SPACING * unit, "flowers", room=0.8 * FLOWER * unit)
    flowers = canvas.stamps(points, SPACING * unit, count=3)
    own, turned = canvas.random(flowers.identity, "size"), canvas.random(flowers.identity, "turned")
    reach = np.hypot(flowers.x, flowers.y) / (FLOWER * unit * (0.80 + 0.20 * own))
    angle = np.arctan2(flowers.y, flowers.x) + 2.0 * np.pi * turned
    # 1 along the middle of a petal, 0 between two.
    lobe = np.abs(np.cos(np.where(own < 0.6, 2.5, 3.0) * angle))
    inside, here = 0.50 + 0.50 * lobe**0.7 - reach, smoothstep(0.25, 0.50, flowers.facing)
    cover, shadow = smoothstep(-0.05, 0.08, inside) * here, smoothstep(-0.30, 0.0, inside) * here
    parting, eye = smoothstep(0.55, 0.10, lobe), smoothstep(0.36, 0.24, reach)
    cup = 0.15 + 0.75 * smoothstep(0.25, 0.70, reach) - 0.75 * parting
    hue = np.array([rgb(code) for code in PETALS])[(canvas.random(flowers.identity, "hue") * len(PETALS)).astype(int)]
    for k in range(reach.shape[1]):
        shade = np.maximum(0.9 * parting[:, k], 0.5 * smoothstep(0.65, 0.30, reach[:, k]))
        petal = canvas.painted(mix(hue[:, k], 0.5 * hue[:, k], shade))
        colour = mix(colour, mix(petal, rgb("f2c230"), eye[:, k]), cover[:, k])
        height -= 0.35 * shadow[:, k] * (1.0 - cover[:, k])
        height += cover[:, k] * (cup[:, k] + eye[:, k] * (1.0 - cup[:, k]) - height)
    return Relief(canvas.softened(height), canvas.softened(colour))


def _leaves(canvas: Canvas, unit: float) -> tuple[Floats, Floats]:
    """Colour and height of a low bed of leaves lying every which way."""
    colour, height = np.tile(rgb("1f4029"), (len(canvas.points), 1)), np.full(len(canvas.points), -0.90)
    leaves = canvas.stamps(canvas.scattered(0.5 * LEAF * unit, "leaves"), 0.5 * LEAF * unit, count=5)
    turn = 2.0 * np.pi * canvas.random(leaves.identity, "turn")
    along = (leaves.x * np.cos(turn) + leaves.y * np.sin(turn)) / (LEAF * unit) + 0.5
    across = np.abs(leaves.y * np.cos(turn) - leaves.x * np.sin(turn)) / (0.25 * LEAF * unit)
    inside = np.sin(np.pi * np.clip(along, 0.0, 1.0)) - across
    here = smoothstep(0.25, 0.50, leaves.facing)
    blade, shadow = smoothstep(-0.10, 0.20, inside) * here, smoothstep(-0.45, -0.05, inside) * (np.abs(along - 0.5) < 0.5) * here
    for k in range(blade.shape[1]):
        green = ramp(["2c5d36", "46813f", "73a552"], canvas.random(leaves.identity[:, k], "age"))
        green = mix(green, rgb("a9c97c"), 0.7 * smoothstep(0.22, 0.0, across[:, k]))
        colour = mix(mix(colour, 0.5 * colour, shadow[:, k]), green, blade[:, k])
        height += blade[:, k] * (-0.55 + 0.35 * along[:, k] - 0.30 * across[:, k] - height)
    return colour, height


STYLE = Style(
    name="floral",
    description="open flowers of many colours on a bed of leaves",
    feature_mm=SPACING,
    program=floral,
)
