"""Paint that flakes off rusty metal."""

from __future__ import annotations

import numpy as np

from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

FLAKE = 16.0


def weathered(canvas: Canvas) -> Relief:
    """A thick, crazed coat of paint with ragged bare patches of rust, rust stains running down from them, and chalky wear."""
    unit = canvas.unit("flakes of paint", 0.3 * FLAKE, edges=2.5)
    broad = canvas.noise(45.0 * unit, 2, "broad")
    chips = canvas.noise(FLAKE * unit, 4, "chips")
    coat = chips + 0.9 * broad + 0.28
    paint = smoothstep(-0.09, 0.09, coat)
    crazed = canvas.cells(13.0 * unit, "crazed", at=canvas.warped(12.0 * unit, 4.0 * unit, "crazed"))
    crack = smoothstep(2.2, 0.7, crazed.edge / unit) * paint
    curl = smoothstep(6.0, 1.6, crazed.edge / unit)  # paint curls up beside a crack
    lip = np.exp(-(((coat - 0.10) / 0.10) ** 2))
    rust = canvas.noise(8.0 * unit, 3, "rust")
    bare = ramp(["3f2018", "6d3320", "9a4d28", "bd7440"], np.clip(0.45 + 0.55 * rust, 0.0, 1.0))
    bleached = canvas.noise(24.0 * unit, 3, "bleached")
    blue = ramp(["2f6470", "488894", "6ba8ae", "9cc8c6"], np.clip(0.5 + 0.45 * bleached + 0.12 * rust, 0.0, 1.0))
    stain = smoothstep(0.05, 0.70, canvas.noise(10.0 * unit, 3, "stains", at=canvas.points * [1.0, 1.0, 0.13]))
    near = smoothstep(0.55, 0.05, coat)
    coated = mix(mix(canvas.painted(blue), rgb("8a5a38"), 0.65 * stain * near), rgb("e2ebe4"), 0.55 * lip)
    height = -0.85 + 0.40 * rust + paint * (1.10 + 0.45 * curl + 0.10 * bleached - 0.40 * rust) + 0.30 * lip - 1.20 * crack
    return Relief(canvas.softened(height), canvas.softened(mix(mix(bare, coated, paint), rgb("5d3a26"), 0.7 * crack)))


STYLE = Style(
    name="weathered",
    description="old paint that flakes off rusty metal, with stains running down",
    feature_mm=FLAKE,
    program=weathered,
)
