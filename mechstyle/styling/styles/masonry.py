"""What walls, floors and roofs are made of: brick, stone, concrete, plaster, tiles, shingles, parquet."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas, folded
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, style

LENGTH, HEIGHT, JOINT = 22.0, 10.0, 3.4


@style("courses of fired brick in running bond with recessed, light mortar", feature_mm=HEIGHT)
def brick(canvas: Canvas) -> Relief:
    """Level courses of one size, each brick with its own tone, set and wear."""
    unit = canvas.unit("mortar joints", JOINT, edges=1.6)
    length, height, joint = LENGTH * unit, HEIGHT * unit, JOINT * unit
    bond = canvas.bond(length, height, margin=0.75 * joint, grip=0.1)
    wear = canvas.noise(7.0 * unit, 2, "wear")
    to_joint = np.minimum((0.5 - np.abs(bond.x)) * length, (0.5 - np.abs(bond.y)) * height) + 0.10 * joint * wear
    face = smoothstep(0.20 * joint, 0.80 * joint, to_joint)

    identity = canvas.pieces(face > 0.5, bond.odd)
    tone = canvas.random(identity, "tone")
    bricks = 0.60 + 0.35 * canvas.random(identity, "set") + 0.22 * wear
    mortar = -0.65 + 0.10 * canvas.noise(4.0 * unit, 2, "mortar")
    fired = ramp(["7a3026", "96402f", "a84a34", "b55a3e", "c67d58"], tone + 0.22 * wear)
    fired = fired * (1.0 + 0.14 * wear)[:, None]
    grime = 1.0 + 0.12 * canvas.noise(30.0 * unit, 3, "grime")
    colour = mix(rgb("d9d1c2"), canvas.painted(fired), smoothstep(0.25, 0.75, face)) * grime[:, None]
    return Relief(canvas.softened(mortar + (bricks - mortar) * face), canvas.softened(np.clip(colour, 0.0, 1.0)))


STONE, GAP = 15.0, 3.4


@style("field stones set close, rounded and rough, with dark gaps", feature_mm=STONE)
def stone(canvas: Canvas) -> Relief:
    """Worley cells with broken outlines, each a stone of its own height, tilt and tone."""
    unit = canvas.unit("gaps between stones", GAP, edges=1.6)
    cells = canvas.cells(STONE * unit, "stones", at=canvas.warped(14.0 * unit, 3.2 * unit, "outline"))
    edge = cells.edge / unit
    face = smoothstep(0.25 * GAP, 1.0 * GAP, edge)
    rounding = smoothstep(0.3 * GAP, 0.55 * STONE, edge)
    rough = canvas.noise(7.0 * unit, 4, "rough")
    grain = canvas.noise(3.5 * unit, 2, "grain")
    own = canvas.random(cells.identity, "height")
    top = 0.10 + 0.35 * own + 0.55 * rounding + 0.28 * rough
    tone = 0.5 + 0.55 * (canvas.random(cells.identity, "tone") - 0.5) + 0.30 * rough + 0.15 * grain
    cool = ramp(["5d6064", "84878a", "a8aaaa", "cfcfca"], tone)
    warm = ramp(["65584a", "8f806c", "b3a48d", "d6cab4"], tone)
    body = mix(cool, warm, smoothstep(0.35, 0.65, canvas.random(cells.identity, "hue")))
    colour = mix(rgb("4b453d"), canvas.painted(body), face)
    return Relief(canvas.softened(-0.85 + (0.85 + top) * face), canvas.softened(colour))


BOARD, SEAM, HOLE = 17.0, 2.8, 3.6


@style("grey concrete with the print of boards, pores and round tie holes", feature_mm=BOARD)
def concrete(canvas: Canvas) -> Relief:
    """Every board stood a little differently; grout ran out between them and stands as a seam."""
    unit = canvas.unit("seams between boards", SEAM, edges=1.6)
    bond = canvas.bond(4.0 * BOARD * unit, BOARD * unit, margin=0.5 * SEAM * unit, grip=0.3)
    off = np.minimum((0.5 - np.abs(bond.y)) * BOARD, (0.5 - np.abs(bond.x)) * 4.0 * BOARD)
    seam = smoothstep(0.85 * SEAM, 0.25 * SEAM, off)
    identity = canvas.pieces(off > 0.5 * SEAM, bond.odd)
    own, tone = canvas.random(identity, "set") - 0.5, canvas.random(identity, "tone") - 0.5
    grain = canvas.noise(8.0 * unit, 2, "grain", at=canvas.points * [0.22, 0.22, 1.0])
    pore = smoothstep(0.36, 0.50, canvas.noise(8.0 * unit, 2, "pores"))
    tie = np.hypot(bond.x * 4.0 * BOARD, bond.y * BOARD)
    hole, ring = smoothstep(1.1 * HOLE, 0.7 * HOLE, tie), np.exp(-(((tie - 1.35 * HOLE) / (0.35 * HOLE)) ** 2))
    stain = canvas.noise(40.0 * unit, 3, "stain")
    height = 0.05 + 0.80 * own + 0.50 * grain + 0.75 * seam - 0.95 * pore + 0.20 * ring - 1.25 * hole
    grey = ramp(["6f6f6c", "96958f", "b5b3ab", "d0cec5"], 0.5 + 0.30 * stain + 0.30 * tone + 0.20 * grain)
    colour = mix(canvas.painted(grey), rgb("4c4b48"), np.maximum(0.55 * pore, 0.80 * hole))
    return Relief(canvas.softened(np.clip(height, -1.1, 1.3)), canvas.softened(colour))


@style(
    "worn, hand-finished plaster: strokes of a trowel, pits, cracks and bare patches, dirt in the hollows, stains running down",
    feature_mm=21.0,
)
def realistic(canvas: Canvas) -> Relief:
    """Strokes of a trowel, pits, cracks, and patches where the coat has fallen off; colour follows shape as dirt and wear do."""
    unit = canvas.unit("cracks", 3.4)
    broad = canvas.noise(40.0 * unit, 2, "broad")
    lumps = canvas.noise(7.5 * unit, 3, "lumps")
    strokes = canvas.cells(24.0 * unit, "strokes", at=canvas.warped(18.0 * unit, 7.0 * unit, "strokes"))
    ridge = smoothstep(3.0, 0.4, strokes.edge / unit)
    cracks = canvas.cells(55.0 * unit, "cracks", at=canvas.warped(18.0 * unit, 9.0 * unit, "cracks"))
    there = smoothstep(0.05, 0.35, canvas.noise(45.0 * unit, 2, "where cracked"))
    crack = smoothstep(2.6, 0.6, cracks.edge / unit) * there
    pit = smoothstep(0.31, 0.49, canvas.noise(8.5 * unit, 2, "pits"))
    worn = smoothstep(0.22, 0.32, canvas.noise(30.0 * unit, 4, "worn"))
    coat = 0.35 + 0.50 * (canvas.random(strokes.identity, "stroke") - 0.5) + 0.45 * ridge + 0.15 * broad + 0.90 * lumps - 0.90 * pit
    height = 0.8 * canvas.softened(np.clip(coat - 1.10 * crack + worn * (-0.70 + 0.90 * lumps - coat), -1.6, 1.6))

    around = canvas.smoothed(height, 8.0 * unit)
    dirt = smoothstep(0.0, 0.8, around - height)
    rubbed = smoothstep(0.05, 0.6, height - around)
    streak = smoothstep(0.0, 0.8, canvas.noise(11.0 * unit, 3, "streaks", at=canvas.points * [1.0, 1.0, 0.15]))
    colour = ramp(["b29c7c", "c7b393", "d8c8ab", "e4d8c0"], 0.5 + 0.35 * broad + 0.35 * lumps)
    colour = mix(colour, rgb("b58a6b"), 0.65 * worn)
    colour = mix(colour, rgb("96876d"), 0.45 * streak)
    colour = mix(colour, rgb("f2eadb"), 0.45 * rubbed)
    colour = mix(canvas.painted(colour), rgb("6b5d4a"), np.maximum(0.60 * dirt, 0.75 * crack))
    return Relief(height, colour)


BAND, WAVE = 36.0, 22.0


@style("thrown, fired clay with finger rings, grooves and waves drawn on bands of pale slip", feature_mm=12.0)
def terracotta(canvas: Canvas) -> Relief:
    """Every band has fine throwing rings, two grooves, and between these a wave drawn into the wet clay."""
    unit = canvas.unit("grooves", 3.6)
    bond = canvas.bond(WAVE * unit, BAND * unit, shift=0.0, grip=0.5)
    up = bond.y * BAND
    rings = (1.0 - 4.0 * folded(up / (BAND / 6.0)) ** 2 * 2.0) * smoothstep(9.0, 11.0, np.abs(up))  # sharp between the fingers' hollows
    groove = np.exp(-(((np.abs(up) - 7.6) / 1.5) ** 2))
    wave = np.exp(-(((up - 3.0 * np.cos(2.0 * np.pi * bond.x)) / 1.6) ** 2))
    slip = smoothstep(6.6, 5.0, np.abs(up))
    lumps = canvas.noise(24.0 * unit, 3, "lumps")
    grit = canvas.noise(5.0 * unit, 2, "grit")
    fire = canvas.noise(50.0 * unit, 2, "fire")
    bloom = smoothstep(0.10, 0.75, canvas.noise(26.0 * unit, 4, "bloom"))
    cut = np.maximum(groove, wave * slip)
    clay = ramp(["8a4228", "b25a36", "c97248", "dd9468"], 0.52 + 0.35 * fire + 0.18 * grit + 0.16 * rings)
    clay = mix(canvas.painted(clay), rgb("eed9bf"), 0.72 * slip)
    colour = mix(mix(clay, rgb("f0dfca"), 0.40 * bloom * (1.0 - slip)), rgb("7a351f"), 0.85 * cut)
    height = 0.10 + 0.62 * rings + 0.15 * lumps + 0.08 * grit + 0.50 * slip - 1.45 * cut
    return Relief(canvas.softened(height), canvas.softened(colour))


BLOCK, TILE, SHINGLE, CHIP = 8.0, 20.0, 15.0, 12.0
LONG = 3  # length of a block of parquet over its width


@style("parquet of oak blocks at right angles", feature_mm=2.0 * BLOCK)
def herringbone(canvas: Canvas) -> Relief:
    """Blocks three times as long as wide, laid at right angles to each other, the end of each against the flank of the next."""
    unit = canvas.unit("joints of the parquet", 2.2, edges=1.2)
    diagonal = 2.0**0.5
    bond = canvas.bond(LONG * diagonal * BLOCK * unit, diagonal * BLOCK * unit, shift=0.0)
    # On the lattice of the blocks, turned by 45°: place [blocks' widths] counted so that the middle of a cell is that of a block.
    a, b = LONG * bond.x + bond.y + 0.5 * LONG, bond.y - LONG * bond.x + 0.5
    step = np.mod(np.floor(a) - np.floor(b), 2 * LONG)
    rising = step >= LONG
    along = np.where(rising, 2 * LONG - 1 - step + np.mod(b, 1.0), step + np.mod(a, 1.0)) - 0.5 * LONG
    across = np.mod(np.where(rising, a, b), 1.0) - 0.5
    to_joint = BLOCK * np.minimum(0.5 * LONG - np.abs(along), 0.5 - np.abs(across))
    face = smoothstep(0.15, 1.15, to_joint)
    own = canvas.random(canvas.pieces(to_joint > 0.6, rising), "own") - 0.5
    grain = np.where(rising, canvas.noise(4.0 * unit, 2, "rising"), canvas.noise(4.0 * unit, 2, "falling")) * 0.5
    grain += 0.4 * np.cos(2.0 * np.pi * (2.0 * across + 0.8 * own + 0.12 * canvas.noise(12.0 * unit, 2, "bend")))
    oak = ramp(["5a351a", "8a5a2e", "b98449", "dcb47c"], 0.52 + 0.55 * own + 0.16 * rising + 0.16 * grain)
    height = -1.0 + face * (1.55 + 0.55 * own + 0.12 * grain)
    return Relief(canvas.softened(height), canvas.softened(mix(rgb("2c190c"), canvas.painted(oak), face)))


@style("glazed octagons with small blue squares between, in pale grout", feature_mm=TILE)
def tiles(canvas: Canvas) -> Relief:
    """Octagons with a small square in the corner of every four, glazed, in pale grout."""
    unit = canvas.unit("joints between tiles", 3.2, edges=1.6)
    bond = canvas.bond(TILE * unit, TILE * unit, shift=0.0, margin=0.0)
    x, y = np.abs(bond.x) * TILE, np.abs(bond.y) * TILE
    octagon = np.minimum(0.5 * TILE - np.maximum(x, y), (0.72 * TILE - x - y) / 2.0**0.5)
    square = (x + y - 0.72 * TILE) / 2.0**0.5
    small = square > 0.0
    inside = np.where(small, square, octagon)
    glaze = smoothstep(0.6, 2.0, inside)
    own = canvas.random(canvas.pieces(inside > 1.0, small), "own") - 0.5
    crackle = canvas.noise(16.0 * unit, 3, "glaze")
    pillow = smoothstep(0.8, 0.30 * TILE, inside)
    white = ramp(["cfd8da", "e9eeee", "fbfcfa"], 0.45 + 0.5 * own + 0.30 * pillow + 0.20 * crackle)
    blue = ramp(["16345c", "245a94", "3f82bd"], 0.5 + 0.6 * own + 0.20 * crackle)
    colour = mix(rgb("a89f90"), mix(canvas.painted(white), blue, small.astype(float)), glaze)
    return Relief(canvas.softened(-1.0 + glaze * (1.35 + 0.30 * pillow + 0.30 * own + 0.50 * small)), canvas.softened(colour))


@style("split boards on a roof, each over two others", feature_mm=SHINGLE)
def shingles(canvas: Canvas) -> Relief:
    """Split boards on a roof: each lies on the two below it, of its own length, with gaps between."""
    unit = canvas.unit("gaps between shingles", 2.6, edges=1.3)
    bond = canvas.bond(SHINGLE * unit, 1.15 * SHINGLE * unit, grip=0.3)
    split = canvas.noise(4.0 * unit, 2, "split", at=canvas.points * [1.0, 1.0, 0.15])
    gap = (0.5 - np.abs(bond.x)) * SHINGLE
    board = smoothstep(0.25, 1.25, gap)
    own = canvas.random(canvas.pieces((gap > 0.6) & (np.abs(bond.y) < 0.42), bond.odd), "own") - 0.5
    # Steepest at the butt: a board is thick there and casts a shadow on the one below, which begins at once.
    down = 0.5 - bond.y
    butt = smoothstep(0.98, 0.88, down)
    shadow = smoothstep(0.28, 0.02, down)
    height = -1.0 + board * butt * (0.45 + 1.25 * down + 0.45 * own + 0.20 * split) - 0.25 * shadow * board
    cedar = ramp(["4b3a2d", "7b604a", "a98c70", "cdb79c"], 0.42 + 0.50 * own + 0.30 * down + 0.25 * split)
    colour = mix(rgb("231913"), canvas.painted(cedar) * (1.0 - 0.45 * shadow)[:, None], board * butt)
    return Relief(canvas.softened(height), canvas.softened(colour))


@style("chips of marble of many colours set in pale cement", feature_mm=1.3 * CHIP)
def terrazzo(canvas: Canvas) -> Relief:
    """Angular chips of marble of several colours and two sizes, set apart in ground cement."""
    unit = canvas.unit("chips", 0.35 * CHIP, edges=1.8)
    cement = canvas.noise(5.0 * unit, 2, "cement")
    height = -0.70 + 0.10 * cement
    colour = canvas.painted(ramp(["d5d0c6", "efece4"], 0.5 + 0.5 * cement))
    for size, salt in ((0.62 * CHIP, "small"), (1.35 * CHIP, "large")):
        chips = canvas.cells(size * unit, salt, at=canvas.warped(0.8 * size * unit, 0.10 * size * unit, salt))
        own = canvas.random(chips.identity, salt)
        chip = smoothstep(0.0, 0.7, chips.edge / unit - (0.09 + 0.16 * own) * size) * (own < 0.72)
        hue = np.array([rgb(code) for code in ("8c4f3a", "c9a27a", "4d5a58", "2d2f33", "a9b7a4", "d98f6a")])[(own * 8.3).astype(int) % 6]
        height += chip * (0.55 + 0.35 * own - height)
        colour = mix(colour, hue, chip)
    return Relief(canvas.softened(height), canvas.softened(colour))


CHECK, FRAME, BEAM = 16.0, 40.0, 6.0


@style("squares of a chessboard, dark ones sunk between pale ones", feature_mm=CHECK)
def checkers(canvas: Canvas) -> Relief:
    """Squares that are pale and raised or dark and sunk, in turn along both ways."""
    unit = canvas.unit("edges of the squares", 0.25 * CHECK, edges=1.6)
    bond = canvas.bond(2.0 * CHECK * unit, CHECK * unit)  # a pale and a dark square a cell, which changes sides from row to row
    pale = smoothstep(-0.8, 0.8, (np.abs(bond.x) - 0.25) * 2.0 * CHECK)
    away = smoothstep(0.0, 0.8, (0.5 - np.abs(bond.y)) * CHECK)
    pale = 0.5 + (pale - 0.5) * away  # at the border of two rows either may be
    grain = canvas.noise(14.0 * unit, 4, "grain")
    light = canvas.painted(ramp(["cbb894", "e6d8b8", "f6edd8"], 0.5 + 0.5 * grain))
    return Relief(
        canvas.softened(-0.9 + 1.8 * pale + 0.08 * grain), canvas.softened(mix(rgb("2a211b") + 0.05 * grain[:, None], light, pale))
    )


@style("dark beams with braces, and white plaster between", feature_mm=0.5 * FRAME)
def half_timbered(canvas: Canvas) -> Relief:
    """Posts and rails of dark oak that stand out of white plaster; every other panel has a brace."""
    unit = canvas.unit("beams", BEAM, edges=2.2)
    bond = canvas.bond(FRAME * unit, 0.9 * FRAME * unit, shift=0.0)
    post, rail = (0.5 - np.abs(bond.x)) * FRAME, (0.5 - np.abs(bond.y)) * 0.9 * FRAME
    own = canvas.random(canvas.pieces(np.minimum(post, rail) > 0.4 * BEAM, bond.odd), "brace")
    brace = np.where(own < 0.25, np.abs(bond.x - bond.y), np.where(own < 0.5, np.abs(bond.x + bond.y), 1.0)) * FRAME / 2.0**0.5
    beam = smoothstep(0.6 * BEAM, 0.4 * BEAM, np.minimum(np.minimum(post, rail), brace))
    grain, trowel = canvas.noise(5.0 * unit, 3, "grain"), canvas.noise(16.0 * unit, 3, "trowel")
    oak = ramp(["1f140d", "3b2617", "5a3c24"], 0.5 + 0.6 * grain)
    plaster = canvas.painted(ramp(["cfc6b2", "ece5d4", "faf6ea"], 0.55 + 0.45 * trowel))
    return Relief(
        canvas.softened(-0.8 + 1.7 * beam + 0.08 * grain * beam + 0.10 * trowel * (1.0 - beam)), canvas.softened(mix(plaster, oak, beam))
    )
