"""A believable worn surface: hand-finished plaster with pits, cracks, stains, dirt in hollows and wear on edges."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style


def realistic(canvas: Canvas) -> Relief:
    """Strokes of a trowel, pits, cracks, and patches where the coat has fallen off; colour follows shape as dirt and wear do."""
    unit = canvas.unit("cracks", 3.4)
    broad = canvas.noise(40.0 * unit, 2, "broad")
    lumps = canvas.noise(7.5 * unit, 3, "lumps")
    strokes = canvas.cells(24.0 * unit, "strokes", at=canvas.warped(18.0 * unit, 7.0 * unit, "strokes"))
    ridge = smoothstep(3.0, 0.4, strokes.edge / unit)
    cracks = canvas.cells(55.0 * unit, "cracks", at=canvas.warped(18.0 * unit, 9.0 * unit, "cracks"))
    there = smoothstep(0.05, 0.35, canvas.noise(45.0 * unit, 2, "where cracked"))
    crack = smoothstep(2.6, 0.6, cracks.edge / unit) * there
    pit = smoothstep(0.31, 0.49, canvas.noise(8.5 * unit, 2, "pits"))
    worn = smoothstep(0.22, 0.32, canvas.noise(30.0 * unit, 4, "worn"))
    coat = 0.35 + 0.50 * (canvas.random(strokes.identity, "stroke") - 0.5) + 0.45 * ridge + 0.15 * broad + 0.90 * lumps - 0.90 * pit
    height = 0.8 * canvas.softened(np.clip(coat - 1.10 * crack + worn * (-0.70 + 0.90 * lumps - coat), -1.6, 1.6))

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
    description="worn, hand-finished plaster: strokes of a trowel, pits, cracks and bare patches, dirt in the hollows, stains running down",
    feature_mm=21.0,
    program=realistic,
)
