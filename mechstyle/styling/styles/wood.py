"""Plain-sawn wood: year rings cut into arches and loops, fine fibres, a few knots."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

RING, KNOT = 10.0, 9.0
PITH = np.array([46.0, 30.0])  # of the trunk, from the corner of the part's box [nominal mm]


def wood(canvas: Canvas) -> Relief:
    """A piece cut from a trunk that grew upwards beside it."""
    unit = canvas.unit("dark lines of the grain", 0.36 * RING)
    late, fibre, knot = grain(canvas, unit)
    board = canvas.noise(50.0 * unit, 2, "board")
    tone = np.clip(0.68 - 0.48 * late + 0.30 * fibre + 0.16 * board, 0.0, 1.0)
    colour = mix(ramp(["5b3416", "8a5628", "b57c43", "d0a069", "e3bd8a"], tone), rgb("4a2810"), 0.8 * knot)
    return Relief(0.20 - 0.55 * late + 0.20 * fibre + 0.25 * knot, canvas.softened(canvas.painted(colour)))


def grain(canvas: Canvas, unit: float) -> tuple[Floats, Floats, Floats]:
    """Late wood in [0, 1], hard and dark, noise of the fibres in about [-1, 1], and hearts of knots in [0, 1], shape [n] each."""
    upright = canvas.points * [1.0, 1.0, 0.28]
    x, y = ((canvas.points - canvas.points.min(axis=0))[:, :2] / unit + PITH).T
    knots = canvas.stamps(canvas.scattered(78.0 * unit, "knots"), 78.0 * unit)
    around = np.hypot(knots.x[:, 0], 0.6 * knots.y[:, 0]) / (KNOT * unit)
    year = np.hypot(x, y) / RING + 0.85 * canvas.noise(42.0 * unit, 2, "growth", at=upright) + 1.8 * np.exp(-(around**2))
    through = year - np.floor(year)
    # Dark wood builds up slowly through a year and ends at once.
    late = smoothstep(0.25, 0.85, through) ** 1.5 * smoothstep(1.0, 0.82, through)
    fibre = canvas.noise(6.0 * unit, 2, "fibre", at=canvas.points * [1.0, 1.0, 0.12])
    return canvas.softened(late), fibre, smoothstep(0.60, 0.25, around)


STYLE = Style(
    name="wood",
    words=("wooden", "woodgrain", "wood_grain", "grain", "timber", "oak", "walnut", "pine", "lumber"),
    description="plain-sawn wood with the dark arches of its year rings, fine fibres and a few knots",
    feature_mm=RING,
    program=wood,
)
