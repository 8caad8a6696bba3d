"""Courses of brick in running bond with recessed, light mortar."""

from __future__ import annotations

import numpy as np

from mechstyle.stylize.canvas import Canvas
from mechstyle.stylize.style import Relief, Style
from mechstyle.stylize.tones import mix, ramp, rgb, smoothstep

LENGTH, HEIGHT, JOINT = 22.0, 10.0, 3.4


def brick(canvas: Canvas) -> Relief:
    """Level courses of one size, each brick with its own tone, set and wear."""
    unit = canvas.unit("mortar joints", JOINT)
    length, height, joint = LENGTH * unit, HEIGHT * unit, JOINT * unit
    bond = canvas.bond(length, height, margin=0.75 * joint)
    wear = canvas.noise(5.0 * unit, 3, "wear")
    to_joint = np.minimum((0.5 - np.abs(bond.x)) * length, (0.5 - np.abs(bond.y)) * height) + 0.12 * joint * wear
    face = smoothstep(0.22 * joint, 0.80 * joint, to_joint)

    identity = canvas.pieces(face > 0.5, bond.odd)
    tone = canvas.random(identity, "tone")
    bricks = 0.62 + 0.30 * canvas.random(identity, "set") + 0.22 * wear
    mortar = -0.62 + 0.10 * canvas.noise(3.0 * unit, 2, "mortar")
    fired = ramp(["6d2a22", "8f3a2b", "a8472f", "b95a3a", "c47a55"], np.clip(tone + 0.30 * wear, 0.0, 1.0))
    grime = 1.0 + 0.16 * canvas.noise(30.0 * unit, 3, "grime")
    colour = mix(rgb("c9c2b4"), fired * (1.0 + 0.22 * wear[:, None]), smoothstep(0.30, 0.75, face)) * grime[:, None]
    return Relief(mortar + (bricks - mortar) * face, np.clip(colour, 0.0, 1.0), face)


STYLE = Style(
    name="brick",
    words=("brickwork", "masonry", "bricklaying"),
    description="courses of fired brick in running bond with recessed, light mortar",
    feature_mm=HEIGHT,
    program=brick,
)
