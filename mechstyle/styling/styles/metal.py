"""What is made of metal, or moulded to be held: hammered, brushed and painted sheets, plates, mail, studs, spikes, grips."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Indices
from mechstyle.styling.drawing.canvas import Canvas, dome, folded
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, style

DENT = 15.0


@style("polished metal beaten into round dents with bright rims", feature_mm=DENT)
def hammered(canvas: Canvas) -> Relief:
    """Round bowls of uneven size, each with its own rim, some across others; flat metal is left between."""
    unit = canvas.unit("dents", DENT, edges=4.5)
    spacing = 0.62 * DENT * unit
    blows = canvas.stamps(canvas.scattered(spacing, "dents"), spacing, count=4)
    blow = canvas.random(blows.identity, "blow")
    reach = np.hypot(blows.x, blows.y) / ((0.34 + 0.12 * blow) * DENT * unit)
    bowls = (1.0 - np.clip(reach, 0.0, 1.0) ** 2) * (0.75 + 0.25 * blow) * smoothstep(0.2, 0.5, blows.facing)
    bowl = bowls.max(axis=1)
    rim = np.max(np.exp(-(((reach - 1.04) / 0.10) ** 2)), axis=1) * smoothstep(0.25, 0.0, bowl)
    cloud = canvas.noise(45.0 * unit, 2, "cloud")
    tone = 0.70 - 0.50 * bowl + 0.20 * rim + 0.12 * cloud
    steel = ramp(["3b424b", "68717b", "9aa2aa", "cbd0d4", "f2f3f2"], tone)
    colour = mix(canvas.painted(steel), rgb("fbfaf5"), 0.55 * rim)
    return Relief(canvas.softened(0.80 - 1.75 * bowl + 0.20 * rim), canvas.softened(colour))


SCRATCH = 3.8


@style("long level scratches on bright metal", feature_mm=2.6 * SCRATCH)
def brushed_metal(canvas: Canvas) -> Relief:
    """Bundles of scratches along the level, coarse and fine, worn through here and there."""
    unit = canvas.unit("scratches", SCRATCH, edges=2.0)
    level = canvas.points * [0.06, 0.06, 1.0]
    fine, coarse = canvas.noise(SCRATCH * unit, 2, "fine", at=level), canvas.noise(2.6 * SCRATCH * unit, 2, "coarse", at=level)
    cut = np.clip(2.6 * fine + 0.6 * coarse, -1.0, 1.0)
    sheen = canvas.noise(55.0 * unit, 2, "sheen", at=canvas.points * [1.0, 1.0, 0.5])
    steel = ramp(["70767c", "9da3a8", "c3c8cb", "eceeee"], 0.52 + 0.38 * cut + 0.25 * sheen)
    return Relief(canvas.softened(0.05 + 1.05 * cut), canvas.softened(canvas.painted(steel)))


LAYER, DROP = 3.4, 15.0


@style("flowing layers and rings of light and dark steel, folded and etched", feature_mm=2.0 * LAYER)
def damascus(canvas: Canvas) -> Relief:
    """Layers of many greys, drilled and forged flat again, which leaves rings; the etch eats the darker steel."""
    unit = canvas.unit("layers", LAYER, edges=2.2)
    x, y, z = canvas.points.T / unit
    pressed = canvas.noise(60.0 * unit, 2, "pressed")
    drops = canvas.stamps(canvas.scattered(2.2 * DROP * unit, "drops"), 2.2 * DROP * unit)
    drop = np.exp(-((drops.x[:, 0] ** 2 + drops.y[:, 0] ** 2) / (0.75 * DROP * unit) ** 2)) * smoothstep(0.0, 0.5, drops.facing[:, 0])
    layer = (0.20 * x + 0.12 * y + 0.97 * z + 9.0 * pressed + 14.0 * drop) / LAYER
    below = np.floor(layer)
    grey = [canvas.random(np.abs(below + step).astype(np.int64), "grey") * 0.15 + 0.85 * ((below + step) % 2) for step in (0.0, 1.0)]
    tone = grey[0] + (grey[1] - grey[0]) * smoothstep(0.25, 0.75, layer - below)
    # Where layers lie too close for the mesh they melt into one grey, as the finest ones of a blade do to the eye.
    tone = 0.5 + (tone - 0.5) * smoothstep(0.85, 0.60, canvas.operators.slope(layer) * canvas.edge)
    brushed = canvas.noise(6.0 * unit, 2, "brushed", at=canvas.points * [1.0, 1.0, 0.3])
    steel = ramp(["2c2f34", "5a5f66", "8b9097", "b9bdc2", "e4e6e7"], 0.04 + 0.92 * tone + 0.07 * brushed)
    return Relief(canvas.softened(-0.90 + 1.9 * tone + 0.05 * brushed), canvas.softened(canvas.painted(steel)))


FLAKE = 16.0


@style("old paint that flakes off rusty metal, with stains running down", feature_mm=FLAKE)
def weathered(canvas: Canvas) -> Relief:
    """A thick, crazed coat of paint with ragged bare patches of rust, rust stains running down from them, and chalky wear."""
    unit = canvas.unit("flakes of paint", 0.3 * FLAKE, edges=2.5)
    broad = canvas.noise(45.0 * unit, 2, "broad")
    chips = canvas.noise(FLAKE * unit, 4, "chips")
    coat = chips + 0.9 * broad + 0.28
    paint = smoothstep(-0.09, 0.09, coat)
    crazed = canvas.cells(13.0 * unit, "crazed", at=canvas.warped(12.0 * unit, 4.0 * unit, "crazed"))
    crack = smoothstep(2.2, 0.7, crazed.edge / unit) * paint
    curl = smoothstep(6.0, 1.6, crazed.edge / unit)  # paint curls up beside a crack
    lip = np.exp(-(((coat - 0.10) / 0.10) ** 2))
    rust = canvas.noise(8.0 * unit, 3, "rust")
    bare = ramp(["3f2018", "6d3320", "9a4d28", "bd7440"], 0.45 + 0.55 * rust)
    bleached = canvas.noise(24.0 * unit, 3, "bleached")
    blue = ramp(["2f6470", "488894", "6ba8ae", "9cc8c6"], 0.5 + 0.45 * bleached + 0.12 * rust)
    stain = smoothstep(0.05, 0.70, canvas.noise(10.0 * unit, 3, "stains", at=canvas.points * [1.0, 1.0, 0.13]))
    near = smoothstep(0.55, 0.05, coat)
    coated = mix(mix(canvas.painted(blue), rgb("8a5a38"), 0.65 * stain * near), rgb("e2ebe4"), 0.55 * lip)
    height = -0.85 + 0.40 * rust + paint * (1.10 + 0.45 * curl + 0.10 * bleached - 0.40 * rust) + 0.30 * lip - 1.20 * crack
    return Relief(canvas.softened(height), canvas.softened(mix(mix(bare, coated, paint), rgb("5d3a26"), 0.7 * crack)))


LENGTH, HEIGHT = 7.6, 9.6


@style("diamond knurling, small pyramids in slanting rows as on the handle of a tool", feature_mm=HEIGHT)
def knurling(canvas: Canvas) -> Relief:
    """Two sets of slanting V grooves leave pyramids, their tips a little worn."""
    unit = canvas.unit("grooves of the knurl", 0.5 * HEIGHT)
    bond = canvas.bond(LENGTH * unit, HEIGHT * unit, shift=0.0)
    pyramid = np.minimum(0.5 - folded(bond.x + bond.y), 0.5 - folded(bond.x - bond.y)) * 2.0
    tip = smoothstep(0.0, 0.85, pyramid)
    worn = canvas.noise(30.0 * unit, 3, "worn")
    colour = ramp(["23262a", "5b6168", "9aa1a8", "dfe3e6"], 0.05 + 0.85 * tip + 0.12 * worn)
    return Relief(canvas.softened(-1.0 + 2.3 * np.minimum(pyramid, 0.9) + 0.05 * worn), canvas.softened(canvas.painted(colour)))


PITCH, STUD = 14.5, 4.9


@style("domed brass studs in staggered rows on dark leather", feature_mm=PITCH)
def studs(canvas: Canvas) -> Relief:
    """Half balls pressed into soft leather, which gives way a little around each."""
    unit = canvas.unit("studs", 2.0 * STUD, edges=4.5)
    stamps = canvas.stamps(_middles(canvas, unit), PITCH * unit)
    x, y, facing = stamps.x[:, 0] / unit, stamps.y[:, 0] / unit, smoothstep(0.2, 0.5, stamps.facing[:, 0])
    reach = np.hypot(x, y) / STUD
    dome = np.sqrt(np.clip(1.0 - reach**2, 0.0, 1.0))
    brass = smoothstep(1.12, 0.84, reach) * facing
    seat = np.exp(-(((reach - 1.15) / 0.24) ** 2)) * facing
    hide, worn = canvas.noise(7.0 * unit, 3, "hide"), canvas.noise(40.0 * unit, 2, "worn")
    own = canvas.random(stamps.identity[:, 0], "tone") - 0.5
    # A bright spot up on the side of each dome, as polish would show under a lamp.
    glint = np.exp(-((x**2 + (y - 0.35 * STUD) ** 2) / (0.40 * STUD) ** 2))
    metal = ramp(["6a4518", "a87a2c", "d8b04e", "f4dc90"], 0.15 + 0.60 * dome + 0.20 * own)
    metal = mix(metal, rgb("fffbe6"), 0.70 * glint)
    leather = ramp(["1e1512", "38261d", "553a2a", "6f4f3a"], 0.42 + 0.40 * hide + 0.25 * worn)
    colour = mix(mix(canvas.painted(leather), rgb("140d0a"), 0.7 * seat), metal, brass)
    height = -0.50 + 0.12 * hide - 0.30 * seat + brass * (0.35 + 1.15 * dome)
    return Relief(canvas.softened(height), canvas.softened(colour))


def _middles(canvas: Canvas, unit: float) -> Indices:
    """Vertices in the middle of the cells of staggered rows, without the cells that an edge or an end of a row cuts."""
    bond = canvas.bond(PITCH * unit, 0.866 * PITCH * unit, grip=0.3)
    reach = np.hypot(bond.x * PITCH, bond.y * 0.866 * PITCH)
    core = reach < 0.8 * STUD
    identity = np.unique(canvas.pieces(core, bond.odd), return_inverse=True)[1]
    order = np.lexsort((reach, identity))
    middle = order[np.unique(identity[order], return_index=True)[1]]
    whole = np.bincount(identity, canvas.mesh.vertex_areas) > 0.7 * np.pi * (0.8 * STUD * unit) ** 2
    return np.asarray(middle[core[middle] & whole], dtype=np.int32)


TREAD, RING, HULL, SPIKE, LUG = 15.0, 16.5, 30.0, 14.0, 24.0
WIRE = 0.115  # radius of the wire over the way from ring to ring


@style("steel with pointed bars at right angles", feature_mm=0.6 * TREAD)
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
    steel = ramp(["6f767c", "99a0a6", "c6cbcf", "f0f2f3"], 0.25 + 0.65 * bar + 0.15 * worn + 0.12 * scuffs)
    return Relief(canvas.softened(-0.60 + 1.60 * bar + 0.07 * scuffs), canvas.softened(canvas.painted(steel)))


@style("rings of steel linked into mail", feature_mm=14.0)
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
    steel = ramp(["121315", "54595e", "9da3a8", "e6e9eb"], 0.06 + 0.50 * lift + 0.12 * oiled)
    return Relief(canvas.softened(-0.95 + 1.15 * lift + 0.05 * oiled), canvas.softened(canvas.painted(steel)))


@style("hull plates of a spaceship, raised, slatted or bolted", feature_mm=0.5 * HULL)
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
    grey = ramp(["59616a", "8b949c", "b9c0c5", "dde1e3"], 0.50 + 0.65 * own + 0.20 * grime - 0.25 * slats)
    height = -1.0 + plate * (1.05 + 0.90 * own - 0.55 * slats) + 0.45 * bolt * plate
    return Relief(canvas.softened(height), canvas.softened(mix(rgb("1b2026"), canvas.painted(grey), plate)))


@style("sharp cones side by side in staggered rows", feature_mm=1.4 * SPIKE)
def spikes(canvas: Canvas) -> Relief:
    """Sharp cones in staggered rows, hollow-flanked, side by side."""
    unit = canvas.unit("spikes", SPIKE, edges=4.5)
    bond = canvas.bond(SPIKE * unit, 0.866 * SPIKE * unit, grip=0.3)
    x, y = np.abs(bond.x) * SPIKE, np.abs(bond.y) * 0.866 * SPIKE
    reach = np.minimum(np.hypot(x, y), np.hypot(0.5 * SPIKE - x, 0.866 * SPIKE - y)) / (0.5 * SPIKE)
    cone = np.clip(1.0 - reach, 0.0, 1.0)
    cloud = canvas.noise(30.0 * unit, 2, "cloud")
    steel = ramp(["1c1d22", "33363d", "5d626b", "b9bec6"], 0.05 + 0.95 * cone**1.3 + 0.10 * cloud)
    return Relief(canvas.softened(-0.70 + 2.2 * cone**1.6 + 0.05 * cloud), canvas.softened(canvas.painted(steel)))


@style("rubber lugs in chevrons, as on a tyre", feature_mm=0.5 * LUG)
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
    rubber = ramp(["0e0f10", "26282a", "45484b"], 0.15 + 0.65 * lug - 0.30 * sipe + 0.20 * worn)
    return Relief(canvas.softened(-0.90 + 1.80 * lug - 0.55 * sipe + 0.08 * worn), canvas.softened(canvas.painted(rubber)))


WAVE, CONE = 12.0, 18.0


@style("upright waves of zinc sheet, with a lap and bolts where sheets meet", feature_mm=WAVE)
def corrugated(canvas: Canvas) -> Relief:
    """A sheet bent into upright waves; each sheet overlaps the one below it, bolted through its crests."""
    unit = canvas.unit("corrugations", WAVE, edges=4.0)
    bond = canvas.bond(WAVE * unit, 5.0 * WAVE * unit, shift=0.0)
    wave = np.cos(2.0 * np.pi * bond.x)
    below = (bond.y + 0.5) * 5.0 * WAVE  # from the lower edge of its sheet
    lap = smoothstep(0.0, 0.8, below) * smoothstep(5.0 * WAVE, 0.6 * WAVE, below)
    bolt = dome(np.clip(np.hypot(bond.x * WAVE, below - 0.45 * WAVE) / (0.16 * WAVE), 0.0, 1.0))
    rust, dull = canvas.noise(40.0 * unit, 4, "rust"), canvas.noise(10.0 * unit, 3, "dull")
    zinc = canvas.painted(ramp(["5d646a", "8b949b", "b7bfc5", "dde3e6"], 0.50 + 0.32 * wave + 0.22 * dull))
    stain = smoothstep(0.25, 0.75, rust) * smoothstep(0.5, -0.4, wave)
    height = 0.85 * wave + 0.22 * lap + 0.5 * bolt - 0.15 + 0.06 * dull
    return Relief(canvas.softened(height), canvas.softened(mix(zinc, rgb("8a4a26"), 0.7 * stain)))


@style("blunt cones in square rows, orange with a pale ring", feature_mm=CONE)
def cones(canvas: Canvas) -> Relief:
    """Cones with blunt tips that stand side by side in square rows."""
    unit = canvas.unit("cones", CONE, edges=4.5)
    bond = canvas.bond(CONE * unit, CONE * unit, shift=0.0, grip=0.3)
    cone = np.clip(1.0 - np.hypot(bond.x, bond.y) / 0.48, 0.0, 0.82) / 0.82
    ring = smoothstep(0.36, 0.42, cone) * smoothstep(0.66, 0.60, cone)
    cloud = canvas.noise(26.0 * unit, 2, "cloud")
    orange = canvas.painted(ramp(["5c2408", "c65312", "ef7a24", "f89a4c"], 0.15 + 0.75 * cone + 0.12 * cloud))
    return Relief(canvas.softened(-0.9 + 1.95 * cone + 0.05 * cloud), canvas.softened(mix(orange, rgb("f4efe6"), ring)))
