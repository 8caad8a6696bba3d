"""Raised flat dots in staggered rows."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

PITCH, DOT = 13.0, 4.4


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


STYLE = Style(
    name="dots",
    description="raised round dots in staggered rows, white on blue",
    feature_mm=PITCH,
    program=dots,
)
