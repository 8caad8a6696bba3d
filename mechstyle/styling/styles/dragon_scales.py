"""Large pointed scales with a keel, overlapping like armour."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import beneath, hanging, own_of_scales
from mechstyle.styling.style import Relief, Style

LENGTH, HEIGHT, LIP = 20.0, 14.0, 3.2


def dragon_scales(canvas: Canvas) -> Relief:
    """Pointed scales, each with a keel down its middle, laid over the two below it."""
    unit = canvas.unit("lips of scales", LIP, edges=1.6)
    bond = canvas.bond(LENGTH * unit, HEIGHT * unit, grip=0.3)
    upper = hanging(bond)
    inside = 0.62 * HEIGHT * ((1.0 - upper.aside) ** 0.75 * (1.0 + 0.35 * upper.aside) - upper.down)
    over = smoothstep(-0.25 * LIP, 0.25 * LIP, inside)
    rim = smoothstep(1.6 * LIP, 0.7 * LIP, inside)
    shade = smoothstep(-1.3 * LIP, 0.0, inside)
    own = own_of_scales(canvas, bond, inside, "tone")
    horn = canvas.noise(6.0 * unit, 2, "horn")

    heights, colours = [], []
    for scale in (beneath(upper), upper):
        keel = smoothstep(0.34, 0.0, scale.aside) * smoothstep(-1.0, 0.3, scale.down) * smoothstep(1.1, 0.5, scale.down)
        heights.append(0.95 * scale.down - 0.25 * scale.aside**2 + 0.60 * keel - 0.25 + 0.06 * horn + 0.10 * own)
        body = ramp(["2a0d12", "64161d", "9c2723", "c64d2c"], np.clip(0.40 + 0.30 * scale.down + 0.30 * own + 0.12 * horn, 0.0, 1.0))
        colours.append(canvas.painted(mix(body, rgb("e2b04c"), 0.35 * keel)))
    # The lip stands off and leaves a gap above the scale it covers.
    below, above = heights[0] - 0.45 * shade, heights[1] + 0.50 * rim
    colour = mix(mix(colours[0], rgb("1a080a"), 0.80 * shade), mix(colours[1], rgb("e2b04c"), 0.65 * rim), over)
    return Relief(canvas.softened(below + (above - below) * over), canvas.softened(colour))


STYLE = Style(
    name="dragon_scales",
    description="large pointed scales with a keel and gilded rims, overlapping like armour",
    feature_mm=LENGTH,
    program=dragon_scales,
)
