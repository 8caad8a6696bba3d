"""Rows that lie over each other: scales, feathers, waves and fans."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas, beneath, fans, folded, hanging, own_of_scales
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, style

DRAGON_LENGTH, DRAGON_HEIGHT, DRAGON_LIP = 20.0, 14.0, 3.2


@style("large pointed scales with a keel and gilded rims, overlapping like armour", feature_mm=DRAGON_LENGTH)
def dragon_scales(canvas: Canvas) -> Relief:
    """Pointed scales, each with a keel down its middle, laid over the two below it."""
    unit = canvas.unit("lips of scales", DRAGON_LIP, edges=1.6)
    bond = canvas.bond(DRAGON_LENGTH * unit, DRAGON_HEIGHT * unit, grip=0.3)
    upper = hanging(bond)
    inside = 0.62 * DRAGON_HEIGHT * ((1.0 - upper.aside) ** 0.75 * (1.0 + 0.35 * upper.aside) - upper.down)
    over = smoothstep(-0.25 * DRAGON_LIP, 0.25 * DRAGON_LIP, inside)
    rim = smoothstep(1.6 * DRAGON_LIP, 0.7 * DRAGON_LIP, inside)
    shade = smoothstep(-1.3 * DRAGON_LIP, 0.0, inside)
    own = own_of_scales(canvas, bond, inside, "tone")
    horn = canvas.noise(6.0 * unit, 2, "horn")

    heights, colours = [], []
    for scale in (beneath(upper), upper):
        keel = smoothstep(0.34, 0.0, scale.aside) * smoothstep(-1.0, 0.3, scale.down) * smoothstep(1.1, 0.5, scale.down)
        heights.append(0.95 * scale.down - 0.25 * scale.aside**2 + 0.60 * keel - 0.25 + 0.06 * horn + 0.10 * own)
        body = ramp(["2a0d12", "64161d", "9c2723", "c64d2c"], 0.40 + 0.30 * scale.down + 0.30 * own + 0.12 * horn)
        colours.append(canvas.painted(mix(body, rgb("e2b04c"), 0.35 * keel)))
    # The lip stands off and leaves a gap above the scale it covers.
    below, above = heights[0] - 0.45 * shade, heights[1] + 0.50 * rim
    colour = mix(mix(colours[0], rgb("1a080a"), 0.80 * shade), mix(colours[1], rgb("e2b04c"), 0.65 * rim), over)
    return Relief(canvas.softened(below + (above - below) * over), canvas.softened(colour))


FISH_LENGTH, FISH_HEIGHT, FISH_LIP = 18.0, 10.0, 3.2


@style("round, overlapping scales that shine from deep blue to pale green", feature_mm=FISH_LENGTH)
def fish_scales(canvas: Canvas) -> Relief:
    """Scales laid like roof tiles: each hangs over the roots of the two below it and stands off most at its round tip."""
    unit = canvas.unit("lips of scales", FISH_LIP, edges=1.6)
    bond = canvas.bond(FISH_LENGTH * unit, FISH_HEIGHT * unit, grip=0.3)
    upper = hanging(bond)
    inside = FISH_HEIGHT * (1.0 - np.hypot(*upper))
    over = smoothstep(-0.25 * FISH_LIP, 0.25 * FISH_LIP, inside)
    shade = smoothstep(-1.2 * FISH_LIP, 0.0, inside)
    own = own_of_scales(canvas, bond, inside, "tone")
    sheen = canvas.noise(40.0 * unit, 2, "sheen")

    heights, colours = [], []
    for scale in (beneath(upper), upper):
        heights.append(1.35 * scale.down - 0.40 * scale.aside**2 + 0.12 * own)
        tone = np.clip(0.42 + 0.40 * scale.down + 0.30 * own + 0.25 * sheen, 0.0, 1.0)
        colours.append(ramp(["123a52", "1f6a7c", "3d9c9b", "86c9b4", "d9ead0"], tone))
    rim = smoothstep(1.5 * FISH_LIP, 0.4 * FISH_LIP, inside)
    below, above = heights[0] - 0.40 * shade, heights[1] + 0.20 * rim
    under = mix(canvas.painted(colours[0]), rgb("0a2434"), 0.70 * shade)
    colour = mix(under, canvas.painted(mix(colours[1], rgb("f0dca0"), 0.45 * rim)), over)
    return Relief(canvas.softened(below + (above - below) * over), canvas.softened(colour))


FEATHER_LENGTH, FEATHER_HEIGHT, FEATHER_LIP, BARB = 23.0, 17.0, 3.4, 4.6


@style("feathers laid over each other in rows, with shafts and slanting barbs", feature_mm=FEATHER_HEIGHT)
def feathers(canvas: Canvas) -> Relief:
    """Long rounded feathers hang over those below; barbs leave the shaft to both sides."""
    unit = canvas.unit("barbs", BARB)
    bond = canvas.bond(FEATHER_LENGTH * unit, FEATHER_HEIGHT * unit, grip=0.3)
    upper = hanging(bond)
    inside = 0.70 * FEATHER_HEIGHT * ((1.0 - upper.aside**1.7) ** 0.8 - upper.down)
    over = smoothstep(-0.25 * FEATHER_LIP, 0.25 * FEATHER_LIP, inside)
    shade = smoothstep(-1.2 * FEATHER_LIP, 0.0, inside)
    own = own_of_scales(canvas, bond, inside, "tone")
    worn = canvas.noise(40.0 * unit, 2, "worn")
    heights, colours = [], []
    for feather in (beneath(upper), upper):
        shaft = smoothstep(0.16, 0.05, feather.aside)
        barb = np.cos(2.0 * np.pi * (feather.down * FEATHER_HEIGHT + 0.55 * feather.aside * FEATHER_LENGTH) / BARB) * (1.0 - shaft)
        heights.append(0.90 * feather.down - 0.35 * feather.aside**2 + 0.45 * shaft + 0.22 * barb - 0.10 + 0.05 * worn)
        tone = np.clip(0.40 + 0.28 * feather.down + 0.40 * own + 0.10 * barb, 0.0, 1.0)
        vane = canvas.painted(ramp(["2b2f55", "3f5f8f", "5f9aa6", "c9d6b8"], tone))
        colours.append(mix(vane, rgb("f3ead2"), 0.75 * shaft))
    below, above = heights[0] - 0.50 * shade, heights[1] + 0.15 * smoothstep(1.5 * FEATHER_LIP, 0.5 * FEATHER_LIP, inside)
    colour = mix(mix(colours[0], rgb("12152b"), 0.75 * shade), colours[1], over)
    return Relief(canvas.softened(below + (above - below) * over), canvas.softened(colour))


WAVE_RADIUS, ARCS = 18.0, 3


@style("overlapping rounds of waves in blue with crests of foam, as on Japanese cloth", feature_mm=WAVE_RADIUS / ARCS * 1.5)
def waves(canvas: Canvas) -> Relief:
    """Rows of half rounds, every row in front of the one above it; the arcs of a round are crests, the outermost foams."""
    unit = canvas.unit("arcs of waves", WAVE_RADIUS / (ARCS + 0.5), edges=2.6)
    bond = canvas.bond(2.0 * WAVE_RADIUS * unit, 0.5 * WAVE_RADIUS * unit, grip=0.3)
    here, _ = fans(bond)
    arc = (1.0 - here) * (ARCS + 0.5)
    crest = 0.5 + 0.5 * np.cos(2.0 * np.pi * (arc - 0.5))
    foam = smoothstep(1.0, 0.7, arc)
    swell = canvas.noise(50.0 * unit, 2, "swell")
    spray = canvas.noise(6.0 * unit, 2, "spray")
    tone = 0.08 + 0.45 * crest + 0.22 * swell + 0.30 * here * crest
    sea = canvas.painted(ramp(["0f2c52", "1c4f82", "3a86b4", "8cc4d8"], tone))
    colour = mix(sea, rgb("f4f2e6"), crest * (0.35 + 0.65 * foam) * (1.0 + 0.15 * spray))
    return Relief(canvas.softened(-0.95 + 1.45 * crest + 0.60 * here + 0.08 * spray), canvas.softened(colour))


FAN_RADIUS, RAYS = 21.0, 5  # raised rays of a fan


@style("overlapping fans of golden rays on black", feature_mm=0.5 * FAN_RADIUS)
def art_deco(canvas: Canvas) -> Relief:
    """Half rounds in staggered rows, each with a rim, rays that widen outwards, and a boss at its foot."""
    unit = canvas.unit("rays of the fans", 0.28 * FAN_RADIUS, edges=2.4)
    bond = canvas.bond(2.0 * FAN_RADIUS * unit, 0.5 * FAN_RADIUS * unit, grip=0.3)
    here, angle = fans(bond)
    rim = smoothstep(0.80, 0.86, here)
    gap = smoothstep(0.70, 0.74, here) * smoothstep(0.84, 0.80, here)
    sector = np.pi / RAYS
    ray = smoothstep(0.32, 0.22, folded(angle / sector)) * smoothstep(0.30, 0.36, here) * (1.0 - smoothstep(0.68, 0.74, here))
    boss = smoothstep(0.26, 0.20, here)
    gilt = np.max([rim, ray, boss], axis=0)
    gleam = canvas.noise(50.0 * unit, 2, "gleam")
    gold = ramp(["8a6420", "c79a3c", "ecd089"], 0.40 + 0.35 * here + 0.25 * gleam)
    black = canvas.painted(np.tile(rgb("17191f"), (len(here), 1)))
    height = -0.55 + 1.10 * gilt + 0.45 * rim - 0.35 * gap + 0.20 * boss + 0.05 * gleam
    return Relief(canvas.softened(height), canvas.softened(mix(black, gold, gilt)))
