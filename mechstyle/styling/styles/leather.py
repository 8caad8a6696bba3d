"""Leather with a fine grain, sewn."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import dome, folded
from mechstyle.styling.style import Relief, Style

PEBBLE, WIDE, HIGH, STITCH = 5.4, 88.0, 58.0, 9.0


def leather(canvas: Canvas) -> Relief:
    """Panels with a fine grain, sewn together: they swell between the seams, and a row of stitches runs on both sides of each."""
    unit = canvas.unit("pebbles of the hide", PEBBLE, edges=3.0)
    grain = canvas.cells(PEBBLE * unit, "grain", at=canvas.warped(6.0 * unit, 1.2 * unit, "grain"))
    cushion = smoothstep(0.0, 0.30 * PEBBLE, grain.edge / unit)
    bond = canvas.bond(WIDE * unit, HIGH * unit, shift=0.0)
    x, y = np.abs(bond.x) * WIDE, np.abs(bond.y) * HIGH
    across, level = 0.5 * WIDE - x, 0.5 * HIGH - y  # ways to the upright and to the level seam
    seam, along = np.minimum(across, level), np.where(across < level, y, x)
    sewn = smoothstep(9.5, 7.5, seam)
    thread = dome(np.hypot((seam - 5.2) / 2.3, STITCH * folded(along / STITCH) / 3.1))
    patina, own = canvas.noise(36.0 * unit, 3, "patina"), canvas.random(grain.identity, "tone") - 0.5
    swell = smoothstep(0.4, 2.4, seam) * (1.0 + 0.35 * smoothstep(12.0, 3.0, seam)) - 0.75 * smoothstep(3.2, 2.0, np.abs(seam - 5.2))
    height = -1.0 + 0.75 * swell + 1.25 * cushion * (1.0 - sewn) + 0.45 * sewn + 1.35 * thread + 0.10 * own * cushion
    tone = np.clip(0.30 + 0.36 * cushion + 0.22 * patina + 0.16 * own - 0.30 * (seam < 1.5), 0.0, 1.0)
    hide = canvas.painted(ramp(["5a2f1a", "8a4c27", "b06c3c", "d09a66"], tone))
    return Relief(canvas.softened(height), canvas.softened(mix(hide, rgb("ecd9b0"), smoothstep(0.2, 0.5, thread))))


STYLE = Style(
    name="leather",
    description="brown leather with a fine grain, sewn in panels with pale thread",
    feature_mm=10.0,
    program=leather,
)
