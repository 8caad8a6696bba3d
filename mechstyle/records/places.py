"""Places on a part: which points lie in a shape, and which faces the part stands on.

Regions to protect and places of loads are different records of the same shapes; each decides here what belongs to it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.records.mesh import Bools, Floats, SurfaceMesh

FLOOR_TOLERANCE = 0.1
"""Faces whose corners are this close to the lowest point stand on the floor [mm] …"""
STEEPEST = np.cos(np.radians(5.0))
"""… if they look down within 5°."""


def in_box(points: Floats, low: ArrayLike, high: ArrayLike, *, margin: float = 0.0) -> Bools:
    """Whether points, shape [..., 3], lie between two corners, the border included; all lengths in mm.

    Args:
        points: Positions.
        low: The lowest corner.
        high: The highest corner, which may lie in a plane with the lowest.
        margin: How far outside still counts.
    """
    return np.asarray(((points >= np.asarray(low) - margin) & (points <= np.asarray(high) + margin)).all(axis=-1))


def in_ball(points: Floats, centre: ArrayLike, radius: float, *, margin: float = 0.0) -> Bools:
    """Whether points, shape [..., 3], lie within a radius of a centre, the border included; as `in_box`."""
    return np.asarray(np.linalg.norm(points - np.asarray(centre), axis=-1) <= radius + margin)


def in_half_space(points: Floats, point: ArrayLike, normal: ArrayLike, *, margin: float = 0.0) -> Bools:
    """Whether points, shape [..., 3], lie on the side of a plane that its normal, of any length, points to; as `in_box`."""
    towards = np.asarray(normal, np.float64)
    return np.asarray((points - np.asarray(point)) @ towards >= -margin * np.linalg.norm(towards))


def on_floor(surface: SurfaceMesh) -> Bools:
    """Whether each face lies flat on the floor, which is at the lowest vertex, shape [face_count]."""
    low = surface.corners[:, :, 2] < surface.vertices[:, 2].min() + FLOOR_TOLERANCE
    return np.asarray(low.all(axis=1) & (surface.face_normals[:, 2] < -STEEPEST))
