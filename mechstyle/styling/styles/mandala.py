"""Round mandalas of coloured petals, inlaid in mahogany."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style
from mechstyle.styling.styles.wood import grain

RADIUS = 30.0
# Rings of petals: inner and outer radius over that of the mandala, number of petals, colours of every other petal.
RINGS = (
    (0.10, 0.48, 8, ("e8a32e", "e8a32e")),
    (0.36, 0.72, 8, ("c8323f", "c8323f")),
    (0.52, 0.82, 16, ("2c9c9c", "3f62a8")),
    (0.78, 1.00, 24, ("efc94c", "e2703a")),
)


def mandala(canvas: Canvas) -> Relief:
    """Mandalas apart from each other, away from edges where there is room, their inner rings over the outer ones."""
    unit = canvas.unit("petals", 6.0, edges=2.5)
    late, fibre, _ = grain(canvas, unit)
    tone = np.clip(0.55 - 0.42 * late + 0.28 * fibre, 0.0, 1.0)
    colour = canvas.painted(ramp(["2c0f0a", "541d12", "7c3120", "9c4a30"], tone))
    height = -0.62 - 0.22 * late + 0.10 * fibre

    radius = RADIUS * unit
    flat = np.linalg.norm(canvas.smoothed(canvas.mesh.vertex_normals, 0.5 * radius), axis=1)
    centres = canvas.scattered(2.1 * radius, "mandalas", among=flat > np.quantile(flat, 0.5))
    stamps = canvas.stamps(centres, 2.1 * radius)
    reach, angle = np.hypot(stamps.x, stamps.y)[:, 0] / radius, np.arctan2(stamps.y, stamps.x)[:, 0]
    level = smoothstep(0.25, 0.50, stamps.facing[:, 0])
    for ring, (inner, outer, count, hues) in reversed(list(enumerate(RINGS))):
        turn = angle * count / (2.0 * np.pi) + 0.5 * (ring % 2)
        petal = np.round(turn)
        out = np.clip((reach - inner) / (outer - inner), 0.0, 1.0)
        inside = np.sin(np.pi * out) ** 0.65 - 2.1 * np.abs(turn - petal)
        cover = smoothstep(0.0, 0.35, inside) * level
        body = np.where((petal % 2 == 0)[:, None], rgb(hues[0]), rgb(hues[1])) * (0.70 + 0.38 * smoothstep(0.1, 0.9, inside))[:, None]
        colour = mix(mix(colour, 0.45 * colour, smoothstep(-0.5, 0.0, inside) * level * (out > 0.0) * (out < 1.0)), body, cover)
        height += cover * (0.25 + 0.45 * smoothstep(0.0, 1.0, inside) + 0.10 * (3 - ring) - height)
    eye = smoothstep(0.19, 0.12, reach) * level
    return Relief(canvas.softened(height + eye * (1.1 - height)), canvas.softened(np.clip(mix(colour, rgb("f3ead2"), eye), 0.0, 1.0)))


STYLE = Style(
    name="mandala",
    words=("mandalas", "mandala_wood", "mandala_mahogany", "mandala_mahogany_wood", "rosette"),
    description="round mandalas of coloured petals, inlaid in mahogany",
    feature_mm=12.0,
    program=mandala,
)
