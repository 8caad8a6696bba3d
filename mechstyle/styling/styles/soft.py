"""What is soft to the hand: cork, crumpled paper, tartan cloth, and a fuzzy skin."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

GRAIN, CREASE, SETT, FUZZ = 7.0, 30.0, 40.0, 2.4


def cork(canvas: Canvas) -> Relief:
    """Granules of many sizes pressed together, some fallen out."""
    unit = canvas.unit("granules of cork", GRAIN, edges=3.0)
    warped = canvas.warped(6.0 * unit, 1.2 * unit, "granules")
    grains = canvas.cells(GRAIN * unit, "granules", at=warped)
    own, lost = canvas.random(grains.identity, "own") - 0.5, canvas.random(grains.identity, "lost") < 0.09
    edge = grains.edge / (GRAIN * unit)
    grain, dust = smoothstep(0.0, 0.18, edge), canvas.noise(4.0 * unit, 2, "dust")
    height = -0.35 + 0.70 * grain + 0.90 * own + 0.36 * dust - 0.95 * lost * grain
    tone = np.clip(0.55 + 0.45 * own + 0.25 * dust - 0.35 * (1.0 - grain) - 0.5 * lost, 0.0, 1.0)
    return Relief(canvas.softened(height), canvas.softened(canvas.painted(ramp(["4f321b", "96683c", "c99a63", "e3c091"], tone))))


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
    sheet = ramp(["bdb6a8", "e6e1d5", "fbf8f0"], np.clip(0.60 + 0.30 * crumple + 0.10 * fibre, 0.0, 1.0))
    return Relief(canvas.softened(1.05 * np.tanh(1.25 * crumple)), canvas.softened(canvas.painted(sheet)))


def tartan(canvas: Canvas) -> Relief:
    """Bands and lines of a sett, level and upright, woven through each other in a twill."""
    unit = canvas.unit("lines of the sett", 0.08 * SETT, edges=1.6)
    bond = canvas.bond(SETT * unit, SETT * unit, shift=0.0)
    twill = 0.5 + 0.5 * np.cos(2.0 * np.pi * 6.0 * (bond.x + bond.y))
    broad, line = zip(*(_sett(np.abs(phase)) for phase in (bond.x, bond.y)), strict=True)
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


def _sett(away: Floats) -> tuple[Floats, Floats]:
    """Broad bands and thin lines of a sett at a distance from its middle, in [0, ½], shape [n] each."""
    return smoothstep(0.16, 0.19, away) * smoothstep(0.37, 0.34, away), smoothstep(0.055, 0.030, away)


def fuzzy(canvas: Canvas) -> Relief:
    """Fuzzy skin: a surface roughened evenly, to be held and to hide layers."""
    unit = canvas.unit("grains of the skin", FUZZ, edges=1.8)
    grain = np.clip(2.6 * canvas.noise(FUZZ * unit, 1, "grain") + 0.4 * canvas.noise(1.9 * FUZZ * unit, 1, "coarse"), -1.0, 1.2)
    tone = np.clip(0.5 + 0.22 * grain, 0.0, 1.0)
    return Relief(grain, canvas.softened(canvas.painted(ramp(["4c5a63", "71828c", "a3b1b8"], tone))))


STYLES = {
    style.name: style
    for style in (
        Style(name="cork", description="granules of cork pressed together", feature_mm=2.1 * GRAIN, program=cork),
        Style(name="paper", description="paper crumpled and spread again", feature_mm=CREASE, program=paper),
        Style(name="tartan", description="bands and lines of wool woven through each other", feature_mm=0.4 * SETT, program=tartan),
        Style(name="fuzzy", description="a skin roughened evenly and finely", feature_mm=FUZZ, program=fuzzy),
    )
}
