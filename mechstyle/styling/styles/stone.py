"""Rounded field stones set close, with dark deep gaps."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

STONE, GAP = 15.0, 3.4


def stone(canvas: Canvas) -> Relief:
    """Worley cells with broken outlines, each a stone of its own height, tilt and tone."""
    unit = canvas.unit("gaps between stones", GAP, edges=1.6)
    cells = canvas.cells(STONE * unit, "stones", at=canvas.warped(14.0 * unit, 3.2 * unit, "outline"))
    edge = cells.edge / unit
    face = smoothstep(0.25 * GAP, 1.0 * GAP, edge)
    rounding = smoothstep(0.3 * GAP, 0.55 * STONE, edge)
    rough = canvas.noise(7.0 * unit, 4, "rough")
    grain = canvas.noise(3.5 * unit, 2, "grain")
    own = canvas.random(cells.identity, "height")
    top = 0.10 + 0.35 * own + 0.55 * rounding + 0.28 * rough
    tone = np.clip(0.5 + 0.55 * (canvas.random(cells.identity, "tone") - 0.5) + 0.30 * rough + 0.15 * grain, 0.0, 1.0)
    cool = ramp(["5d6064", "84878a", "a8aaaa", "cfcfca"], tone)
    warm = ramp(["65584a", "8f806c", "b3a48d", "d6cab4"], tone)
    body = mix(cool, warm, smoothstep(0.35, 0.65, canvas.random(cells.identity, "hue")))
    colour = mix(rgb("4b453d"), canvas.painted(body), face)
    return Relief(canvas.softened(-0.85 + (0.85 + top) * face), canvas.softened(colour))


STYLE = Style(
    name="stone",
    description="field stones set close, rounded and rough, with dark gaps",
    feature_mm=STONE,
    program=stone,
)
