"""Hammered metal: round dents side by side, polished."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

DENT = 15.0


def hammered(canvas: Canvas) -> Relief:
    """Each blow leaves a bowl; where bowls meet stands a bright crest."""
    unit = canvas.unit("dents", DENT, edges=4.5)
    spacing = 0.80 * DENT * unit
    dents = canvas.cells(spacing, "dents")
    blow = canvas.random(dents.identity, "blow")
    # From the crest down into the bowl, steep at first; a smooth bowl of its own depth for every blow.
    bowl = 1.0 - (1.0 - np.clip(dents.edge / (0.55 * spacing), 0.0, 1.0)) ** 2
    height = 0.95 - (1.45 + 0.60 * blow) * bowl
    crest = smoothstep(0.16, 0.0, dents.edge / spacing)
    cloud = canvas.noise(45.0 * unit, 2, "cloud")
    tone = np.clip(0.66 - 0.42 * bowl + 0.22 * (blow - 0.5) + 0.12 * cloud, 0.0, 1.0)
    steel = ramp(["3b424b", "68717b", "9aa2aa", "cbd0d4", "f2f3f2"], tone)
    colour = mix(canvas.painted(steel), rgb("fbfaf5"), 0.55 * crest)
    return Relief(canvas.softened(height), canvas.softened(colour))


STYLE = Style(
    name="hammered",
    description="polished metal beaten into round dents with bright crests between",
    feature_mm=DENT,
    program=hammered,
)
