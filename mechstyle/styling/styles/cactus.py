"""Upright ribs with clusters of spines along their ridges."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

RIB, PITCH, SPINE = 18.0, 11.0, 7.0


def cactus(canvas: Canvas) -> Relief:
    """Ribs an even number around, areoles on the ridges, staggered from rib to rib."""
    unit = canvas.unit("spines", 4.0)
    # Cells two ribs wide and half a pitch high, in running bond: their centres are the areoles of staggered ribs.
    bond = canvas.bond(2.0 * RIB * unit, 0.5 * PITCH * unit)
    beside = np.abs(2.0 * bond.x) > 0.5
    x = (np.abs(bond.x) - np.where(beside, 0.5, 0.0)) * 2.0 * RIB
    y = (np.abs(bond.y) - np.where(beside, 1.0, 0.0)) * 0.5 * PITCH
    ridge = 1.0 - np.abs(2.0 * x / RIB) ** 1.4  # sharp valleys between round ribs
    tubercle = ridge * np.cos(2.0 * np.pi * y / PITCH)  # every cluster sits on a swelling of its rib
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    reach = SPINE * (0.35 + 0.65 * np.cos(3.0 * angle) ** 2)
    star = smoothstep(1.0, 0.45, radius / reach)
    wool = smoothstep(3.2, 1.4, radius)
    skin = canvas.noise(9.0 * unit, 3, "skin")
    tone = np.clip(0.12 + 0.75 * ridge + 0.22 * skin, 0.0, 1.0)
    green = ramp(["14401f", "266b33", "46964a", "86bd66"], tone)
    colour = mix(mix(canvas.painted(green), rgb("f6eecb"), star), rgb("b0813f"), wool)
    height = -0.95 + 0.95 * ridge + 0.50 * tubercle + 0.50 * star + 0.45 * wool + 0.06 * skin
    return Relief(canvas.softened(height), canvas.softened(colour))


STYLE = Style(
    name="cactus",
    description="upright green ribs with clusters of pale spines along their ridges",
    feature_mm=RIB,
    program=cactus,
)
