"""How a part stands while it is printed: what hangs over, how high it is, and what holds it to the bed."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.records.mesh import SurfaceMesh

STEEPEST = 45.0
"""Faces that lean out further than this from upright need support [degrees]."""
ON_BED = 0.2
"""Faces with all corners this near to the bed lie on it [mm]: the first layer."""


class Standing(NamedTuple):
    """A part on the bed.

    Attributes:
        overhang: Area of faces that need support [mm²].
        height: How high it is [mm].
        base: Area that lies on the bed [mm²].
    """

    overhang: float
    height: float
    base: float


def standing(mesh: SurfaceMesh, up: ArrayLike) -> Standing:
    """A part printed with a direction of its frame upwards, shape [3]."""
    direction = np.asarray(up, np.float64) / np.linalg.norm(up)
    height = mesh.vertices @ direction
    height -= height.min()
    rises = mesh.face_normals @ direction
    on_bed = (height[mesh.faces] <= ON_BED).all(axis=1)
    hanging = (rises < -math.cos(math.radians(STEEPEST))) & ~on_bed
    base = mesh.face_areas[on_bed] @ np.maximum(-rises[on_bed], 0.0)
    return Standing(float(mesh.face_areas[hanging].sum()), float(height.max()), float(base))
