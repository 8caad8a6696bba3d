"""Coats and skins of animals: fur, leather, the spots and stripes of big cats, and the patches that hide a soldier."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Canvas, dome, folded
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, style

LOCK, LENGTH, ROSETTE, PATCH, STRIPE, BLOTCH, HATCH = 12.0, 30.0, 17.0, 27.0, 15.0, 40.0, 5.2
DROOP = np.array([1.0, 1.0, 0.22])  # hair hangs down
DRAB = ("2f3324", "8b7f56", "5c6b3a", "3f4d2c")


@style("shaggy locks of hair, hanging over each other", feature_mm=15.0)
def fur(canvas: Canvas) -> Relief:
    """Locks of hair that hang over each other every which way, each drawn out into strands that meet at its tip."""
    unit = canvas.unit("strands", 3.4, edges=1.8)
    spacing = 0.72 * LOCK * unit
    stamps = canvas.stamps(canvas.scattered(spacing, "locks"), spacing, count=12)
    own, whorl = canvas.random(stamps.identity, "own") - 0.5, canvas.noise(45.0 * unit, 2, "whorl")[:, None]
    down = 0.5 - stamps.y / (LENGTH * unit) + 0.16 * own
    sway = 0.5 * own + 0.5 * whorl
    bent = stamps.x / unit - LENGTH * sway * (down - 0.3) * np.abs(down - 0.3)
    half = 0.5 * LOCK * np.clip(3.0 * down, 0.0, 1.0) ** 0.5 * np.clip(1.25 - 1.25 * down, 0.0, 1.0) ** 0.8
    aside = bent / np.maximum(half, 1e-6)
    there = (np.abs(aside) < 1.0) & (down > 0.0) & (down < 1.0) & (stamps.facing > 0.2)
    strand = np.cos(2.0 * np.pi * 2.0 * aside)
    raised = -0.9 + 1.9 * down - 1.3 * aside**2 * smoothstep(0.1, 0.6, down) + 0.85 * strand * np.clip(2.5 * half / LOCK, 0.0, 1.0)
    front = np.where(there, down, -1.0).argmax(axis=1)[:, None]  # tips lie over roots
    height, hair = (np.take_along_axis(field, front, axis=1)[:, 0] for field in (np.where(there, raised, -0.9), strand))
    tone = 0.30 + 0.35 * height + 0.14 * hair
    coat = canvas.painted(ramp(["3b2615", "7a532f", "b98d58", "e8cfa2"], tone))
    return Relief(canvas.softened(np.clip(height, -1.05, 1.1)), canvas.softened(coat))


@style("broken rings of dark raised spots on a golden coat", feature_mm=ROSETTE)
def leopard(canvas: Canvas) -> Relief:
    """Broken rings of raised spots around darker hollows."""
    unit = canvas.unit("spots", 4.2, edges=2.0)
    spots = canvas.stamps(canvas.scattered(ROSETTE * unit, "spots"), ROSETTE * unit)
    own = canvas.random(spots.identity[:, 0], "own")
    uneven, hair = canvas.noise(8.0 * unit, 2, "uneven"), _hair(canvas, unit)
    angle = np.arctan2(spots.y[:, 0], spots.x[:, 0]) + 2.0 * np.pi * own
    reach = np.hypot(spots.x[:, 0], spots.y[:, 0]) / (0.5 * ROSETTE * unit) + 0.28 * uneven
    # Three or four blots a ring, of which those between have grown together here and there.
    blots = 0.5 + 0.5 * np.cos(np.where(own < 0.5, 3.0, 4.0) * angle)
    ring = smoothstep(0.36, 0.20, np.abs(reach - 0.62) + 0.20 * (1.0 - blots)) * smoothstep(0.2, 0.5, spots.facing[:, 0])
    heart = smoothstep(0.62, 0.40, reach) * (1.0 - ring)
    coat = ramp(["b9772c", "d8a252", "ecc98a"], 0.5 + 0.4 * hair + 0.3 * uneven)
    colour = mix(mix(canvas.painted(coat), canvas.painted(coat) * 0.62, heart), rgb("1c120b"), ring)
    return Relief(canvas.softened(-0.60 + 1.55 * ring - 0.35 * heart + 0.14 * hair), canvas.softened(colour))


@style("large angular brown patches between pale lines", feature_mm=PATCH)
def giraffe(canvas: Canvas) -> Relief:
    """Large angular patches with soft ragged borders, close together."""
    unit = canvas.unit("lines between patches", 4.4, edges=2.0)
    warped = canvas.warped(9.0 * unit, 1.8 * unit, "ragged")
    patches = canvas.cells(PATCH * unit, "patches", at=warped)
    hair, own = _hair(canvas, unit), canvas.random(patches.identity, "own") - 0.5
    edge = patches.edge / unit
    patch, middle = smoothstep(1.3, 3.1, edge), smoothstep(3.0, 0.45 * PATCH, edge)
    brown = ramp(["4a2510", "7c421c", "a9652c", "c88a48"], 0.60 - 0.45 * middle + 0.30 * own + 0.20 * hair)
    cream = ramp(["d9bd8c", "f0dcb4"], 0.5 + 0.4 * hair)
    return Relief(
        canvas.softened(-0.90 + patch * (1.45 + 0.35 * middle + 0.20 * own) + 0.14 * hair),
        canvas.softened(mix(cream, canvas.painted(brown), patch)),
    )


@style("black stripes on white that sway, fork and taper", feature_mm=STRIPE)
def zebra(canvas: Canvas) -> Relief:
    """Stripes that sway, fork and taper."""
    unit = canvas.unit("stripes", 0.5 * STRIPE, edges=2.2)
    phase = canvas.points @ np.array([0.30, 0.36, 0.88]) / (STRIPE * unit)
    sway, one, other = (canvas.noise(length * unit, 2, salt) for length, salt in ((70.0, "sway"), (40.0, "one"), (40.0, "other")))
    # Where both noises vanish the angle turns once around: there one stripe more begins.
    wave = np.cos(2.0 * np.pi * (phase + 1.6 * sway) + np.arctan2(other, one))
    full, hair = smoothstep(0.0, 0.10, np.hypot(one, other)), _hair(canvas, unit)
    stripe = smoothstep(-0.22, 0.34, wave * full + 0.25 * canvas.noise(18.0 * unit, 2, "width"))
    white = canvas.painted(ramp(["d8d2c4", "f6f3ea"], 0.5 + 0.5 * hair))
    black = ramp(["0d0c0c", "2a2624"], 0.5 + 0.5 * hair)
    return Relief(canvas.softened(-0.80 + 1.60 * stripe + 0.14 * hair), canvas.softened(mix(white, black, stripe)))


@style("blotches of four drab tones, each hatched its own way", feature_mm=26.0)
def camouflage(canvas: Canvas) -> Relief:
    """Blotches of four tones laid over each other, each a step higher and with a hatch of its own, which is its tone where all is grey."""
    unit = canvas.unit("lines of the hatches", HATCH, edges=4.5)
    bond = canvas.bond(HATCH * unit, HATCH * unit, shift=0.0, grip=0.3)
    upright, level = (0.5 + 0.5 * np.cos(2.0 * np.pi * phase) for phase in (bond.x, bond.y))
    weave = canvas.noise(5.0 * unit, 1, "weave")
    height = -1.0 + 0.80 * level
    colour = np.tile(rgb(DRAB[1]), (len(height), 1))
    hatches = (-0.30 + 0.75 * upright, 0.05 + 0.95 * (upright * level), np.full(len(height), 1.0))
    for hatch, code, threshold in zip(hatches, (DRAB[2], DRAB[3], DRAB[0]), (-0.12, 0.06, 0.20), strict=True):
        field = canvas.noise(BLOTCH * unit, 2, code, at=canvas.points * [1.0, 1.0, 1.35])
        blotch = smoothstep(-0.025, 0.025, field - threshold)
        height += blotch * (hatch - height)
        colour = mix(colour, rgb(code), blotch)
    return Relief(canvas.softened(height), canvas.softened(canvas.painted(colour * (1.0 + 0.10 * weave)[:, None])))


def _hair(canvas: Canvas, unit: float) -> Floats:
    """Noise of short hair, in about [-1, 1], shape [n]."""
    return canvas.noise(5.0 * unit, 2, "hair", at=canvas.points * DROOP)


PEBBLE, WIDE, HIGH, STITCH = 5.4, 88.0, 58.0, 9.0


@style("brown leather with a fine grain, sewn in panels with pale thread", feature_mm=10.0)
def leather(canvas: Canvas) -> Relief:
    """Panels with a fine grain, sewn together: they swell between the seams, and a row of stitches runs on both sides of each."""
    unit = canvas.unit("pebbles of the hide", PEBBLE, edges=3.0)
    grain = canvas.cells(PEBBLE * unit, "grain", at=canvas.warped(6.0 * unit, 1.2 * unit, "grain"))
    cushion = smoothstep(0.0, 0.30 * PEBBLE, grain.edge / unit)
    bond = canvas.bond(WIDE * unit, HIGH * unit, shift=0.0)
    x, y = np.abs(bond.x) * WIDE, np.abs(bond.y) * HIGH
    across, level = 0.5 * WIDE - x, 0.5 * HIGH - y  # ways to the upright and to the level seam
    seam, along = np.minimum(across, level), np.where(across < level, y, x)
    sewn = smoothstep(9.5, 7.5, seam)
    thread = dome(np.hypot((seam - 5.2) / 2.3, STITCH * folded(along / STITCH) / 3.1))
    patina, own = canvas.noise(36.0 * unit, 3, "patina"), canvas.random(grain.identity, "tone") - 0.5
    swell = smoothstep(0.4, 2.4, seam) * (1.0 + 0.35 * smoothstep(12.0, 3.0, seam)) - 0.75 * smoothstep(3.2, 2.0, np.abs(seam - 5.2))
    height = -1.0 + 0.75 * swell + 1.25 * cushion * (1.0 - sewn) + 0.45 * sewn + 1.35 * thread + 0.10 * own * cushion
    tone = 0.30 + 0.36 * cushion + 0.22 * patina + 0.16 * own - 0.30 * (seam < 1.5)
    hide = canvas.painted(ramp(["5a2f1a", "8a4c27", "b06c3c", "d09a66"], tone))
    return Relief(canvas.softened(height), canvas.softened(mix(hide, rgb("ecd9b0"), smoothstep(0.2, 0.5, thread))))
