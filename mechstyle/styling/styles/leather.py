"""Pebbled leather with soft creases."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

PEBBLE = 10.0


def leather(canvas: Canvas) -> Relief:
    """Small cushions of uneven size with creases between; longer folds cross them, and polish wears the crests lighter."""
    unit = canvas.unit("pebbles of the hide", PEBBLE, edges=4.5)
    grain = canvas.cells(PEBBLE * unit, "grain", at=canvas.warped(9.0 * unit, 1.8 * unit, "grain"))
    edge = grain.edge / unit
    cushion = 1.0 - (1.0 - np.clip(edge / (0.42 * PEBBLE), 0.0, 1.0)) ** 2  # a cushion with a crease that is sharp
    folds = canvas.cells(48.0 * unit, "folds", at=canvas.warped(26.0 * unit, 12.0 * unit, "folds"))
    there = smoothstep(-0.10, 0.25, canvas.noise(50.0 * unit, 2, "where folded"))
    fold = smoothstep(3.6, 0.4, folds.edge / unit) * there
    soft, patina = canvas.noise(30.0 * unit, 2, "soft"), canvas.noise(36.0 * unit, 3, "patina")
    own = canvas.random(grain.identity, "tone") - 0.5
    height = -0.80 + 1.55 * cushion + 0.12 * own * cushion + 0.06 * soft - 0.40 * fold
    tone = np.clip(0.24 + 0.46 * cushion + 0.22 * patina + 0.16 * own, 0.0, 1.0)
    hide = canvas.painted(ramp(["5a2f1a", "8a4c27", "b06c3c", "d09a66"], tone))
    return Relief(canvas.softened(height), canvas.softened(mix(hide, rgb("2c150b"), 0.75 * fold)))


STYLE = Style(
    name="leather",
    description="pebbled brown leather with soft creases and a worn polish",
    feature_mm=PEBBLE,
    program=leather,
)
