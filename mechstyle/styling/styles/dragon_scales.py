"""Large pointed scales with a keel, overlapping like armour."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

LENGTH, HEIGHT, LIP = 20.0, 14.0, 3.2


def dragon_scales(canvas: Canvas) -> Relief:
    """Pointed scales, each with a keel down its middle, laid over the two below it."""
    unit = canvas.unit("lips of scales", LIP, edges=1.6)
    bond = canvas.bond(LENGTH * unit, HEIGHT * unit, grip=0.3)
    # Of the scale hanging from this row: how far aside and down a place is, 1 at its flank and its tip.
    aside, down = 2.0 * np.abs(bond.x), 0.5 - bond.y
    inside = 0.62 * HEIGHT * ((1.0 - aside) ** 0.75 * (1.0 + 0.35 * aside) - down)
    over = smoothstep(-0.5 * LIP, 0.5 * LIP, inside)
    # Scales of one row touch in their corners, where the one above has its tip.
    apart = np.minimum(np.hypot(1.0 - aside, down), np.hypot(aside, 1.0 - down)) > 0.25
    own = (canvas.random(canvas.pieces(apart, bond.odd ^ (inside > 0.0)), "tone") - 0.5) * apart
    horn = canvas.noise(6.0 * unit, 2, "horn")

    heights, colours = [], []
    # Where the scale above ends, the one below it shows, half a scale aside and a row down.
    for beside, along in ((1.0 - aside, down - 1.0), (aside, down)):
        keel = smoothstep(0.30, 0.0, beside) * smoothstep(-1.0, 0.3, along)
        heights.append(0.95 * along - 0.60 * beside + 0.45 * keel + 0.06 * horn + 0.10 * own)
        body = ramp(["2a0d12", "64161d", "9c2723", "c64d2c"], np.clip(0.40 + 0.30 * along + 0.30 * own + 0.12 * horn, 0.0, 1.0))
        colours.append(canvas.painted(mix(body, rgb("e2b04c"), 0.35 * keel)))
    below = mix(colours[0], rgb("1a080a"), 0.80 * smoothstep(-1.5 * LIP, 0.0, inside))
    above = mix(colours[1], rgb("e2b04c"), 0.65 * smoothstep(1.7 * LIP, 0.4 * LIP, inside))
    height = heights[0] + (heights[1] - heights[0]) * over
    colour = mix(below, above, over)
    return Relief(canvas.softened(height), canvas.softened(colour))


STYLE = Style(
    name="dragon_scales",
    words=("dragon", "reptile", "reptilian", "lizard", "snake", "snakeskin"),
    description="large pointed scales with a keel and gilded rims, overlapping like armour",
    feature_mm=HEIGHT,
    program=dragon_scales,
)
