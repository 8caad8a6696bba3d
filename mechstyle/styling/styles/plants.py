"""What grows: leaves, flowers, moss and the ribs of a cactus."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Canvas, dome
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, style

RIB, PITCH, SPINE = 18.0, 11.0, 7.0


@style("upright green ribs with clusters of pale spines along their ridges", feature_mm=RIB)
def cactus(canvas: Canvas) -> Relief:
    """Ribs an even number around, areoles on the ridges, staggered from rib to rib."""
    unit = canvas.unit("spines", 4.0)
    # Cells two ribs wide and half a pitch high, in running bond: their centres are the areoles of staggered ribs.
    bond = canvas.bond(2.0 * RIB * unit, 0.5 * PITCH * unit)
    beside = np.abs(2.0 * bond.x) > 0.5
    x = (np.abs(bond.x) - np.where(beside, 0.5, 0.0)) * 2.0 * RIB
    y = (np.abs(bond.y) - np.where(beside, 1.0, 0.0)) * 0.5 * PITCH
    ridge = 1.0 - np.abs(2.0 * x / RIB) ** 1.4  # sharp valleys between round ribs
    tubercle = ridge * np.cos(2.0 * np.pi * y / PITCH)  # every cluster sits on a swelling of its rib
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    reach = SPINE * (0.35 + 0.65 * np.cos(3.0 * angle) ** 2)
    star = smoothstep(1.0, 0.45, radius / reach)
    wool = smoothstep(3.2, 1.4, radius)
    skin = canvas.noise(9.0 * unit, 3, "skin")
    tone = 0.12 + 0.75 * ridge + 0.22 * skin
    green = ramp(["14401f", "266b33", "46964a", "86bd66"], tone)
    colour = mix(mix(canvas.painted(green), rgb("f6eecb"), star), rgb("b0813f"), wool)
    height = -0.95 + 0.95 * ridge + 0.50 * tubercle + 0.50 * star + 0.45 * wool + 0.06 * skin
    return Relief(canvas.softened(height), canvas.softened(colour))


FLORAL_SPACING, FLOWER, FLORAL_LEAF = 29.0, 16.0, 26.0
PETALS = ("c8385f", "e88aa6", "f4b640", "f6efe2", "8f63b8", "e2663c")


@style("open flowers of many colours on a bed of leaves", feature_mm=FLORAL_SPACING)
def floral(canvas: Canvas) -> Relief:
    """A bed of leaves, and on it flowers with five or six petals, each turned and coloured its own way."""
    unit = canvas.unit("petals", 6.0, edges=2.5)
    colour, height = _leaves(canvas, unit)
    points = canvas.scattered(FLORAL_SPACING * unit, "flowers", room=0.8 * FLOWER * unit)
    flowers = canvas.stamps(points, FLORAL_SPACING * unit, count=3)
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
    leaves = canvas.stamps(canvas.scattered(0.5 * FLORAL_LEAF * unit, "leaves"), 0.5 * FLORAL_LEAF * unit, count=5)
    turn = 2.0 * np.pi * canvas.random(leaves.identity, "turn")
    along = (leaves.x * np.cos(turn) + leaves.y * np.sin(turn)) / (FLORAL_LEAF * unit) + 0.5
    across = np.abs(leaves.y * np.cos(turn) - leaves.x * np.sin(turn)) / (0.25 * FLORAL_LEAF * unit)
    inside = np.sin(np.pi * np.clip(along, 0.0, 1.0)) - across
    here = smoothstep(0.25, 0.50, leaves.facing)
    blade, shadow = smoothstep(-0.10, 0.20, inside) * here, smoothstep(-0.45, -0.05, inside) * (np.abs(along - 0.5) < 0.5) * here
    for k in range(blade.shape[1]):
        green = ramp(["2c5d36", "46813f", "73a552"], canvas.random(leaves.identity[:, k], "age"))
        green = mix(green, rgb("a9c97c"), 0.7 * smoothstep(0.22, 0.0, across[:, k]))
        colour = mix(mix(colour, 0.5 * colour, shadow[:, k]), green, blade[:, k])
        height += blade[:, k] * (-0.55 + 0.35 * along[:, k] - 0.30 * across[:, k] - height)
    return colour, height


GREEN_SPACING, GREEN_LEAF, WIDTH = 13.0, 27.0, 17.0


@style("overlapping leaves in many greens, their tips standing off", feature_mm=WIDTH)
def green(canvas: Canvas) -> Relief:
    """Leaves hanging every which way, mostly down, laid over each other from the lowest to the uppermost."""
    unit = canvas.unit("leaf tips", 4.0)
    points = canvas.scattered(GREEN_SPACING * unit, "leaves")
    stamps = canvas.stamps(points, GREEN_SPACING * unit, count=8)
    x, y = stamps.x / unit, stamps.y / unit
    turn = np.pi * (1.5 + 0.9 * (canvas.random(stamps.identity, "turn") - 0.5))
    along = (x * np.cos(turn) + y * np.sin(turn)) / GREEN_LEAF + 0.45
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


MOSS_LEAF, MOUND = 4.6, 22.0
SIZES = (1.0, 0.6)  # of the generations of cushions over the largest


@style("round green cushions of moss, rough with small leaves", feature_mm=0.9 * MOUND)
def moss(canvas: Canvas) -> Relief:
    """Round cushions side by side with dark gaps between, each of them all small leaves that stand on end."""
    unit = canvas.unit("leaves of moss", MOSS_LEAF, edges=2.4)
    mound = np.zeros(len(canvas.points))
    for size in SIZES:
        spacing = size * MOUND * unit
        stamps = canvas.stamps(canvas.scattered(spacing, f"cushions {size}"), spacing, count=3)
        radius = (0.50 + 0.16 * canvas.random(stamps.identity, "radius")) * spacing
        cushions = dome(np.hypot(stamps.x, stamps.y) / radius) * smoothstep(0.2, 0.5, stamps.facing)
        mound = np.maximum(mound, (0.25 + 0.75 * size) * cushions.max(axis=1))
    leaves = canvas.cells(MOSS_LEAF * unit, "leaves")
    leaf, own = np.clip(leaves.edge / (0.48 * MOSS_LEAF * unit), 0.0, 1.0), canvas.random(leaves.identity, "own") - 0.5
    damp = canvas.noise(35.0 * unit, 3, "damp")
    tone = 0.05 + 0.50 * mound + 0.25 * leaf + 0.25 * own + 0.20 * damp
    colour = ramp(["1d2c10", "3f5a1c", "6c8a2c", "a3b84e", "cbd27c"], tone)
    height = -1.1 + 1.00 * mound + (0.45 + 0.75 * mound) * leaf * (0.9 + 0.3 * own)
    return Relief(canvas.softened(height), canvas.softened(canvas.painted(colour)))
