"""Crystals grown side by side: tall facets that meet in sharp ridges."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

SHARD = 25.0  # length of a crystal
STRETCH = np.array([1.0, 1.0, 0.6])  # crystals are longer upwards


def crystal(canvas: Canvas) -> Relief:
    """Every shard rises to a roof of flat faces, of its own height."""
    unit = canvas.unit("facets", 0.3 * SHARD, edges=2.2)
    shards = canvas.cells(0.7 * SHARD * unit, "shards", stretch=STRETCH)
    own = canvas.random(shards.identity, "height")
    facet = canvas.random(shards.facet, "facet")
    edge = shards.edge / (0.7 * SHARD * unit)
    height = -0.85 + (1.3 + 0.4 * own) * np.minimum(edge / 0.36, 1.1) + 0.42 * (own - 0.5)
    tone = np.clip(0.10 + 0.70 * facet + 0.25 * own, 0.0, 1.0)
    colour = canvas.painted(ramp(["3a1f63", "6d3fa6", "a67ad2", "e4d2f5"], tone))
    colour = mix(colour, rgb("f4ecff"), 0.5 * smoothstep(0.34, 0.42, edge))
    return Relief(canvas.softened(height), canvas.softened(mix(colour, rgb("2a1548"), smoothstep(0.05, 0.0, edge))))


STYLE = Style(
    name="crystal",
    description="crystals grown side by side, flat facets that meet in sharp ridges",
    feature_mm=SHARD,
    program=crystal,
)
