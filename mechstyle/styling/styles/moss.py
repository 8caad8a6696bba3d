"""Moss: soft cushions of every size, close together."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import ramp
from mechstyle.styling.drawing.tilings import dome
from mechstyle.styling.style import Relief, Style

TUFT, MOUND = 8.0, 24.0


def moss(canvas: Canvas) -> Relief:
    """Small tufts on larger mounds."""
    unit = canvas.unit("tufts", TUFT, edges=4.0)
    tufts = canvas.cells(TUFT * unit, "tufts", at=canvas.warped(8.0 * unit, 1.6 * unit, "tufts"))
    mounds = canvas.cells(MOUND * unit, "mounds", at=canvas.warped(20.0 * unit, 7.0 * unit, "mounds"))
    tuft = dome(1.0 - np.clip(tufts.edge / (0.42 * TUFT * unit), 0.0, 1.0))
    mound = dome(1.0 - np.clip(mounds.edge / (10.0 * unit), 0.0, 1.0))
    fuzz = canvas.noise(5.0 * unit, 3, "fuzz")
    own, damp = canvas.random(tufts.identity, "tone") - 0.5, canvas.noise(35.0 * unit, 3, "damp")
    tone = np.clip(0.05 + 0.35 * tuft + 0.35 * mound + 0.35 * own + 0.20 * damp + 0.25 * fuzz, 0.0, 1.0)
    colour = ramp(["1d2c10", "3f5a1c", "6c8a2c", "a3b84e", "cbd27c"], tone)
    return Relief(canvas.softened(-1.1 + 0.55 * mound + tuft * (1.35 + 0.40 * own) + 0.25 * fuzz), canvas.softened(canvas.painted(colour)))


STYLE = Style(
    name="moss",
    description="soft green cushions of moss, large and small",
    feature_mm=0.5 * MOUND,
    program=moss,
)
