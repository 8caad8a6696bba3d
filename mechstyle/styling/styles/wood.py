"""Plain-sawn wood: year rings cut into arches and loops, fine fibres, a few knots."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

RING, KNOT, TAPER = 9.0, 10.0, 0.50
PITH = np.array([8.0, 16.0])  # of the trunk, to the right of the part's middle and before its front [nominal mm]


def wood(canvas: Canvas) -> Relief:
    """A piece cut from a trunk that grew upwards before it."""
    unit = canvas.unit("dark lines of the grain", 0.36 * RING)
    late, fibre, knot = grain(canvas, unit)
    board = canvas.noise(50.0 * unit, 2, "board")
    tone = np.clip(0.68 - 0.48 * late + 0.30 * fibre + 0.16 * board, 0.0, 1.0)
    colour = mix(ramp(["5b3416", "8a5628", "b57c43", "d0a069", "e3bd8a"], tone), rgb("4a2810"), 0.8 * knot)
    # Brushed, as a carpenter brushes oak: early wood is worn away, late wood stands.
    return Relief(canvas.softened(-0.85 + 1.75 * late + 0.45 * fibre + 0.30 * knot), canvas.softened(canvas.painted(colour)))


def grain(canvas: Canvas, unit: float) -> tuple[Floats, Floats, Floats]:
    """Late wood in [0, 1], hard and dark, noise of the fibres in about [-1, 1], and hearts of knots in [0, 1], shape [n] each."""
    upright = canvas.points * [1.0, 1.0, 0.28]
    low, high = canvas.points.min(axis=0), canvas.points.max(axis=0)
    x, y, z = ((canvas.points - [0.5 * (low[0] + high[0]), low[1], low[2]]) / unit).T
    knots = canvas.stamps(canvas.scattered(78.0 * unit, "knots"), 78.0 * unit)
    around = np.hypot(knots.x[:, 0], 0.6 * knots.y[:, 0]) / (KNOT * unit)
    # A trunk gets thinner upwards, so that a saw cuts its rings into arches.
    year = (np.hypot(x - PITH[0], y + PITH[1]) + TAPER * z) / RING
    year += 0.70 * canvas.noise(42.0 * unit, 2, "growth", at=upright) + 1.8 * np.exp(-(around**2))
    through = year - np.floor(year)
    # Dark wood builds up slowly through a year and ends at once.
    late = smoothstep(0.15, 0.75, through) * smoothstep(1.0, 0.80, through)
    fibre = canvas.noise(6.0 * unit, 2, "fibre", at=canvas.points * [1.0, 1.0, 0.12])
    return canvas.softened(late), fibre, smoothstep(0.60, 0.25, around)


STYLE = Style(
    name="wood",
    description="plain-sawn wood with the dark arches of its year rings, fine fibres and a few knots",
    feature_mm=1.8 * RING,
    program=wood,
)
