"""Nets of ribs around cells: honeycomb, bars, triangles, tracks of a circuit, froth."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas, dome, folded
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, style

HONEYCOMB_CELL, WALL = 15.0, 3.6
HONEYCOMB_ROW = 0.5 * 3.0**0.5 * HONEYCOMB_CELL


@style("hexagonal cells of wax, hollow, full of honey or capped", feature_mm=HONEYCOMB_CELL)
def honeycomb(canvas: Canvas) -> Relief:
    """Regular hexagons in staggered rows: raised walls around hollow, filled or capped cells."""
    unit = canvas.unit("walls of wax", WALL)
    bond = canvas.bond(HONEYCOMB_CELL * unit, HONEYCOMB_ROW * unit, grip=0.6)
    x, y = np.abs(bond.x) * HONEYCOMB_CELL, np.abs(bond.y) * HONEYCOMB_ROW
    # A place beyond the slanting border belongs to the cell of the next row, half a cell aside.
    beyond = 0.5 * x + y * HONEYCOMB_ROW / HONEYCOMB_CELL > 0.5 * HONEYCOMB_CELL
    x, y = np.where(beyond, 0.5 * HONEYCOMB_CELL - x, x), np.where(beyond, HONEYCOMB_ROW - y, y)
    border = np.minimum(0.5 * HONEYCOMB_CELL - x, 0.5 * HONEYCOMB_CELL - (0.5 * x + y * HONEYCOMB_ROW / HONEYCOMB_CELL))
    wall = smoothstep(0.85 * WALL, 0.25 * WALL, border)
    identity = canvas.pieces(border > 0.2 * WALL, bond.odd ^ beyond)
    kind, tone = canvas.random(identity, "kind"), canvas.random(identity, "tone")
    capped, full = smoothstep(0.74, 0.76, kind), smoothstep(0.34, 0.36, kind)
    wax = canvas.noise(7.0 * unit, 3, "wax")
    deep = smoothstep(0.5 * WALL, 0.45 * HONEYCOMB_CELL, border)
    honey = ramp(["5a2604", "9a4c08", "d68212", "f0ae2c"], 0.15 + 0.40 * full + 0.30 * tone - 0.25 * deep * (1.0 - full))
    cap = ramp(["b98436", "d6a957", "e6c480"], 0.5 + 0.5 * (tone - 0.5) + 0.45 * wax)
    rim = ramp(["e0ac48", "f6d47c", "fff0bc"], 0.5 + 0.6 * wax)
    floor = -0.90 + 0.45 * full + capped * (0.55 + 0.35 * deep + 0.20 * wax)
    height = floor + wall * (0.85 + 0.10 * wax - floor)
    colour = mix(mix(honey, cap, capped), rim, wall)
    return Relief(canvas.softened(height), canvas.softened(canvas.painted(colour)))


VORONOI_CELL, VORONOI_RIB = 19.0, 4.6


@style("a pale organic net of round ribs around deep, coloured cells", feature_mm=VORONOI_CELL)
def voronoi(canvas: Canvas) -> Relief:
    """Round ribs along the borders of Voronoi cells, with flat deep floors that change their hue along the part."""
    unit = canvas.unit("ribs", VORONOI_RIB, edges=2.4)
    cells = canvas.cells(VORONOI_CELL * unit, "cells")
    # Smoothing rounds the corners of the cells, and pins the ribs where three meet.
    edge = canvas.smoothed(cells.edge, unit) / unit
    rib = dome(np.clip(edge / (0.62 * VORONOI_RIB), 0.0, 1.0))
    deep = smoothstep(0.40 * VORONOI_RIB, 1.20 * VORONOI_RIB, edge)
    own = canvas.random(cells.identity, "tone") - 0.5
    drift = canvas.noise(70.0 * unit, 2, "drift")
    floor = ramp(["33306b", "3f5f9e", "3f9fae", "7fcfa6", "e6e08c"], 0.5 + 0.75 * drift + 0.35 * own)
    floor = floor * (1.10 - 0.50 * deep)[:, None]
    net = ramp(["d9d5cc", "f6f3ec"], smoothstep(0.3, 1.0, rib))
    height = -0.45 - 0.50 * deep + 1.40 * rib + 0.10 * own * deep
    return Relief(canvas.softened(height), canvas.softened(np.clip(mix(canvas.painted(floor), net, rib), 0.0, 1.0)))


SIDE, ISOGRID_RIB = 24.0, 4.4
ISOGRID_ROW = 0.5 * 3.0**0.5 * SIDE


@style("triangular ribs around milled pockets, as on the panel of a rocket", feature_mm=ISOGRID_ROW)
def isogrid(canvas: Canvas) -> Relief:
    """Ribs along three directions around deep pockets."""
    unit = canvas.unit("ribs", ISOGRID_RIB, edges=2.2)
    bond = canvas.bond(SIDE * unit, ISOGRID_ROW * unit, grip=0.6)
    x, y = bond.x * SIDE, bond.y * ISOGRID_ROW
    lean = 0.5 * 3.0**0.5 * x / ISOGRID_ROW
    # Distances to the lines through the nodes, level and slanting both ways.
    line = ISOGRID_ROW * np.min([np.abs(bond.y), folded(lean - 0.5 * bond.y), folded(lean + 0.5 * bond.y)], axis=0)
    beyond = 0.5 * np.abs(x) + np.abs(y) * ISOGRID_ROW / SIDE > 0.5 * SIDE
    node = np.where(beyond, np.hypot(0.5 * SIDE - np.abs(x), ISOGRID_ROW - np.abs(y)), np.hypot(x, y))
    rib = smoothstep(0.70 * ISOGRID_RIB, 0.35 * ISOGRID_RIB, line)
    boss, hole = smoothstep(1.25 * ISOGRID_RIB, 0.95 * ISOGRID_RIB, node), smoothstep(0.60 * ISOGRID_RIB, 0.30 * ISOGRID_RIB, node)
    raised = np.maximum(rib, boss)
    cloud = canvas.noise(50.0 * unit, 3, "cloud")
    metal = ramp(["5d656d", "8b949c", "b8bfc5", "e6e9eb"], 0.20 + 0.60 * raised + 0.15 * cloud)
    colour = mix(canvas.painted(metal), rgb("2e3338"), 0.8 * hole)
    return Relief(canvas.softened(-1.0 + 1.75 * raised + 0.35 * boss - 0.9 * hole + 0.04 * cloud), canvas.softened(colour))


PITCH, BAR = 13.0, 4.4


@style("a square lattice of raised bars around pockets, like a waffle", feature_mm=PITCH)
def grid(canvas: Canvas) -> Relief:
    """Bars of one width, level and upright, with hollows between."""
    unit = canvas.unit("bars", BAR, edges=2.2)
    bond = canvas.bond(PITCH * unit, PITCH * unit, shift=0.0)
    away = (0.5 - np.maximum(np.abs(bond.x), np.abs(bond.y))) * PITCH
    bar = smoothstep(0.68 * BAR, 0.32 * BAR, away)
    baked = canvas.noise(30.0 * unit, 3, "baked")
    crust = ramp(["8f5423", "bf7d36", "dfae62", "f3d79b"], 0.30 + 0.55 * bar + 0.25 * baked)
    deep = smoothstep(0.3 * BAR, 0.5 * PITCH, away)
    return Relief(canvas.softened(-0.75 + 1.75 * bar - 0.30 * deep + 0.06 * baked), canvas.softened(canvas.painted(crust)))


GRID, TRACK = 12.0, 3.8


@style("a printed circuit board with tracks at right angles between gilded pads", feature_mm=GRID)
def circuit(canvas: Canvas) -> Relief:
    """On a square grid every joint is a pad, a plain point or nothing, and tracks run between some neighbours."""
    unit = canvas.unit("tracks", TRACK)
    bond = canvas.bond(GRID * unit, GRID * unit, shift=0.0)
    x, y = bond.x * GRID, bond.y * GRID
    aside, up = np.abs(x), np.abs(y)
    # Around the middle of each side of a cell, the two halves of a track are one piece and so share their chance.
    level = canvas.pieces((up < 0.35 * GRID) & (aside > 0.15 * GRID))
    upright = canvas.pieces((aside < 0.35 * GRID) & (up > 0.15 * GRID))
    joint = canvas.pieces((aside < 0.42 * GRID) & (up < 0.42 * GRID))
    tracks = [
        smoothstep(0.75 * TRACK, 0.30 * TRACK, across) * (canvas.random(piece, salt) < chance) * (along > 0.15 * GRID)
        for across, along, piece, salt, chance in ((up, aside, level, "level", 0.55), (aside, up, upright, "upright", 0.55))
    ]
    middle = smoothstep(0.75 * TRACK, 0.30 * TRACK, np.maximum(aside, up))
    kind = canvas.random(joint, "kind")
    pad = smoothstep(1.15, 0.85, np.hypot(x, y) / (1.05 * TRACK)) * (kind < 0.40)
    hole = smoothstep(0.50, 0.22, np.hypot(x, y) / (1.05 * TRACK)) * (kind < 0.40)
    copper = np.max([*tracks, middle, pad], axis=0)
    mask = canvas.noise(30.0 * unit, 2, "mask")
    board = canvas.painted(ramp(["0a3a22", "0f5230", "1a6b40"], 0.5 + 0.6 * mask))
    gold = ramp(["a87c2c", "d8b154", "f2d98c"], 0.45 + 0.35 * pad + 0.3 * mask)
    colour = mix(mix(board, mix(rgb("3fae6a"), gold, pad), copper), rgb("10150f"), hole)
    height = -0.55 + 0.05 * mask + 0.95 * copper + 0.45 * pad - 1.20 * hole
    return Relief(canvas.softened(height), canvas.softened(colour))


LARGE = 14.0
SIZES = (1.0, 0.62)  # radii of the generations of bubbles over the largest
SHARE = 0.42  # radius of a bubble over the distance of its generation


@style("round bubbles of many sizes crowded together", feature_mm=LARGE)
def bubbles(canvas: Canvas) -> Relief:
    """Small half balls fill the room between large ones; the highest is in front."""
    unit = canvas.unit("small bubbles", SIZES[-1] * LARGE, edges=4.5)
    height, glint = np.full(len(canvas.points), -1.0), np.zeros(len(canvas.points))
    own = np.zeros(len(canvas.points))
    for size in SIZES:
        spacing = size * LARGE * unit
        stamps = canvas.stamps(canvas.scattered(spacing, f"bubbles {size}"), spacing, count=3)
        radius = (SHARE + 0.14 * canvas.random(stamps.identity, "radius")) * spacing
        ball = dome(np.hypot(stamps.x, stamps.y) / radius) * smoothstep(0.2, 0.5, stamps.facing)
        spark = np.exp(-((np.hypot(stamps.x + 0.25 * radius, stamps.y - 0.35 * radius) / (0.28 * radius)) ** 2))
        for k in range(ball.shape[1]):
            higher = -1.0 + (1.05 + 1.05 * size) * ball[:, k]
            front = higher > height
            height, glint = np.where(front, higher, height), np.where(front, spark[:, k], glint)
            own = np.where(front, canvas.random(stamps.identity[:, k], f"hue {size}"), own)
    tone = 0.15 + 0.30 * (height + 1.0) + 0.30 * (own - 0.5)
    water = canvas.painted(ramp(["12507e", "2f8fc0", "7fcbe2", "d6f2f4"], tone))
    return Relief(canvas.softened(height), canvas.softened(mix(water, rgb("ffffff"), 0.75 * glint)))
