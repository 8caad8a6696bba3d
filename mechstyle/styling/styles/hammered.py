"""Hammered metal: round dents side by side, polished."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

DENT = 15.0


def hammered(canvas: Canvas) -> Relief:
    """Each blow leaves a bowl; where bowls meet stands a bright crest. Light from above falls on the lower side of a bowl."""
    unit = canvas.unit("dents", DENT, edges=4.5)
    spacing = 0.80 * DENT * unit
    dents = canvas.stamps(canvas.scattered(spacing, "dents"), spacing, count=5)
    x, y = dents.x / spacing, dents.y / spacing
    bowls = x**2 + y**2 - 0.10 * canvas.random(dents.identity, "blow")
    order = np.argsort(bowls, axis=1)
    lowest, next_lowest = (np.take_along_axis(bowls, order[:, k : k + 1], axis=1)[:, 0] for k in (0, 1))
    along, up = (np.take_along_axis(offset, order[:, :1], axis=1)[:, 0] for offset in (x, y))
    crest = smoothstep(0.34, 0.0, next_lowest - lowest)
    cloud = canvas.noise(45.0 * unit, 2, "cloud")
    tone = np.clip(0.38 - 0.55 * up + 0.18 * along + 0.10 * cloud + 0.42 * crest, 0.0, 1.0)
    steel = ramp(["3b424b", "68717b", "9aa2aa", "cbd0d4", "f2f3f2"], tone)
    colour = mix(canvas.painted(steel), rgb("fbfaf5"), 0.15 * crest)
    height = -0.85 + 3.2 * np.clip(lowest, 0.0, 0.55)
    return Relief(canvas.softened(height), canvas.softened(colour))


STYLE = Style(
    name="hammered",
    words=("hammer", "metal", "metallic", "beaten", "forged", "pewter", "steel", "iron", "tin"),
    description="polished metal beaten into round dents with bright crests between",
    feature_mm=DENT,
    program=hammered,
)
