"""What has grown, dried or molten in the ground: crystal, marble, mud, ice, cut glass and lava."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas, dome
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, style

SHARD = 25.0  # length of a crystal
STRETCH = np.array([1.0, 1.0, 0.6])  # crystals are longer upwards


@style("crystals grown side by side, flat facets that meet in sharp ridges", feature_mm=SHARD)
def crystal(canvas: Canvas) -> Relief:
    """Every shard rises to a roof of flat faces, of its own height."""
    unit = canvas.unit("facets", 0.3 * SHARD, edges=2.2)
    shards = canvas.cells(0.7 * SHARD * unit, "shards", stretch=STRETCH)
    own = canvas.random(shards.identity, "height")
    facet = canvas.random(shards.facet, "facet")
    edge = shards.edge / (0.7 * SHARD * unit)
    height = -0.85 + (1.3 + 0.4 * own) * np.minimum(edge / 0.36, 1.1) + 0.42 * (own - 0.5)
    tone = 0.10 + 0.70 * facet + 0.25 * own
    colour = canvas.painted(ramp(["3a1f63", "6d3fa6", "a67ad2", "e4d2f5"], tone))
    colour = mix(colour, rgb("f4ecff"), 0.5 * smoothstep(0.34, 0.42, edge))
    return Relief(canvas.softened(height), canvas.softened(mix(colour, rgb("2a1548"), smoothstep(0.05, 0.0, edge))))


VEIN = 4.0
# Distance of the sheets [mm], direction across them, how far they bend [sheets] and over which length [mm], width of the veins.
SHEETS = (
    (52.0, (0.55, 0.35, 0.76), 0.85, 60.0, 1.25 * VEIN), (34.0, (-0.70, 0.40, 0.59), 0.95, 48.0, VEIN),
    (26.0, (0.30, -0.75, 0.59), 0.95, 42.0, 0.75 * VEIN),
)  # fmt: skip


@style("polished white marble with grey veins that cross and fade", feature_mm=24.0)
def marble(canvas: Canvas) -> Relief:
    """Bent sheets of grey minerals cut by the surface: few broad veins and finer ones across them, all fading here and there."""
    unit = canvas.unit("veins", VEIN, edges=2.2)
    cloud = canvas.noise(60.0 * unit, 3, "cloud")
    uneven = canvas.noise(34.0 * unit, 2, "uneven")
    veins = []
    for apart, across, bend, length, width in SHEETS:
        sheet = canvas.points @ np.array(across) / (apart * unit) + bend * canvas.noise(length * unit, 2, f"sheet {apart}")
        away = np.abs(sheet - np.round(sheet)) / np.maximum(canvas.softened(canvas.operators.slope(sheet)), 0.3 / (apart * unit))
        there = smoothstep(-0.60, 0.0, canvas.noise(40.0 * unit, 2, f"there {apart}"))
        veins.append(there * smoothstep(0.80 * width * unit, 0.0, away))
    vein = np.max([veins[0], 0.8 * veins[1], 0.6 * veins[2]], axis=0)
    halo = canvas.smoothed(vein, 7.0 * unit)
    sunk = canvas.smoothed(vein, 3.0 * unit)
    white = ramp(["b4b8be", "dadbde", "f0efec", "faf8f3"], 0.82 + 0.35 * cloud - 0.85 * halo)
    colour = mix(canvas.painted(white), rgb("565b64"), 0.85 * vein)
    colour = mix(colour, rgb("b8995f"), 0.50 * halo * smoothstep(0.0, 0.4, cloud))
    return Relief(canvas.softened(0.55 + 0.20 * uneven - 1.40 * vein - 0.45 * sunk), canvas.softened(colour))


MUD_PLATE, CRACK = 22.0, 3.4


@style("dried mud in plates with curled rims and deep cracks between", feature_mm=MUD_PLATE)
def cracked_earth(canvas: Canvas) -> Relief:
    """Plates whose rims dried first and curled up; finer cracks end within them."""
    unit = canvas.unit("cracks", CRACK, edges=1.6)
    plates = canvas.cells(MUD_PLATE * unit, "plates", at=canvas.warped(16.0 * unit, 4.0 * unit, "outline"))
    edge = plates.edge / unit
    plate = smoothstep(0.20 * CRACK, 0.80 * CRACK, edge)
    fine = canvas.cells(0.62 * MUD_PLATE * unit, "fine", at=canvas.warped(14.0 * unit, 3.0 * unit, "fine outline"))
    there = smoothstep(0.45, 0.55, canvas.random(plates.identity, "split")) * plate
    split = smoothstep(0.65 * CRACK, 0.15 * CRACK, fine.edge / unit) * there
    curl = smoothstep(0.40 * MUD_PLATE, 0.7 * CRACK, edge)
    own, dust = canvas.random(plates.identity, "tone") - 0.5, canvas.noise(9.0 * unit, 4, "dust")
    top = 0.10 + 0.55 * curl + 0.35 * own + 0.18 * dust - 0.65 * split
    tone = 0.52 + 0.30 * own + 0.22 * curl + 0.28 * dust
    mud = canvas.painted(ramp(["80604a", "a78364", "c8a888", "e2cbae"], tone))
    dark = np.maximum(1.0 - plate, 0.75 * split)
    return Relief(canvas.softened(-1.0 + (1.0 + top) * plate), canvas.softened(mix(mud, rgb("382417"), dark)))


ICICLE, CUT, LAVA_PLATE = 11.0, 26.0, 30.0


@style("icicles hanging in rows from a frozen sheet", feature_mm=1.8 * ICICLE)
def ice(canvas: Canvas) -> Relief:
    """Ledges of ice with icicles below, round and pointed, each of its own length and width."""
    unit = canvas.unit("icicles", 0.6 * ICICLE, edges=2.2)
    bond = canvas.bond(ICICLE * unit, 2.7 * ICICLE * unit, shift=0.37, grip=0.6)
    frost, bent = canvas.noise(7.0 * unit, 2, "frost"), canvas.noise(14.0 * unit, 2, "bent")
    column = canvas.pieces((np.abs(bond.x) < 0.42) & (np.abs(bond.y) < 0.44), bond.odd)
    own = canvas.random(column, "own") * (np.abs(bond.x) < 0.42)
    down = 0.5 - bond.y
    tip = np.clip((0.55 + 0.42 * own - down) / (0.45 + 0.42 * own), 0.0, 1.0)  # 0 where it ends, 1 near the ledge
    width = (0.36 + 0.14 * own) * tip**0.8
    aside = np.abs(bond.x + 0.10 * bent * down) / np.maximum(width, 1e-3)
    icicle = dome(aside) * smoothstep(0.0, 0.10, width) * (0.60 + 0.40 * tip)
    ledge = dome(np.clip(np.abs(down - 0.09 - 0.05 * bent) / (0.14 + 0.03 * frost), 0.0, 1.0))
    body = np.maximum(icicle, 0.95 * ledge)
    blue = ramp(["4f93bd", "8cc4e0", "cbe8f4", "f6fcfe"], 0.14 + 0.72 * body + 0.16 * frost)
    return Relief(canvas.softened(-0.85 + 1.80 * body + 0.10 * frost), canvas.softened(canvas.painted(blue)))


@style("cut glass, stars of sharp rays in diamonds", feature_mm=0.5 * CUT)
def glass(canvas: Canvas) -> Relief:
    """Cut glass: crossing grooves part diamonds, and each is cut into a star of sharp rays."""
    unit = canvas.unit("cuts", 4.0, edges=2.0)
    bond = canvas.bond(CUT * unit, 1.35 * CUT * unit, shift=0.5)
    ax, ay = np.abs(bond.x), np.abs(bond.y)
    beyond = ax + ay > 0.5  # the corners of a cell belong to the diamonds between
    x, y = np.where(beyond, 0.5 - ax, ax), np.where(beyond, 0.5 - ay, ay)
    edge = (0.5 - x - y) * 0.8 * CUT
    angle = np.arctan2(y, x)
    ray = np.abs(np.cos(4.0 * angle))
    reach = np.clip(np.hypot(x, y) / 0.36, 0.0, 1.0)
    star = ray * smoothstep(0.0, 0.35, reach) * smoothstep(1.0, 0.75, reach) - 0.9 * smoothstep(0.9, 0.0, reach) * (1.0 - ray)
    groove = smoothstep(3.0, 0.0, edge)
    flow = canvas.noise(45.0 * unit, 2, "flow")
    height = 0.35 + 0.75 * star - 1.35 * groove + 0.06 * flow
    tone = 0.45 + 0.40 * star - 0.30 * groove + 0.25 * flow
    return Relief(canvas.softened(height), canvas.softened(canvas.painted(ramp(["5f9aa0", "a5d0d2", "d9eeee", "fbffff"], tone))))


@style("a dark ropy crust with fire in its cracks", feature_mm=LAVA_PLATE)
def lava(canvas: Canvas) -> Relief:
    """A crust that wrinkled into ropes as it flowed and broke into plates, with fire between."""
    unit = canvas.unit("ropes of lava", 5.0, edges=2.2)
    plates = canvas.cells(LAVA_PLATE * unit, "plates", at=canvas.warped(22.0 * unit, 6.0 * unit, "outline"))
    edge = plates.edge / unit
    crust = smoothstep(1.2, 4.0, edge + 0.8 * canvas.noise(8.0 * unit, 2, "ragged"))
    bend = canvas.noise(26.0 * unit, 2, "bend")
    turn = 2.0 * np.pi * canvas.random(plates.identity, "turn")
    slope = canvas.points @ np.array([[1.0, 0.2], [0.3, -0.2], [0.1, 1.0]])
    rope = np.abs(np.sin(np.pi * ((slope[:, 0] * np.cos(turn) + slope[:, 1] * np.sin(turn)) / (6.5 * unit) + 1.7 * bend)))
    rough = canvas.noise(6.0 * unit, 2, "rough")
    height = -1.05 + crust * (0.75 + 0.95 * rope + 0.22 * rough + 0.15 * smoothstep(3.0, 12.0, edge))
    basalt = ramp(["141213", "2a2526", "4a4142"], 0.10 + 0.60 * rope + 0.25 * rough)
    fire = ramp(["b3200a", "f0590e", "fdb52b", "fff0a0"], smoothstep(4.5, 0.0, edge) + 0.15 * rough)
    return Relief(canvas.softened(height), canvas.softened(mix(fire, canvas.painted(basalt), crust)))


SHERD, SEAM = 40.0, 3.0


@style("a broken glazed bowl mended with seams of gold", feature_mm=0.6 * SHERD)
def kintsugi(canvas: Canvas) -> Relief:
    """Large sherds of a dark glaze, each a little out of line, whose cracks are filled with raised gold."""
    unit = canvas.unit("seams of gold", SEAM, edges=1.6)
    sherds = canvas.cells(SHERD * unit, "sherds", at=canvas.warped(22.0 * unit, 4.0 * unit, "break"))
    edge = canvas.smoothed(sherds.edge, 0.5 * unit) / unit
    seam = dome(np.clip(edge / (0.75 * SEAM), 0.0, 1.0))
    own, glaze = canvas.random(sherds.identity, "tone") - 0.5, canvas.noise(24.0 * unit, 4, "glaze")
    bowl = canvas.painted(ramp(["10232b", "1f3d47", "35606b", "5b8b92"], 0.45 + 0.35 * own + 0.35 * glaze))
    gold = ramp(["8a5f17", "cf9f37", "f6dd8c"], 0.2 + 0.8 * seam + 0.2 * glaze)
    height = -0.75 + 0.5 * own + 0.12 * glaze + 1.7 * seam
    return Relief(canvas.softened(height), canvas.softened(mix(bowl, gold, smoothstep(0.15, 0.45, seam))))
