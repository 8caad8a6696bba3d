"""Thrown and fired clay: rings left by the fingers, bands of combed waves, lime bloom."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import folded
from mechstyle.styling.style import Relief, Style

BAND, WAVE = 36.0, 22.0


def terracotta(canvas: Canvas) -> Relief:
    """Every band has fine throwing rings, two grooves, and between these a wave drawn into the wet clay."""
    unit = canvas.unit("grooves", 3.6)
    bond = canvas.bond(WAVE * unit, BAND * unit, shift=0.0, grip=0.5)
    up = bond.y * BAND
    rings = (1.0 - 4.0 * folded(up / (BAND / 6.0)) ** 2 * 2.0) * smoothstep(9.0, 11.0, np.abs(up))  # sharp between the fingers' hollows
    groove = np.exp(-(((np.abs(up) - 7.6) / 1.5) ** 2))
    wave = np.exp(-(((up - 3.0 * np.cos(2.0 * np.pi * bond.x)) / 1.6) ** 2))
    slip = smoothstep(6.6, 5.0, np.abs(up))
    lumps = canvas.noise(24.0 * unit, 3, "lumps")
    grit = canvas.noise(5.0 * unit, 2, "grit")
    fire = canvas.noise(50.0 * unit, 2, "fire")
    bloom = smoothstep(0.10, 0.75, canvas.noise(26.0 * unit, 4, "bloom"))
    cut = np.maximum(groove, wave * slip)
    clay = ramp(["8a4228", "b25a36", "c97248", "dd9468"], np.clip(0.52 + 0.35 * fire + 0.18 * grit + 0.16 * rings, 0.0, 1.0))
    clay = mix(canvas.painted(clay), rgb("eed9bf"), 0.72 * slip)
    colour = mix(mix(clay, rgb("f0dfca"), 0.40 * bloom * (1.0 - slip)), rgb("7a351f"), 0.85 * cut)
    height = 0.10 + 0.62 * rings + 0.15 * lumps + 0.08 * grit + 0.50 * slip - 1.45 * cut
    return Relief(canvas.softened(height), canvas.softened(colour))


STYLE = Style(
    name="terracotta",
    description="thrown, fired clay with finger rings, grooves and waves drawn on bands of pale slip",
    feature_mm=12.0,
    program=terracotta,
)
