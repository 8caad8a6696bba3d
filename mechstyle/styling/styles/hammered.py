"""Hammered metal: shallow round dents side by side, polished."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.canvas import Canvas
from mechstyle.styling.style import Relief, Style
from mechstyle.styling.tones import mix, ramp, rgb, smoothstep

DENT = 13.0


def hammered(canvas: Canvas) -> Relief:
    """Each blow leaves a bowl; where bowls meet stands a crest. Light from above falls on the lower side of a bowl."""
    unit = canvas.unit("dents", DENT, edges=4.5)
    dents = canvas.stamps(canvas.scattered(0.85 * DENT * unit, "dents"), 0.85 * DENT * unit, count=4)
    size = DENT * unit * (0.90 + 0.20 * canvas.random(dents.identity, "size"))
    bowls = (dents.x**2 + dents.y**2) / size**2 - 0.06 * canvas.random(dents.identity, "blow")
    nearest = bowls.argmin(axis=1)[:, None]
    bowl, up = (np.take_along_axis(values, nearest, axis=1)[:, 0] for values in (bowls, dents.y / size))
    crest = smoothstep(0.12, 0.36, bowl)
    cloud = canvas.noise(30.0 * unit, 2, "cloud")
    tarnish = smoothstep(0.10, 0.70, canvas.noise(38.0 * unit, 3, "tarnish"))
    tone = np.clip(0.42 - 0.45 * up + 0.36 * crest + 0.12 * cloud, 0.0, 1.0)
    colour = canvas.painted(ramp(["4d5259", "7c8289", "a9aeb3", "d2d5d8", "f4f4f2"], canvas.softened(tone)))
    return Relief(canvas.softened(-0.75 + 4.0 * np.clip(bowl, 0.0, 0.45)), mix(colour, rgb("6e665c"), 0.45 * tarnish))


STYLE = Style(
    name="hammered",
    words=("hammer", "metal", "metallic", "beaten", "forged", "pewter", "steel", "iron", "tin"),
    description="polished metal beaten into shallow round dents",
    feature_mm=DENT,
    program=hammered,
)
