"""What columns, curtains and friezes are made of: flutes, pleats, twists, meanders, girih and knotwork."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Bond, Canvas, dome, folded
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, style

FLUTE, PLEAT, TWIST, KEY, STAR = 11.0, 12.0, 19.0, 3.6, 44.0
STRAP = 0.10  # width of a strap over the side of a cell
MEANDER = np.array([list(row) for row in (
    "######", "......", "#####.", "#...#.", "#.#.#.", "#.###.", "#.....", "######", "......",
)]) == "#"  # fmt: skip
"""A period of the frieze from its upper border down, in squares of KEY: the line of the meander winds in and ends."""


@style("upright hollow flutes with narrow fillets between", feature_mm=2.1 * FLUTE)
def fluted(canvas: Canvas) -> Relief:
    """Hollow flutes side by side, upright, that meet in narrow fillets: an Ionic column."""
    unit = canvas.unit("flutes", 0.65 * FLUTE, edges=3.5)
    bond = canvas.bond(FLUTE * unit, 4.0 * FLUTE * unit, shift=0.0)
    hollow = dome(np.clip(2.7 * np.abs(bond.x), 0.0, 1.0))  # flat fillets are left between
    chisel = canvas.noise(9.0 * unit, 3, "chisel")
    tone = 0.90 - 0.45 * hollow + 0.18 * chisel + 0.15 * canvas.noise(50.0 * unit, 2, "sun")
    marble = canvas.painted(ramp(["a59a86", "cfc6b4", "ece6d8", "fbf8f0"], tone))
    return Relief(canvas.softened(0.90 - 1.85 * hollow + 0.06 * chisel), canvas.softened(marble))


@style("cloth folded into upright knife pleats", feature_mm=1.8 * PLEAT)
def pleats(canvas: Canvas) -> Relief:
    """Knife pleats: cloth folded upright, each fold lying on the next, with a sharp crease."""
    unit = canvas.unit("pleats", PLEAT, edges=4.5)
    bond = canvas.bond(PLEAT * unit, 6.0 * PLEAT * unit, shift=0.0)
    sway = canvas.noise(45.0 * unit, 2, "sway", at=canvas.points * [1.0, 1.0, 0.5])
    place = np.mod(bond.x + 0.22 * sway + 0.5, 1.0)
    fold = np.where(place < 0.84, place / 0.84, (1.0 - place) / 0.16)  # rises gently, and falls at once behind the crease
    soft = canvas.noise(14.0 * unit, 2, "soft")
    tone = 0.12 + 0.75 * fold**1.3 + 0.12 * soft
    cloth = canvas.painted(ramp(["5c2340", "93405f", "c97a92", "efc3cd"], tone))
    return Relief(canvas.softened(-0.95 + 1.95 * fold**1.5 + 0.06 * soft), canvas.softened(cloth))


@style("round strands winding upwards around the part", feature_mm=TWIST)
def spiral(canvas: Canvas) -> Relief:
    """Round strands that wind upwards, close together, with a groove between: a twisted column."""
    unit = canvas.unit("grooves of the twist", 0.28 * TWIST, edges=2.0)
    bond = canvas.bond(1.6 * TWIST * unit, 1.15 * TWIST * unit, shift=0.0)
    strand = np.abs(np.cos(np.pi * (bond.x + bond.y)))
    fine = canvas.noise(30.0 * unit, 3, "fine")
    gilt = ramp(["4a3414", "8e6a28", "cfa64c", "f5e2a4"], 0.08 + 0.75 * strand + 0.16 * fine)
    return Relief(canvas.softened(-1.05 + 2.05 * strand**0.7 + 0.06 * fine), canvas.softened(canvas.painted(gilt)))


@style("friezes of a black meander on fired clay", feature_mm=2.0 * KEY)
def greek_key(canvas: Canvas) -> Relief:
    """Friezes of a meander between borders, one above the other."""
    unit = canvas.unit("lines of the meander", KEY, edges=1.9)
    rows, columns = MEANDER.shape
    bond = canvas.bond(columns * KEY * unit, (rows + 1) * KEY * unit, shift=0.0, grip=0.6)
    x, y = (bond.x + 0.5) * columns - 0.5, (0.5 - bond.y) * (rows + 1) - 1.0
    left, above = np.floor(x).astype(int), np.floor(y).astype(int)
    line = np.zeros(len(x))
    for right in (0, 1):
        for down in (0, 1):
            row = above + down
            there = MEANDER[np.clip(row, 0, rows - 1), (left + right) % columns] & (row >= 0) & (row < rows)
            line += there * (1.0 - np.abs(x - left - right)) * (1.0 - np.abs(y - row))
    line = smoothstep(0.30, 0.70, line)
    glaze = canvas.noise(30.0 * unit, 3, "glaze")
    ground = canvas.painted(ramp(["a8542c", "c9753f", "dc9560"], 0.5 + 0.5 * glaze))
    return Relief(canvas.softened(-0.75 + 1.60 * line + 0.07 * glaze), canvas.softened(mix(ground, rgb("1d1614"), line)))


@style("interlaced straps around eight-pointed stars", feature_mm=0.3 * STAR)
def girih(canvas: Canvas) -> Relief:
    """Straps that cross over and under each other and leave eight-pointed stars and crosses."""
    unit = canvas.unit("straps", STRAP * STAR, edges=3.2)
    bond = canvas.bond(STAR * unit, STAR * unit, shift=0.0)
    over, under = girih_straps(bond)
    x, y = np.abs(bond.x), np.abs(bond.y)
    square, turned = np.maximum(x, y), (x + y) / 2.0**0.5  # each below 8^-½ within one of the two squares that make a large star
    star = smoothstep(0.205, 0.180, np.minimum(square, turned))
    inside, either = (8.0**-0.5 - reach(square, turned) for reach in (np.maximum, np.minimum))
    point = smoothstep(0.0, 0.03, either) * smoothstep(0.02, -0.01, inside)
    top, low = (smoothstep(0.5 * STRAP + 0.010, 0.5 * STRAP - 0.020, away) for away in (over, under))
    dive = smoothstep(0.5 * STRAP + 0.07, 0.5 * STRAP + 0.02, over)
    strap = np.maximum(top, low)
    lift = np.maximum(np.maximum(1.90 * top, low * (1.75 - 0.90 * dive)), 0.95 * point) + 1.75 * star
    glaze = canvas.noise(18.0 * unit, 3, "glaze")
    blue = ramp(["0f3f55", "14667c", "2d93a0"], 0.5 + 0.6 * glaze)
    white = canvas.painted(ramp(["b7a888", "e8dcc2", "fbf5e6"], 0.25 + 0.35 * lift + 0.15 * glaze))
    return Relief(canvas.softened(-0.90 + lift + 0.06 * glaze), canvas.softened(mix(mix(blue, rgb("d9a441"), star), white, strap)))


def girih_straps(bond: Bond) -> tuple[Floats, Floats]:
    """Lines of the star and cross pattern: a square in each cell, and diagonals through the middles of its sides.

    Returns:
        Distance from the middle of the strap on top and from that of the other [cells], shape [n] each.
    """
    x, y = np.abs(bond.x), np.abs(bond.y)
    half = 8.0**-0.5  # of the square's side: with the diagonals it makes a star of eight equal points
    diagonals = [folded(bond.x + way * bond.y + 0.5) / 2.0**0.5 for way in (-1.0, 1.0)]
    lines = np.stack([np.abs(np.maximum(x, y) - half), *diagonals])
    first, second = np.argsort(lines, axis=0)[:2]
    # So that over and under alternate along every strap: on level sides the square is over the rising diagonal and under the falling one,
    # on upright sides the other way round; where diagonals cross, the falling one is over at the flanks of a cell.
    rises = np.where((first != 0) & (second != 0), x <= y, np.abs(y - half) >= np.abs(x - half))
    rank, here = np.stack([np.ones(len(x)), 2.0 * rises, 2.0 * ~rises]), np.arange(len(x))
    swap = rank[first, here] < rank[second, here]
    return lines[np.where(swap, second, first), here], lines[np.where(swap, first, second), here]


CELL, KNOT_BAND = 46.0, 0.32  # a cell holds eight crossings; width of a band over the distance of crossings along it


@style("golden bands that pass over and under each other and turn back without an end", feature_mm=0.3 * CELL)
def celtic_knot(canvas: Canvas) -> Relief:
    """Slanting bands with a furrow along their middle, the lower one diving under the upper one where they cross."""
    unit = canvas.unit("bands of the knot", 0.35 * KNOT_BAND * CELL, edges=2.2)
    over, under, away = interlaced(canvas.bond(CELL * unit, CELL * unit, shift=0.0))
    top, low = (smoothstep(0.5 * KNOT_BAND + 0.04, 0.5 * KNOT_BAND - 0.04, aside) for aside in (over, under))
    dive = smoothstep(0.5 * KNOT_BAND + 0.20, 0.5 * KNOT_BAND + 0.05, over)
    furrow = smoothstep(0.05, 0.0, np.where(top > 0.5, over, under))
    band = np.maximum(top, low)
    arch = top * (1.65 + 0.35 * smoothstep(0.5, 0.0, away))
    lift = np.maximum(arch, low * (1.65 - 1.10 * dive)) - 0.35 * furrow * band
    patina = canvas.noise(30.0 * unit, 3, "patina")
    ground = ramp(["0f2a22", "1c4a3a", "2f6b54"], 0.5 + 0.5 * patina)
    gold = canvas.painted(ramp(["7a5a1c", "b88d34", "e2c067", "f6e6b0"], 0.05 + 0.45 * lift + 0.15 * patina))
    return Relief(canvas.softened(-1.0 + lift + 0.05 * patina), canvas.softened(mix(ground, gold, band)))


def interlaced(bond: Bond) -> tuple[Floats, Floats, Floats]:
    """Two sets of slanting bands, eight crossings a cell; at two of these they are cut and joined to arcs, which closes them to knots.

    Returns:
        Distance from the middle of the upper band, from that of the lower one (infinite where bands turn), and along the upper band
        from the middle of their crossing, over the distance of crossings, shape [n] each.
    """
    rise, fall = 2.0 * (bond.x + bond.y), 2.0 * (bond.x - bond.y)
    a, b = rise - np.round(rise), fall - np.round(fall)
    x, y = 0.5 * (np.round(rise) + np.round(fall)), 0.5 * (np.round(rise) - np.round(fall))  # of the crossing, in half cells
    odd = np.mod(np.round(2.0 * x), 2.0) == 1.0
    over, under = np.where(odd, np.abs(b), np.abs(a)), np.where(odd, np.abs(a), np.abs(b))
    # In the middle of a cell's upper side bands are turned back upwards and downwards, in the middle of its flank to the sides.
    level, upright = (x == 0.0) & (np.abs(y) == 1.0), (np.abs(x) == 1.0) & (y == 0.0)
    over, under = np.where(level, _arcs(a, -b), np.where(upright, _arcs(a, b), over)), np.where(level | upright, np.inf, under)
    return over, under, np.minimum(under, 0.5)


def _arcs(a: Floats, b: Floats) -> Floats:
    """Distance from two quarter circles of radius ½ around opposite corners of the square from -½ to ½."""
    return np.asarray(np.minimum(np.abs(np.hypot(a - 0.5, b - 0.5) - 0.5), np.abs(np.hypot(a + 0.5, b + 0.5) - 0.5)))
