"""Art deco: overlapping fans of golden rays on black."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.drawing.tilings import fans, folded
from mechstyle.styling.style import Relief, Style

RADIUS, RAYS = 21.0, 5  # raised rays of a fan


def art_deco(canvas: Canvas) -> Relief:
    """Half rounds in staggered rows, each with a rim, rays that widen outwards, and a boss at its foot."""
    unit = canvas.unit("rays of the fans", 0.28 * RADIUS, edges=2.4)
    bond = canvas.bond(2.0 * RADIUS * unit, 0.5 * RADIUS * unit, grip=0.3)
    here, angle = fans(bond)
    rim = smoothstep(0.80, 0.86, here)
    gap = smoothstep(0.70, 0.74, here) * smoothstep(0.84, 0.80, here)
    sector = np.pi / RAYS
    ray = smoothstep(0.32, 0.22, folded(angle / sector)) * smoothstep(0.30, 0.36, here) * (1.0 - smoothstep(0.68, 0.74, here))
    boss = smoothstep(0.26, 0.20, here)
    gilt = np.max([rim, ray, boss], axis=0)
    gleam = canvas.noise(50.0 * unit, 2, "gleam")
    gold = ramp(["8a6420", "c79a3c", "ecd089"], np.clip(0.40 + 0.35 * here + 0.25 * gleam, 0.0, 1.0))
    black = canvas.painted(np.tile(rgb("17191f"), (len(here), 1)))
    height = -0.55 + 1.10 * gilt + 0.45 * rim - 0.35 * gap + 0.20 * boss + 0.05 * gleam
    return Relief(canvas.softened(height), canvas.softened(mix(black, gold, gilt)))


STYLE = Style(
    name="art_deco",
    description="overlapping fans of golden rays on black",
    feature_mm=0.5 * RADIUS,
    program=art_deco,
)
