"""Plain shapes: dots, stripes, facets, contour lines, creases and grain."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas, dome, folded
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, style

PITCH, DOT = 13.0, 4.4


@style("raised round dots in staggered rows, white on blue", feature_mm=PITCH)
def dots(canvas: Canvas) -> Relief:
    """Round buttons with a small bevel on a plain ground."""
    unit = canvas.unit("dots", 2.0 * DOT, edges=4.0)
    bond = canvas.bond(PITCH * unit, 0.866 * PITCH * unit, grip=0.3)
    reach = np.hypot(bond.x * PITCH, bond.y * 0.866 * PITCH)
    dot = smoothstep(1.16 * DOT, 0.86 * DOT, reach)
    colour = mix(canvas.painted(np.tile(rgb("2f5f9e"), (len(reach), 1))), rgb("f6f3ea"), dot)
    cloth = canvas.noise(40.0 * unit, 2, "cloth")
    colour = np.clip(colour * (1.0 + 0.06 * cloth)[:, None], 0.0, 1.0)
    return Relief(canvas.softened(-0.75 + 1.85 * dot + 0.06 * cloth), canvas.softened(colour))


PERIOD = 11.0


@style("level raised bands with hollow grooves between, in red and white", feature_mm=PERIOD)
def stripes(canvas: Canvas) -> Relief:
    """Raised bands and grooves of one width, in two colours."""
    unit = canvas.unit("stripes", 0.5 * PERIOD)
    bond = canvas.bond(10.0 * PERIOD * unit, PERIOD * unit, shift=0.0)
    away = np.abs(bond.y) * PERIOD
    band = smoothstep(0.31 * PERIOD, 0.19 * PERIOD, away)
    groove = dome(np.clip((0.5 * PERIOD - away) / (0.27 * PERIOD), 0.0, 1.0))
    cloth = canvas.noise(40.0 * unit, 2, "cloth")
    colour = mix(rgb("f4f0e6"), canvas.painted(np.tile(rgb("b5403a"), (len(away), 1))), band)
    height = 1.1 * band - (1.0 - band) * (0.55 + 0.45 * groove) + 0.06 * cloth
    colour = np.clip(colour * (1.0 + 0.05 * cloth)[:, None], 0.0, 1.0)
    return Relief(canvas.softened(height), canvas.softened(colour))


FACET = 21.0  # across a fan of triangles


@style("large flat triangles that meet in straight edges", feature_mm=FACET)
def low_poly(canvas: Canvas) -> Relief:
    """Around scattered points that stand out the surface is a fan of flat faces, each of one tone."""
    unit = canvas.unit("facets", 0.4 * FACET, edges=2.5)
    fans = canvas.cells(0.8 * FACET * unit, "fans")
    rise = 0.75 + 0.50 * canvas.random(fans.identity, "rise")
    height = -1.0 + np.minimum(3.0 * rise * fans.edge / (0.8 * FACET * unit), 2.4)
    facet = canvas.random(fans.facet, "facet")
    tone = 0.20 + 0.20 * rise + 0.70 * (facet - 0.2)
    colour = ramp(["17525c", "23818a", "4fb3a5", "a8dfc0", "f0f4d6"], tone)
    return Relief(height, canvas.softened(canvas.painted(colour)))


HILL, LEVELS, LINE = 58.0, 10, 3.6


@style("raised contour lines of a hilly land in the colours of a map", feature_mm=0.25 * HILL)
def topographic(canvas: Canvas) -> Relief:
    """A ridge along every contour, land that rises between them; the colours are those of a map, from the sea to the snow."""
    unit = canvas.unit("contour lines", LINE, edges=1.8)
    land = 0.5 + 0.72 * canvas.noise(HILL * unit, 2, "land")
    step = np.clip(land, 0.0, 1.0) * LEVELS
    # The lines are of one width, however gentle the hill.
    away = folded(step) / np.maximum(canvas.softened(canvas.operators.slope(step)), 0.3 / (HILL * unit))
    line = smoothstep(0.75 * LINE * unit, 0.20 * LINE * unit, away) * (np.round(step) > 0.0) * (np.round(step) < LEVELS)
    level = (np.floor(step + 0.5) + smoothstep(-0.5, 0.5, step - np.floor(step + 0.5))) / LEVELS
    colour = ramp(["2f6f8f", "6fb0a8", "8fbf7a", "d6d08a", "c79a62", "9a6a4a", "f2efe8"], level)
    colour = mix(canvas.painted(colour), rgb("4a3a2a"), 0.8 * line)
    return Relief(canvas.softened(-0.8 + 0.45 * level + 1.45 * line), canvas.softened(colour))


CREASE = 30.0


@style("paper crumpled and spread again", feature_mm=CREASE)
def paper(canvas: Canvas) -> Relief:
    """Crumpled and spread again: straight sharp creases between flat facets, large and small."""
    unit = canvas.unit("creases", 0.3 * CREASE, edges=2.5)
    crumple = np.zeros(len(canvas.points))
    for size, strength in ((1.0, 0.55), (0.6, 0.40), (0.35, 0.28)):
        for turn in (0.6, 1.5):
            salt = f"{size}/{turn}"
            pieces = canvas.cells(size * CREASE * unit, salt, stretch=np.array([1.0, turn, 1.0 / turn]))
            fold = np.clip(pieces.edge / (0.26 * size * CREASE * unit), 0.0, 1.0)
            crumple += strength * np.where(canvas.random(pieces.identity, salt) < 0.5, 1.0, -1.0) * fold
    fibre = canvas.noise(40.0 * unit, 2, "fibre")
    sheet = ramp(["bdb6a8", "e6e1d5", "fbf8f0"], 0.60 + 0.30 * crumple + 0.10 * fibre)
    return Relief(canvas.softened(1.05 * np.tanh(1.25 * crumple)), canvas.softened(canvas.painted(sheet)))


FUZZ = 2.4


@style("a skin roughened evenly and finely", feature_mm=FUZZ)
def fuzzy(canvas: Canvas) -> Relief:
    """Fuzzy skin: a surface roughened evenly, to be held and to hide layers."""
    unit = canvas.unit("grains of the skin", FUZZ, edges=1.8)
    grain = np.clip(2.6 * canvas.noise(FUZZ * unit, 1, "grain") + 0.4 * canvas.noise(1.9 * FUZZ * unit, 1, "coarse"), -1.0, 1.2)
    tone = 0.5 + 0.22 * grain
    return Relief(grain, canvas.softened(canvas.painted(ramp(["4c5a63", "71828c", "a3b1b8"], tone))))
