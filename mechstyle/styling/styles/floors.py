"""What floors, walls and roofs are laid with besides bricks: parquet, tiles, shingles, terrazzo."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

BLOCK, TILE, SHINGLE, CHIP = 8.0, 20.0, 15.0, 12.0
LONG = 3  # length of a block of parquet over its width


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
    oak = ramp(["5a351a", "8a5a2e", "b98449", "dcb47c"], np.clip(0.52 + 0.55 * own + 0.16 * rising + 0.16 * grain, 0.0, 1.0))
    height = -1.0 + face * (1.55 + 0.55 * own + 0.12 * grain)
    return Relief(canvas.softened(height), canvas.softened(mix(rgb("2c190c"), canvas.painted(oak), face)))


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
    white = ramp(["cfd8da", "e9eeee", "fbfcfa"], np.clip(0.45 + 0.5 * own + 0.30 * pillow + 0.20 * crackle, 0.0, 1.0))
    blue = ramp(["16345c", "245a94", "3f82bd"], np.clip(0.5 + 0.6 * own + 0.20 * crackle, 0.0, 1.0))
    colour = mix(rgb("a89f90"), mix(canvas.painted(white), blue, small.astype(float)), glaze)
    return Relief(canvas.softened(-1.0 + glaze * (1.35 + 0.30 * pillow + 0.30 * own + 0.50 * small)), canvas.softened(colour))


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
    cedar = ramp(["4b3a2d", "7b604a", "a98c70", "cdb79c"], np.clip(0.42 + 0.50 * own + 0.30 * down + 0.25 * split, 0.0, 1.0))
    colour = mix(rgb("231913"), canvas.painted(cedar) * (1.0 - 0.45 * shadow)[:, None], board * butt)
    return Relief(canvas.softened(height), canvas.softened(colour))


def terrazzo(canvas: Canvas) -> Relief:
    """Angular chips of marble of several colours and two sizes, set apart in ground cement."""
    unit = canvas.unit("chips", 0.35 * CHIP, edges=1.8)
    cement = canvas.noise(5.0 * unit, 2, "cement")
    height = -0.70 + 0.10 * cement
    colour = canvas.painted(ramp(["d5d0c6", "efece4"], np.clip(0.5 + 0.5 * cement, 0.0, 1.0)))
    for size, salt in ((0.62 * CHIP, "small"), (1.35 * CHIP, "large")):
        chips = canvas.cells(size * unit, salt, at=canvas.warped(0.8 * size * unit, 0.10 * size * unit, salt))
        own = canvas.random(chips.identity, salt)
        chip = smoothstep(0.0, 0.7, chips.edge / unit - (0.09 + 0.16 * own) * size) * (own < 0.72)
        hue = np.array([rgb(code) for code in ("8c4f3a", "c9a27a", "4d5a58", "2d2f33", "a9b7a4", "d98f6a")])[(own * 8.3).astype(int) % 6]
        height += chip * (0.55 + 0.35 * own - height)
        colour = mix(colour, hue, chip)
    return Relief(canvas.softened(height), canvas.softened(colour))


STYLES = {
    style.name: style
    for style in (
        Style(name="herringbone", description="parquet of oak blocks at right angles", feature_mm=2.0 * BLOCK, program=herringbone),
        Style(name="tiles", description="glazed octagons with small blue squares between, in pale grout", feature_mm=TILE, program=tiles),
        Style(name="shingles", description="split boards on a roof, each over two others", feature_mm=SHINGLE, program=shingles),
        Style(name="terrazzo", description="chips of marble of many colours set in pale cement", feature_mm=1.3 * CHIP, program=terrazzo),
    )
}
