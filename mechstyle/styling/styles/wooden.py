"""Wood in its forms: boards with their grain, inlays, bark, bamboo and cork."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Canvas, dome
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, style

RING, KNOT, TAPER = 9.0, 10.0, 0.50
PITH = np.array([8.0, 16.0])  # of the trunk, to the right of the part's middle and before its front [nominal mm]


@style("plain-sawn wood with the dark arches of its year rings, fine fibres and a few knots", feature_mm=1.8 * RING)
def wood(canvas: Canvas) -> Relief:
    """A piece cut from a trunk that grew upwards before it."""
    unit = canvas.unit("dark lines of the grain", 0.36 * RING)
    late, fibre, knot = grain(canvas, unit)
    board = canvas.noise(50.0 * unit, 2, "board")
    tone = 0.68 - 0.48 * late + 0.30 * fibre + 0.16 * board
    colour = mix(ramp(["5b3416", "8a5628", "b57c43", "d0a069", "e3bd8a"], tone), rgb("4a2810"), 0.8 * knot)
    # Brushed, as a carpenter brushes oak: early wood is worn away, late wood stands.
    return Relief(canvas.softened(-0.85 + 1.75 * late + 0.45 * fibre + 0.30 * knot), canvas.softened(canvas.painted(colour)))


def grain(canvas: Canvas, unit: float) -> tuple[Floats, Floats, Floats]:
    """Late wood in [0, 1], hard and dark, noise of the fibres in about [-1, 1], and hearts of knots in [0, 1], shape [n] each."""
    upright = canvas.points * [1.0, 1.0, 0.28]
    low, high = canvas.points.min(axis=0), canvas.points.max(axis=0)
    x, y, z = ((canvas.points - [0.5 * (low[0] + high[0]), low[1], low[2]]) / unit).T
    knots = canvas.stamps(canvas.scattered(78.0 * unit, "knots"), 78.0 * unit)
    around = np.hypot(knots.x[:, 0], 0.6 * knots.y[:, 0]) / (KNOT * unit)
    # A trunk gets thinner upwards, so that a saw cuts its rings into arches.
    year = (np.hypot(x - PITH[0], y + PITH[1]) + TAPER * z) / RING
    year += 0.70 * canvas.noise(42.0 * unit, 2, "growth", at=upright) + 1.8 * np.exp(-(around**2))
    through = year - np.floor(year)
    # Dark wood builds up slowly through a year and ends at once.
    late = smoothstep(0.15, 0.75, through) * smoothstep(1.0, 0.80, through)
    fibre = canvas.noise(6.0 * unit, 2, "fibre", at=canvas.points * [1.0, 1.0, 0.12])
    return canvas.softened(late), fibre, smoothstep(0.60, 0.25, around)


RADIUS = 32.0
# Rings of petals: inner and outer radius over that of the mandala, number of petals, colours of every other petal.
RINGS = ((0.12, 0.54, 8, ("e8a32e", "e8a32e")), (0.42, 0.80, 8, ("c8323f", "c8323f")), (0.76, 1.00, 16, ("2c9c9c", "efc94c")))


@style("round mandalas of coloured petals, inlaid in mahogany", feature_mm=15.0)
def mandala(canvas: Canvas) -> Relief:
    """Mandalas apart from each other and from sharp edges, their inner rings over the outer ones."""
    unit = canvas.unit("petals", 6.0, edges=2.5)
    late, fibre, _ = grain(canvas, unit)
    tone = 0.55 - 0.42 * late + 0.28 * fibre
    colour = canvas.painted(ramp(["2c0f0a", "541d12", "7c3120", "9c4a30"], tone))
    height = -0.75 + 0.35 * late + 0.10 * fibre

    radius = RADIUS * unit
    stamps = canvas.stamps(canvas.scattered(2.05 * radius, "mandalas", room=0.9 * radius), 2.05 * radius)
    reach, angle = np.hypot(stamps.x, stamps.y)[:, 0] / radius, np.arctan2(stamps.y, stamps.x)[:, 0]
    level = smoothstep(0.25, 0.50, stamps.facing[:, 0])
    # A sunken disc, on which petals stand apart.
    height += smoothstep(1.06, 1.00, reach) * level * (-1.0 - height)
    for ring, (inner, outer, count, hues) in reversed(list(enumerate(RINGS))):
        turn = angle * count / (2.0 * np.pi) + 0.5 * (ring % 2)
        petal = np.round(turn)
        out = np.clip((reach - inner) / (outer - inner), 0.0, 1.0)
        inside = np.sin(np.pi * out) ** 0.65 - 2.1 * np.abs(turn - petal)
        cover = smoothstep(0.02, 0.22, inside) * level
        gap = smoothstep(-0.35, 0.0, inside) * level * (out > 0.0) * (out < 1.0)
        body = np.where((petal % 2 == 0)[:, None], rgb(hues[0]), rgb(hues[1])) * (0.70 + 0.38 * smoothstep(0.1, 0.9, inside))[:, None]
        colour = mix(mix(colour, 0.45 * colour, gap), body, cover)
        height += gap * (-0.95 - height)
        # A petal is a shallow dish with a raised rim.
        height += cover * (0.75 - 0.45 * smoothstep(0.35, 0.65, inside) + 0.12 * (2 - ring) - height)
    eye = smoothstep(0.21, 0.15, reach) * level
    return Relief(canvas.softened(height + eye * (1.1 - height)), canvas.softened(np.clip(mix(colour, rgb("f3ead2"), eye), 0.0, 1.0)))


PLATE = 25.0
STRETCH = np.array([1.0, 1.0, 0.40])  # plates are longer upwards


@style("long plates of bark between deep, branching furrows", feature_mm=PLATE)
def bark(canvas: Canvas) -> Relief:
    """Furrows wind upwards and meet; finer ones split the plates between, and a few cracks run across."""
    unit = canvas.unit("furrows", 0.15 * PLATE, edges=2.0)
    broad = np.abs(canvas.noise(PLATE * unit, 2, "furrows", at=canvas.points * STRETCH))
    narrow = np.abs(canvas.noise(0.45 * PLATE * unit, 2, "splits", at=canvas.points * STRETCH))
    across = np.abs(canvas.noise(0.55 * PLATE * unit, 2, "cracks", at=canvas.points * [0.6, 0.6, 1.0]))
    plate, split, crack = smoothstep(0.0, 0.22, broad), smoothstep(0.0, 0.22, narrow), smoothstep(0.0, 0.16, across)
    scaly = canvas.noise(6.0 * unit, 2, "scaly")
    height = -1.1 + 0.90 * plate + plate * (0.65 * split + 0.55 * crack) + 0.10 * scaly
    tone = 0.05 + 0.42 * plate + 0.28 * split + 0.20 * crack + 0.22 * scaly
    colour = mix(rgb("20150d"), canvas.painted(ramp(["3a2819", "64482f", "917255", "c2aa88"], tone)), smoothstep(0.0, 0.5, plate))
    return Relief(canvas.softened(height), canvas.softened(colour))


CANE, JOINT = 14.0, 24.0


@style("upright green canes side by side, with rings at their joints", feature_mm=CANE)
def bamboo(canvas: Canvas) -> Relief:
    """Round upright canes whose joints stand higher in every second one; above each joint a pale bloom."""
    unit = canvas.unit("gaps between canes", 0.28 * CANE)
    # Cells two canes wide: one cane in the middle, one half at either side, with its joints half a section higher.
    bond = canvas.bond(2.0 * CANE * unit, JOINT * unit, shift=0.0)
    beside = np.abs(bond.x) > 0.25
    across = 4.0 * np.where(beside, 0.5 - np.abs(bond.x), np.abs(bond.x))
    up = np.where(beside, bond.y - np.copysign(0.5, bond.y), bond.y) * JOINT
    cane = dome(across)
    # A joint is a sheath that stands off, a groove under it, and a swelling below.
    ring = smoothstep(0.2, 1.6, up) * smoothstep(6.5, 2.5, up) + 0.7 * smoothstep(-1.2, -2.6, up) * smoothstep(-7.5, -3.5, up)
    groove = np.exp(-(((up + 0.4) / 1.3) ** 2))
    identity = canvas.pieces((across < 0.85) & (np.abs(up) > 0.6), beside)
    own = canvas.random(identity, "tone") - 0.5
    fibre = canvas.noise(6.0 * unit, 2, "fibre", at=canvas.points * [1.0, 1.0, 0.15])
    bloom = smoothstep(9.0, 2.0, up) * (up > 0.0)
    tone = 0.15 + 0.60 * cane + 0.35 * own + 0.16 * fibre
    colour = ramp(["4a5a20", "7f8d35", "b1b254", "d6cd80"], tone)
    colour = mix(mix(colour, rgb("ece3b4"), 0.55 * bloom + 0.25 * ring * cane), rgb("5a4a22"), 0.75 * groove)
    colour = mix(rgb("2a2c12"), canvas.painted(colour), smoothstep(0.05, 0.55, cane))
    height = -0.95 + 1.20 * cane + smoothstep(0.0, 0.6, cane) * (1.05 * ring - 1.25 * groove) + 0.06 * fibre
    return Relief(canvas.softened(height), canvas.softened(np.clip(colour, 0.0, 1.0)))


GRAIN = 7.0


@style("granules of cork pressed together", feature_mm=2.1 * GRAIN)
def cork(canvas: Canvas) -> Relief:
    """Granules of many sizes pressed together, some fallen out."""
    unit = canvas.unit("granules of cork", GRAIN, edges=3.0)
    warped = canvas.warped(6.0 * unit, 1.2 * unit, "granules")
    grains = canvas.cells(GRAIN * unit, "granules", at=warped)
    own, lost = canvas.random(grains.identity, "own") - 0.5, canvas.random(grains.identity, "lost") < 0.09
    edge = grains.edge / (GRAIN * unit)
    grain, dust = smoothstep(0.0, 0.18, edge), canvas.noise(4.0 * unit, 2, "dust")
    height = -0.35 + 0.70 * grain + 0.90 * own + 0.36 * dust - 0.95 * lost * grain
    tone = 0.55 + 0.45 * own + 0.25 * dust - 0.35 * (1.0 - grain) - 0.5 * lost
    return Relief(canvas.softened(height), canvas.softened(canvas.painted(ramp(["4f321b", "96683c", "c99a63", "e3c091"], tone))))
