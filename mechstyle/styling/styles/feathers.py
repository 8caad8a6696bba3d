"""Feathers laid over each other in rows, each with a shaft and slanting barbs."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import beneath, hanging, own_of_scales
from mechstyle.styling.style import Relief, Style

LENGTH, HEIGHT, LIP, BARB = 23.0, 17.0, 3.4, 4.6


def feathers(canvas: Canvas) -> Relief:
    """Long rounded feathers hang over those below; barbs leave the shaft to both sides."""
    unit = canvas.unit("barbs", BARB)
    bond = canvas.bond(LENGTH * unit, HEIGHT * unit, grip=0.3)
    upper = hanging(bond)
    inside = 0.70 * HEIGHT * ((1.0 - upper.aside**1.7) ** 0.8 - upper.down)
    over = smoothstep(-0.25 * LIP, 0.25 * LIP, inside)
    shade = smoothstep(-1.2 * LIP, 0.0, inside)
    own = own_of_scales(canvas, bond, inside, "tone")
    worn = canvas.noise(40.0 * unit, 2, "worn")
    heights, colours = [], []
    for feather in (beneath(upper), upper):
        shaft = smoothstep(0.16, 0.05, feather.aside)
        barb = np.cos(2.0 * np.pi * (feather.down * HEIGHT + 0.55 * feather.aside * LENGTH) / BARB) * (1.0 - shaft)
        heights.append(0.90 * feather.down - 0.35 * feather.aside**2 + 0.45 * shaft + 0.22 * barb - 0.10 + 0.05 * worn)
        tone = np.clip(0.40 + 0.28 * feather.down + 0.40 * own + 0.10 * barb, 0.0, 1.0)
        vane = canvas.painted(ramp(["2b2f55", "3f5f8f", "5f9aa6", "c9d6b8"], tone))
        colours.append(mix(vane, rgb("f3ead2"), 0.75 * shaft))
    below, above = heights[0] - 0.50 * shade, heights[1] + 0.15 * smoothstep(1.5 * LIP, 0.5 * LIP, inside)
    colour = mix(mix(colours[0], rgb("12152b"), 0.75 * shade), colours[1], over)
    return Relief(canvas.softened(below + (above - below) * over), canvas.softened(colour))


STYLE = Style(
    name="feathers",
    description="feathers laid over each other in rows, with shafts and slanting barbs",
    feature_mm=HEIGHT,
    program=feathers,
)
