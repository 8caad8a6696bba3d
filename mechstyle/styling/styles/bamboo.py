"""Canes of bamboo side by side, with rings at their joints."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import dome
from mechstyle.styling.style import Relief, Style

CANE, JOINT = 14.0, 24.0


def bamboo(canvas: Canvas) -> Relief:
    """Round upright canes whose joints stand higher in every second one; above each joint a pale bloom."""
    unit = canvas.unit("gaps between canes", 0.28 * CANE)
    # Cells two canes wide: one cane in the middle, one half at either side, with its joints half a section higher.
    bond = canvas.bond(2.0 * CANE * unit, JOINT * unit, shift=0.0)
    beside = np.abs(bond.x) > 0.25
    across = 4.0 * np.where(beside, 0.5 - np.abs(bond.x), np.abs(bond.x))
    up = np.where(beside, bond.y - np.copysign(0.5, bond.y), bond.y) * JOINT
    cane = dome(across)
    # A joint is a sheath that stands off, a groove under it, and a swelling below.
    ring = smoothstep(0.2, 1.6, up) * smoothstep(6.5, 2.5, up) + 0.7 * smoothstep(-1.2, -2.6, up) * smoothstep(-7.5, -3.5, up)
    groove = np.exp(-(((up + 0.4) / 1.3) ** 2))
    identity = canvas.pieces((across < 0.85) & (np.abs(up) > 0.6), beside)
    own = canvas.random(identity, "tone") - 0.5
    fibre = canvas.noise(6.0 * unit, 2, "fibre", at=canvas.points * [1.0, 1.0, 0.15])
    bloom = smoothstep(9.0, 2.0, up) * (up > 0.0)
    tone = np.clip(0.15 + 0.60 * cane + 0.35 * own + 0.16 * fibre, 0.0, 1.0)
    colour = ramp(["4a5a20", "7f8d35", "b1b254", "d6cd80"], tone)
    colour = mix(mix(colour, rgb("ece3b4"), 0.55 * bloom + 0.25 * ring * cane), rgb("5a4a22"), 0.75 * groove)
    colour = mix(rgb("2a2c12"), canvas.painted(colour), smoothstep(0.05, 0.55, cane))
    height = -0.95 + 1.20 * cane + smoothstep(0.0, 0.6, cane) * (1.05 * ring - 1.25 * groove) + 0.06 * fibre
    return Relief(canvas.softened(height), canvas.softened(np.clip(colour, 0.0, 1.0)))


STYLE = Style(
    name="bamboo",
    description="upright green canes side by side, with rings at their joints",
    feature_mm=CANE,
    program=bamboo,
)
