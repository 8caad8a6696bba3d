"""Mud dried into plates with curled rims and deep cracks between."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

PLATE, CRACK = 22.0, 3.4


def cracked_earth(canvas: Canvas) -> Relief:
    """Plates whose rims dried first and curled up; finer cracks end within them."""
    unit = canvas.unit("cracks", CRACK, edges=1.6)
    plates = canvas.cells(PLATE * unit, "plates", at=canvas.warped(16.0 * unit, 4.0 * unit, "outline"))
    edge = plates.edge / unit
    plate = smoothstep(0.20 * CRACK, 0.80 * CRACK, edge)
    fine = canvas.cells(0.62 * PLATE * unit, "fine", at=canvas.warped(14.0 * unit, 3.0 * unit, "fine outline"))
    there = smoothstep(0.45, 0.55, canvas.random(plates.identity, "split")) * plate
    split = smoothstep(0.65 * CRACK, 0.15 * CRACK, fine.edge / unit) * there
    curl = smoothstep(0.40 * PLATE, 0.7 * CRACK, edge)
    own, dust = canvas.random(plates.identity, "tone") - 0.5, canvas.noise(9.0 * unit, 4, "dust")
    top = 0.10 + 0.55 * curl + 0.35 * own + 0.18 * dust - 0.65 * split
    tone = np.clip(0.52 + 0.30 * own + 0.22 * curl + 0.28 * dust, 0.0, 1.0)
    mud = canvas.painted(ramp(["80604a", "a78364", "c8a888", "e2cbae"], tone))
    dark = np.maximum(1.0 - plate, 0.75 * split)
    return Relief(canvas.softened(-1.0 + (1.0 + top) * plate), canvas.softened(mix(mud, rgb("382417"), dark)))


STYLE = Style(
    name="cracked_earth",
    description="dried mud in plates with curled rims and deep cracks between",
    feature_mm=PLATE,
    program=cracked_earth,
)
