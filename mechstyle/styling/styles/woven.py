"""Threads and strips that cross: wicker, twill, carbon fibre, tartan, and quilted cloth."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas, dome, folded
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, style

STRIP, GAP = 11.0, 2.4
UPRIGHT = 0.40  # width of an upright over the length of a cell


@style("flat strips woven over and under each other like a basket", feature_mm=STRIP)
def basket_weave(canvas: Canvas) -> Relief:
    """Plain weave: level strips pass over every second upright, those of the next row over the others."""
    unit = canvas.unit("gaps between strips", GAP, edges=1.3)
    # A cell is two uprights wide: in its middle the level strip is over, at its ends the upright is.
    bond = canvas.bond(2.0 * STRIP * unit, STRIP * unit, grip=0.6)
    over = np.abs(bond.x) < 0.5 - 0.5 * UPRIGHT
    aside, up = np.where(over, 0.5 * np.abs(bond.x) / (0.5 - 0.5 * UPRIGHT), (0.5 - np.abs(bond.x)) / UPRIGHT), np.abs(bond.y)
    along, across = np.where(over, aside, up), np.where(over, up, aside)
    width = np.where(over, STRIP, 2.0 * UPRIGHT * STRIP)
    # The strip on top bulges and dives under at both ends; beside it shows a gap.
    strip = smoothstep(0.0, GAP, (0.5 - across) * width)
    arch = np.cos(np.pi * along)
    split = np.cos(4.0 * np.pi * across) * over
    identity = canvas.pieces(strip > 0.3, over)
    own, fibre = canvas.random(identity, "tone") - 0.5, canvas.noise(5.0 * unit, 2, "fibre")
    top = -0.40 + 1.05 * arch + 0.15 * strip - 0.14 * split + 0.10 * own + 0.06 * fibre
    tone = 0.22 + 0.25 * over + 0.30 * arch + 0.26 * own + 0.20 * fibre - 0.10 * split
    reed = canvas.painted(ramp(["6b4420", "a3713a", "cfa161", "e8cb96"], tone))
    colour = mix(rgb("3a2411"), reed, strip)
    return Relief(canvas.softened(-0.95 + (0.95 + top) * strip), canvas.softened(colour))


RIB = 10.0


@style("cloth with slanting ribs of plump thread, like denim", feature_mm=RIB)
def twill(canvas: Canvas) -> Relief:
    """Slanting ribs of short plump threads, each a step further than the one below."""
    unit = canvas.unit("ribs of the cloth", RIB, edges=3.0)
    bond = canvas.bond(2.0 * RIB * unit, 2.0 * RIB * unit, shift=0.0)
    rib = 2.0 * (bond.x + bond.y)
    across = 2.0 * folded(rib)
    along = 2.0 * folded((bond.x - bond.y) * 2.0 + 0.5 * np.round(rib))
    plump = (1.0 - across**2) * (0.30 + 0.70 * dome(along))
    faded, heather = canvas.noise(45.0 * unit, 3, "faded"), canvas.noise(6.0 * unit, 2, "heather")
    tone = 0.10 + 0.62 * plump + 0.25 * faded + 0.14 * heather
    colour = ramp(["141f38", "28406c", "4f72a3", "a9bfd8"], tone)
    return Relief(canvas.softened(-1.1 + 2.2 * plump + 0.06 * heather), canvas.softened(canvas.painted(colour)))


TOW = 7.0


@style("black tows of carbon fibre in a twill with slanting steps", feature_mm=2.0 * TOW)
def carbon_fibre(canvas: Canvas) -> Relief:
    """Each tow passes over two and under two, one step further in every row, which gives slanting steps."""
    unit = canvas.unit("tows", TOW, edges=2.6)
    bond = canvas.bond(4.0 * TOW * unit, 4.0 * TOW * unit, shift=0.0)
    x, y = 4.0 * bond.x, 4.0 * bond.y
    column, row = np.floor(x), np.round(y)
    # Four steps of the weave: an upright tow is on top for two rows, of which this is the first or the second.
    step = np.mod(column - row, 4.0)
    upright = (step < 0.5) | (step > 2.5)
    across = np.where(upright, x - column - 0.5, y - row)
    middle = np.where(upright, np.where(step < 0.5, y - row - 0.5, y - row + 0.5), np.where(step < 1.5, x - column - 1.0, x - column))
    arch = np.cos(0.5 * np.pi * np.clip(middle, -1.0, 1.0))
    tow = smoothstep(0.5, 0.36, np.abs(across))
    sheen = canvas.noise(60.0 * unit, 2, "sheen")
    tone = 0.10 + 0.34 * upright + 0.36 * arch * tow + 0.18 * sheen
    colour = ramp(["08090a", "1d1f22", "3c4045", "6d737a"], tone)
    return Relief(canvas.softened(-1.0 + tow * (0.35 + 1.55 * arch) + 0.05 * sheen), canvas.softened(canvas.painted(colour)))


SETT = 40.0


@style("bands and lines of wool woven through each other", feature_mm=0.4 * SETT)
def tartan(canvas: Canvas) -> Relief:
    """Bands and lines of a sett, level and upright, woven through each other in a twill."""
    unit = canvas.unit("lines of the sett", 0.08 * SETT, edges=1.6)
    bond = canvas.bond(SETT * unit, SETT * unit, shift=0.0)
    twill = 0.5 + 0.5 * np.cos(2.0 * np.pi * 6.0 * (bond.x + bond.y))
    away = np.abs(bond.x), np.abs(bond.y)  # from the middle of the sett
    broad = [smoothstep(0.16, 0.19, one) * smoothstep(0.37, 0.34, one) for one in away]
    line = [smoothstep(0.055, 0.030, one) for one in away]
    wool = canvas.noise(6.0 * unit, 2, "wool")
    height = -0.95 + 0.55 * (broad[0] + broad[1]) + 0.85 * np.maximum(*line) + 0.24 * twill + 0.08 * wool
    colour = np.tile(rgb("a3202b"), (len(wool), 1))
    colour = canvas.painted(colour * (1.0 + 0.12 * wool)[:, None])
    for band in broad:
        colour = mix(colour, rgb("14382c"), (0.35 + 0.3 * twill) * band)
    colour = mix(colour, rgb("0e1c26"), 0.85 * broad[0] * broad[1])
    for thread in line:
        colour = mix(colour, rgb("f0d76a"), (0.65 + 0.3 * twill) * thread)
    return Relief(canvas.softened(height), canvas.softened(np.clip(colour, 0.0, 1.0)))


LENGTH, HEIGHT, BUTTON = 24.0, 30.0, 2.9


@style("puffed diamonds between stitched seams, with a button where seams cross", feature_mm=0.5 * HEIGHT)
def quilting(canvas: Canvas) -> Relief:
    """Cushions between slanting seams that pull them down, deepest at the buttons."""
    unit = canvas.unit("buttons", 2.0 * BUTTON, edges=2.4)
    bond = canvas.bond(LENGTH * unit, HEIGHT * unit, shift=0.0, grip=0.6)
    one, other = (1.0 - (1.0 - 2.0 * folded(phase)) ** 2 for phase in (bond.x + bond.y, bond.x - bond.y))
    puff = np.sqrt(one * other)
    # Seams cross in the middle of a cell and at its corners.
    cross = np.minimum(*(np.hypot(x * LENGTH, y * HEIGHT) for x, y in (bond[:2], (0.5 - np.abs(bond.x), 0.5 - np.abs(bond.y)))))
    button = smoothstep(1.15 * BUTTON, 0.80 * BUTTON, cross)
    sag, soft = np.exp(-((cross / (2.3 * BUTTON)) ** 2)), canvas.noise(30.0 * unit, 2, "soft")
    satin = ramp(["52203c", "86365e", "b8608a", "e7b3c9"], 0.12 + 0.66 * puff + 0.15 * soft - 0.15 * sag)
    colour = mix(canvas.painted(satin), rgb("d9b26a"), button)
    height = -0.90 + 1.95 * puff - 0.30 * sag + button * 0.85
    return Relief(canvas.softened(height + 0.05 * soft), canvas.softened(colour))
