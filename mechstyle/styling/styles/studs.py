"""Domed brass studs in staggered rows on dark leather."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Indices
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.colours import mix, ramp, rgb, smoothstep
from mechstyle.styling.style import Relief, Style

PITCH, STUD = 14.5, 4.9


def studs(canvas: Canvas) -> Relief:
    """Half balls pressed into soft leather, which gives way a little around each."""
    unit = canvas.unit("studs", 2.0 * STUD, edges=4.5)
    stamps = canvas.stamps(_middles(canvas, unit), PITCH * unit)
    x, y, facing = stamps.x[:, 0] / unit, stamps.y[:, 0] / unit, smoothstep(0.2, 0.5, stamps.facing[:, 0])
    reach = np.hypot(x, y) / STUD
    dome = np.sqrt(np.clip(1.0 - reach**2, 0.0, 1.0))
    brass = smoothstep(1.12, 0.84, reach) * facing
    seat = np.exp(-(((reach - 1.15) / 0.24) ** 2)) * facing
    hide, worn = canvas.noise(7.0 * unit, 3, "hide"), canvas.noise(40.0 * unit, 2, "worn")
    own = canvas.random(stamps.identity[:, 0], "tone") - 0.5
    # A bright spot up on the side of each dome, as polish would show under a lamp.
    glint = np.exp(-((x**2 + (y - 0.35 * STUD) ** 2) / (0.40 * STUD) ** 2))
    metal = ramp(["6a4518", "a87a2c", "d8b04e", "f4dc90"], np.clip(0.15 + 0.60 * dome + 0.20 * own, 0.0, 1.0))
    metal = mix(metal, rgb("fffbe6"), 0.70 * glint)
    leather = ramp(["1e1512", "38261d", "553a2a", "6f4f3a"], np.clip(0.42 + 0.40 * hide + 0.25 * worn, 0.0, 1.0))
    colour = mix(mix(canvas.painted(leather), rgb("140d0a"), 0.7 * seat), metal, brass)
    height = -0.50 + 0.12 * hide - 0.30 * seat + brass * (0.35 + 1.15 * dome)
    return Relief(canvas.softened(height), canvas.softened(colour))


def _middles(canvas: Canvas, unit: float) -> Indices:
    """Vertices in the middle of the cells of staggered rows, without the cells that an edge or an end of a row cuts."""
    bond = canvas.bond(PITCH * unit, 0.866 * PITCH * unit, grip=0.3)
    reach = np.hypot(bond.x * PITCH, bond.y * 0.866 * PITCH)
    core = reach < 0.8 * STUD
    identity = np.unique(canvas.pieces(core, bond.odd), return_inverse=True)[1]
    order = np.lexsort((reach, identity))
    middle = order[np.unique(identity[order], return_index=True)[1]]
    whole = np.bincount(identity, canvas.mesh.vertex_areas) > 0.7 * np.pi * (0.8 * STUD * unit) ** 2
    return np.asarray(middle[core[middle] & whole], dtype=np.int32)


STYLE = Style(
    name="studs",
    description="domed brass studs in staggered rows on dark leather",
    feature_mm=PITCH,
    program=studs,
)
