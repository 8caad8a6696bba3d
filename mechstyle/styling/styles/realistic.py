"""A believable worn surface: hand-finished plaster with pits, cracks, stains, dirt in hollows and wear on edges."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style


def realistic(canvas: Canvas) -> Relief:
    """Broad trowel marks, pits and a few cracks; colour follows shape as dirt and wear do."""
    unit = canvas.unit("cracks", 3.4)
    broad = canvas.noise(40.0 * unit, 2, "broad")
    lumps = canvas.noise(14.0 * unit, 4, "lumps")
    cracks = canvas.cells(55.0 * unit, "cracks", at=canvas.warped(18.0 * unit, 9.0 * unit, "cracks"))
    there = smoothstep(0.05, 0.35, canvas.noise(45.0 * unit, 2, "where cracked"))
    crack = smoothstep(2.2, 0.3, cracks.edge / unit) * there
    pit = smoothstep(0.38, 0.70, canvas.noise(8.5 * unit, 2, "pits"))
    worn = smoothstep(0.25, 0.60, canvas.noise(26.0 * unit, 4, "worn"))
    height = 0.50 * broad + 0.50 * lumps - 0.70 * crack - 0.60 * pit - 0.35 * worn

    around = canvas.smoothed(height, 8.0 * unit)
    dirt = smoothstep(0.0, 0.8, around - height)
    rubbed = smoothstep(0.05, 0.6, height - around)
    streak = smoothstep(0.0, 0.8, canvas.noise(11.0 * unit, 3, "streaks", at=canvas.points * [1.0, 1.0, 0.15]))
    colour = ramp(["b29c7c", "c7b393", "d8c8ab", "e4d8c0"], np.clip(0.5 + 0.35 * broad + 0.35 * lumps, 0.0, 1.0))
    colour = mix(colour, rgb("b58a6b"), 0.65 * worn)
    colour = mix(colour, rgb("96876d"), 0.45 * streak)
    colour = mix(colour, rgb("f2eadb"), 0.45 * rubbed)
    colour = mix(canvas.painted(colour), rgb("6b5d4a"), np.maximum(0.60 * dirt, 0.75 * crack))
    return Relief(height, colour)


STYLE = Style(
    name="realistic",
    words=("realism", "real", "lifelike", "natural", "photorealistic", "plaster", "worn", "aged", "antique", "old"),
    description="worn, hand-finished plaster: soft unevenness, pits and cracks, dirt in the hollows, stains running down",
    feature_mm=11.0,
    program=realistic,
    yields=True,
)
