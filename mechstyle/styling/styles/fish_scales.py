"""Round scales in overlapping rows, shining like a fish."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import beneath, hanging, own_of_scales
from mechstyle.styling.style import Relief, Style

LENGTH, HEIGHT, LIP = 18.0, 10.0, 3.2


def fish_scales(canvas: Canvas) -> Relief:
    """Scales laid like roof tiles: each hangs over the roots of the two below it and stands off most at its round tip."""
    unit = canvas.unit("lips of scales", LIP, edges=1.6)
    bond = canvas.bond(LENGTH * unit, HEIGHT * unit, grip=0.3)
    upper = hanging(bond)
    inside = HEIGHT * (1.0 - np.hypot(*upper))
    over = smoothstep(-0.25 * LIP, 0.25 * LIP, inside)
    shade = smoothstep(-1.2 * LIP, 0.0, inside)
    own = own_of_scales(canvas, bond, inside, "tone")
    sheen = canvas.noise(40.0 * unit, 2, "sheen")

    heights, colours = [], []
    for scale in (beneath(upper), upper):
        heights.append(1.35 * scale.down - 0.40 * scale.aside**2 + 0.12 * own)
        tone = np.clip(0.42 + 0.40 * scale.down + 0.30 * own + 0.25 * sheen, 0.0, 1.0)
        colours.append(ramp(["123a52", "1f6a7c", "3d9c9b", "86c9b4", "d9ead0"], tone))
    rim = smoothstep(1.5 * LIP, 0.4 * LIP, inside)
    below, above = heights[0] - 0.40 * shade, heights[1] + 0.20 * rim
    under = mix(canvas.painted(colours[0]), rgb("0a2434"), 0.70 * shade)
    colour = mix(under, canvas.painted(mix(colours[1], rgb("f0dca0"), 0.45 * rim)), over)
    return Relief(canvas.softened(below + (above - below) * over), canvas.softened(colour))


STYLE = Style(
    name="fish_scales",
    description="round, overlapping scales that shine from deep blue to pale green",
    feature_mm=LENGTH,
    program=fish_scales,
)
