"""Round mandalas of coloured petals, inlaid in mahogany."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style
from mechstyle.styling.styles.wood import grain

RADIUS = 32.0
# Rings of petals: inner and outer radius over that of the mandala, number of petals, colours of every other petal.
RINGS = (
    (0.12, 0.54, 8, ("e8a32e", "e8a32e")),
    (0.42, 0.80, 8, ("c8323f", "c8323f")),
    (0.76, 1.00, 16, ("2c9c9c", "efc94c")),
)


def mandala(canvas: Canvas) -> Relief:
    """Mandalas apart from each other and from sharp edges, their inner rings over the outer ones."""
    unit = canvas.unit("petals", 6.0, edges=2.5)
    late, fibre, _ = grain(canvas, unit)
    tone = np.clip(0.55 - 0.42 * late + 0.28 * fibre, 0.0, 1.0)
    colour = canvas.painted(ramp(["2c0f0a", "541d12", "7c3120", "9c4a30"], tone))
    height = -0.75 + 0.35 * late + 0.10 * fibre

    radius = RADIUS * unit
    stamps = canvas.stamps(canvas.scattered(2.05 * radius, "mandalas", room=0.9 * radius), 2.05 * radius)
    reach, angle = np.hypot(stamps.x, stamps.y)[:, 0] / radius, np.arctan2(stamps.y, stamps.x)[:, 0]
    level = smoothstep(0.25, 0.50, stamps.facing[:, 0])
    # A sunken disc, on which petals stand apart.
    height += smoothstep(1.06, 1.00, reach) * level * (-1.0 - height)
    for ring, (inner, outer, count, hues) in reversed(list(enumerate(RINGS))):
        turn = angle * count / (2.0 * np.pi) + 0.5 * (ring % 2)
        petal = np.round(turn)
        out = np.clip((reach - inner) / (outer - inner), 0.0, 1.0)
        inside = np.sin(np.pi * out) ** 0.65 - 2.1 * np.abs(turn - petal)
        cover = smoothstep(0.02, 0.22, inside) * level
        gap = smoothstep(-0.35, 0.0, inside) * level * (out > 0.0) * (out < 1.0)
        body = np.where((petal % 2 == 0)[:, None], rgb(hues[0]), rgb(hues[1])) * (0.70 + 0.38 * smoothstep(0.1, 0.9, inside))[:, None]
        colour = mix(mix(colour, 0.45 * colour, gap), body, cover)
        height += gap * (-0.95 - height)
        # A petal is a shallow dish with a raised rim.
        height += cover * (0.75 - 0.45 * smoothstep(0.35, 0.65, inside) + 0.12 * (2 - ring) - height)
    eye = smoothstep(0.21, 0.15, reach) * level
    return Relief(canvas.softened(height + eye * (1.1 - height)), canvas.softened(np.clip(mix(colour, rgb("f3ead2"), eye), 0.0, 1.0)))


STYLE = Style(
    name="mandala",
    description="round mandalas of coloured petals, inlaid in mahogany",
    feature_mm=15.0,
    program=mandala,
)
