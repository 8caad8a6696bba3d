"""What is made of metal, or moulded to be held: tread plate, mail, hull panels, spikes, grips."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import dome
from mechstyle.styling.style import Relief, Style

TREAD, RING, HULL, SPIKE, LUG = 15.0, 16.5, 30.0, 14.0, 24.0
WIRE = 0.115  # radius of the wire over the way from ring to ring


def diamond_plate(canvas: Canvas) -> Relief:
    """Pointed bars on a flat plate, those of neighbouring places at right angles."""
    unit = canvas.unit("bars of the plate", 3.8, edges=2.0)
    bond = canvas.bond(TREAD * unit, 0.5 * TREAD * unit)
    turn = np.where(bond.odd, 1.0, -1.0)
    bars = []
    for x, y, rising in ((bond.x, bond.y, turn), (np.abs(bond.x) - 0.5, 1.0 - np.abs(bond.y), -turn * np.sign(bond.x) * np.sign(bond.y))):
        along, across = np.abs(x + 0.5 * rising * y) * TREAD / 2.0**0.5, np.abs(x - 0.5 * rising * y) * TREAD / 2.0**0.5
        half = 2.3 * np.clip(1.0 - (along / 6.2) ** 2, 0.0, 1.0)  # half the width of a bar between two arcs
        bars.append(dome(across / np.maximum(half, 1e-6)) * smoothstep(0.0, 0.6, half))
    bar = np.max(bars, axis=0)
    worn = canvas.noise(40.0 * unit, 3, "worn")
    scuffs = canvas.noise(4.0 * unit, 2, "scuffs")
    steel = ramp(["6f767c", "99a0a6", "c6cbcf", "f0f2f3"], np.clip(0.25 + 0.65 * bar + 0.15 * worn + 0.12 * scuffs, 0.0, 1.0))
    return Relief(canvas.softened(-0.60 + 1.60 * bar + 0.07 * scuffs), canvas.softened(canvas.painted(steel)))


def chainmail(canvas: Canvas) -> Relief:
    """Rings that lie flat side by side, each linked to its four neighbours by an upright ring that is seen from its edge."""
    unit = canvas.unit("wire of the mail", 2.0 * WIRE * RING, edges=3.6)
    bond = canvas.bond(RING * unit, RING * unit, shift=0.0)
    x, y = np.abs(bond.x), np.abs(bond.y)
    ring = dome((np.hypot(x, y) - 0.37) / WIRE)
    links = []
    for along, across in ((x, y), (y, x)):  # across the gap to the neighbour, and beside that way
        links.append(dome(np.hypot(np.maximum(0.5 - along - 0.11, 0.0), across) / WIRE))
    link = np.maximum(*links)
    oiled = canvas.noise(30.0 * unit, 3, "oiled")
    lift = np.maximum(1.35 * ring, 1.75 * link)
    steel = ramp(["121315", "54595e", "9da3a8", "e6e9eb"], np.clip(0.06 + 0.50 * lift + 0.12 * oiled, 0.0, 1.0))
    return Relief(canvas.softened(-0.95 + 1.15 * lift + 0.05 * oiled), canvas.softened(canvas.painted(steel)))


def panels(canvas: Canvas) -> Relief:
    """The hull of a spaceship: plates cut and cut again, some raised, some slatted, some with bolts."""
    unit = canvas.unit("gaps between panels", 2.6, edges=1.4)
    bond = canvas.bond(HULL * unit, 0.8 * HULL * unit)
    x, y = bond.x, bond.y
    cell = canvas.pieces((np.abs(x) < 0.47) & (np.abs(y) < 0.46), bond.odd)
    wide, high = np.ones_like(x), np.ones_like(y)
    number = cell.astype(np.int64)
    for cut in range(3):  # each time the longer way, at a place of its own; some are left whole
        level = wide * HULL < high * 0.8 * HULL
        share = 0.32 + 0.36 * canvas.random(number, f"place {cut}")
        whole = canvas.random(number, f"whole {cut}") < (0.0, 0.25, 0.45)[cut]
        place = np.where(level, y / high, x / wide) + 0.5
        first = place < share
        part = np.where(whole, 1.0, np.where(first, share, 1.0 - share))
        middle = np.where(whole, 0.5, np.where(first, 0.5 * share, 0.5 + 0.5 * share)) - 0.5
        x, y = np.where(level, x, x - middle * wide), np.where(level, y - middle * high, y)
        wide, high = np.where(level, wide, wide * part), np.where(level, high * part, high)
        number = 2 * number + (first & ~whole)
    u, v = (0.5 * wide - np.abs(x)) * HULL, (0.5 * high - np.abs(y)) * 0.8 * HULL
    plate = smoothstep(0.35, 1.25, np.minimum(u, v))
    own, kind = canvas.random(number, "own") - 0.5, canvas.random(number, "kind")
    slats = (kind < 0.30) * smoothstep(1.6, 2.4, np.minimum(u, v)) * (0.5 + 0.5 * np.cos(2.0 * np.pi * y * 0.8 * HULL / 3.6))
    bolt = (kind > 0.60) * smoothstep(1.7, 0.9, np.hypot(u - 2.6, v - 2.6))
    grime = canvas.noise(18.0 * unit, 3, "grime")
    grey = ramp(["59616a", "8b949c", "b9c0c5", "dde1e3"], np.clip(0.50 + 0.65 * own + 0.20 * grime - 0.25 * slats, 0.0, 1.0))
    height = -1.0 + plate * (1.05 + 0.90 * own - 0.55 * slats) + 0.45 * bolt * plate
    return Relief(canvas.softened(height), canvas.softened(mix(rgb("1b2026"), canvas.painted(grey), plate)))


def spikes(canvas: Canvas) -> Relief:
    """Sharp cones in staggered rows, hollow-flanked, side by side."""
    unit = canvas.unit("spikes", SPIKE, edges=4.5)
    bond = canvas.bond(SPIKE * unit, 0.866 * SPIKE * unit, grip=0.3)
    x, y = np.abs(bond.x) * SPIKE, np.abs(bond.y) * 0.866 * SPIKE
    reach = np.minimum(np.hypot(x, y), np.hypot(0.5 * SPIKE - x, 0.866 * SPIKE - y)) / (0.5 * SPIKE)
    cone = np.clip(1.0 - reach, 0.0, 1.0)
    cloud = canvas.noise(30.0 * unit, 2, "cloud")
    steel = ramp(["1c1d22", "33363d", "5d626b", "b9bec6"], np.clip(0.05 + 0.95 * cone**1.3 + 0.10 * cloud, 0.0, 1.0))
    return Relief(canvas.softened(-0.70 + 2.2 * cone**1.6 + 0.05 * cloud), canvas.softened(canvas.painted(steel)))


def grip(canvas: Canvas) -> Relief:
    """Rubber lugs in chevrons with fine sipes, as on a tyre or the handle of a tool."""
    unit = canvas.unit("grooves of the tread", 3.2, edges=1.6)
    bond = canvas.bond(LUG * unit, 0.5 * LUG * unit, shift=0.0)
    x = np.abs(bond.x)
    slant = bond.y + 0.9 * x  # the lugs of both halves rise to the flanks
    across = np.abs(slant - np.round(slant)) * 0.5 * LUG
    lug = smoothstep(0.5, 1.5, 0.36 * LUG * 0.5 - across + 0.4) * smoothstep(0.6, 1.6, (0.5 - x) * LUG) * smoothstep(0.5, 1.5, x * LUG)
    sipe = smoothstep(0.9, 0.3, np.abs(np.abs(x - 0.25) * LUG - 1.6)) * lug
    worn = canvas.noise(6.0 * unit, 2, "worn")
    rubber = ramp(["0e0f10", "26282a", "45484b"], np.clip(0.15 + 0.65 * lug - 0.30 * sipe + 0.20 * worn, 0.0, 1.0))
    return Relief(canvas.softened(-0.90 + 1.80 * lug - 0.55 * sipe + 0.08 * worn), canvas.softened(canvas.painted(rubber)))


STYLES = {
    style.name: style
    for style in (
        Style(name="diamond_plate", description="steel with pointed bars at right angles", feature_mm=0.6 * TREAD, program=diamond_plate),
        Style(name="chainmail", description="rings of steel linked into mail", feature_mm=14.0, program=chainmail),
        Style(name="panels", description="hull plates of a spaceship, raised, slatted or bolted", feature_mm=0.5 * HULL, program=panels),
        Style(name="spikes", description="sharp cones side by side in staggered rows", feature_mm=1.4 * SPIKE, program=spikes),
        Style(name="grip", description="rubber lugs in chevrons, as on a tyre", feature_mm=0.5 * LUG, program=grip),
    )
}
