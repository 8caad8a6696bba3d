"""Courses of brick in running bond with recessed, light mortar."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

LENGTH, HEIGHT, JOINT = 22.0, 10.0, 3.4


def brick(canvas: Canvas) -> Relief:
    """Level courses of one size, each brick with its own tone, set and wear."""
    unit = canvas.unit("mortar joints", JOINT, edges=1.6)
    length, height, joint = LENGTH * unit, HEIGHT * unit, JOINT * unit
    bond = canvas.bond(length, height, margin=0.75 * joint, grip=0.1)
    wear = canvas.noise(7.0 * unit, 2, "wear")
    to_joint = np.minimum((0.5 - np.abs(bond.x)) * length, (0.5 - np.abs(bond.y)) * height) + 0.10 * joint * wear
    face = smoothstep(0.20 * joint, 0.80 * joint, to_joint)

    identity = canvas.pieces(face > 0.5, bond.odd)
    tone = canvas.random(identity, "tone")
    bricks = 0.60 + 0.35 * canvas.random(identity, "set") + 0.22 * wear
    mortar = -0.65 + 0.10 * canvas.noise(4.0 * unit, 2, "mortar")
    fired = ramp(["7a3026", "96402f", "a84a34", "b55a3e", "c67d58"], np.clip(tone + 0.22 * wear, 0.0, 1.0))
    fired = fired * (1.0 + 0.14 * wear)[:, None]
    grime = 1.0 + 0.12 * canvas.noise(30.0 * unit, 3, "grime")
    colour = mix(rgb("d9d1c2"), canvas.painted(fired), smoothstep(0.25, 0.75, face)) * grime[:, None]
    return Relief(canvas.softened(mortar + (bricks - mortar) * face), canvas.softened(np.clip(colour, 0.0, 1.0)))


STYLE = Style(
    name="brick",
    description="courses of fired brick in running bond with recessed, light mortar",
    feature_mm=HEIGHT,
    program=brick,
)
