"""Large pointed scales with a keel, overlapping like armour."""

from __future__ import annotations

import numpy as np

from mechstyle.stylize.canvas import Canvas
from mechstyle.stylize.style import Relief, Style
from mechstyle.stylize.tones import mix, ramp, rgb, smoothstep

LENGTH, HEIGHT, LIP = 20.0, 14.0, 3.2


def dragon_scales(canvas: Canvas) -> Relief:
    """Pointed scales, each with a keel down its middle, laid over the two below it."""
    unit = canvas.unit("lips of scales", LIP, edges=1.6)
    bond = canvas.bond(LENGTH * unit, HEIGHT * unit, grip=0.3)
    # Of the scale hanging from this row: how far aside and down a place is, 1 at its flank and its tip.
    aside, down = 2.0 * np.abs(bond.x), 0.5 - bond.y
    inside = 0.62 * HEIGHT * ((1.0 - aside) ** 0.75 * (1.0 + 0.35 * aside) - down)
    over = smoothstep(-0.5 * LIP, 0.5 * LIP, inside)
    identity = canvas.pieces(np.abs(inside) > 0.3 * LIP, bond.odd ^ (inside > 0.0))
    own = canvas.random(identity, "tone") - 0.5
    horn = canvas.noise(6.0 * unit, 2, "horn")

    # Where the scale above ends, the one below it shows, half a scale aside and a row down.
    aside, down = np.where(inside > 0.0, [aside, down], [1.0 - aside, down - 1.0])
    keel = smoothstep(0.30, 0.0, aside) * smoothstep(-1.0, 0.3, down)
    height = 0.95 * down - 0.60 * aside + 0.45 * keel + 0.06 * horn + 0.10 * own
    rim = smoothstep(2.0 * LIP, 0.3 * LIP, np.where(inside > 0.0, inside, np.inf))
    shadow = smoothstep(-1.6 * LIP, 0.0, inside) * (1.0 - over)
    tone = np.clip(0.40 + 0.30 * down + 0.30 * own + 0.12 * horn, 0.0, 1.0)
    colour = ramp(["2a0d12", "64161d", "9c2723", "c64d2c"], tone)
    colour = mix(colour, rgb("e2b04c"), np.maximum(0.55 * rim, 0.35 * keel))
    colour = mix(canvas.painted(colour), rgb("1a080a"), 0.65 * shadow)
    return Relief(canvas.softened(height), canvas.softened(colour))


STYLE = Style(
    name="dragon_scales",
    words=("dragon", "reptile", "reptilian", "lizard", "snake", "snakeskin"),
    description="large pointed scales with a keel and gilded rims, overlapping like armour",
    feature_mm=HEIGHT,
    program=dragon_scales,
)
