"""Round scales in overlapping rows, shining like a fish."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

LENGTH, HEIGHT, LIP = 18.0, 10.0, 3.2


def fish_scales(canvas: Canvas) -> Relief:
    """Scales laid like roof tiles: each hangs over the roots of the two below it and stands off most at its round tip."""
    unit = canvas.unit("lips of scales", LIP, edges=1.6)
    bond = canvas.bond(LENGTH * unit, HEIGHT * unit, grip=0.3)
    # Of the scale hanging from this row: how far aside and down a place is, 1 at its flank and its tip.
    aside, down = 2.0 * np.abs(bond.x), 0.5 - bond.y
    inside = HEIGHT * (1.0 - np.hypot(aside, down))
    over = smoothstep(-0.5 * LIP, 0.5 * LIP, inside)
    # Scales of one row touch in their corners, where the one above has its tip.
    apart = np.minimum(np.hypot(1.0 - aside, down), np.hypot(aside, 1.0 - down)) > 0.25
    own = (canvas.random(canvas.pieces(apart, bond.odd ^ (inside > 0.0)), "tone") - 0.5) * apart
    sheen = canvas.noise(40.0 * unit, 2, "sheen")

    # Where the scale above ends, the one below it shows, half a scale aside and a row down.
    under, upper = ((1.0 - aside, down - 1.0), (aside, down))
    domes = [1.20 * down - 0.45 * aside**2 + 0.12 * own for aside, down in (under, upper)]
    tones = [np.clip(0.42 + 0.40 * down + 0.30 * own + 0.25 * sheen, 0.0, 1.0) for _, down in (under, upper)]
    below, above = (ramp(["123a52", "1f6a7c", "3d9c9b", "86c9b4", "d9ead0"], tone) for tone in tones)
    above = mix(above, rgb("f0dca0"), 0.45 * smoothstep(1.5 * LIP, 0.4 * LIP, inside))
    below = mix(canvas.painted(below), rgb("0a2434"), 0.70 * smoothstep(-1.3 * LIP, 0.0, inside))
    dome = domes[0] + (domes[1] - domes[0]) * over
    colour = mix(below, canvas.painted(above), over)
    return Relief(canvas.softened(dome), canvas.softened(colour))


STYLE = Style(
    name="fish_scales",
    words=("scale", "scaly", "fish", "mermaid", "koi"),
    description="round, overlapping scales that shine from deep blue to pale green",
    feature_mm=HEIGHT,
    program=fish_scales,
)
