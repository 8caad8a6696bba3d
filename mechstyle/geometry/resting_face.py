"""The face a part stands on, and how much of a relief is allowed near it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from mechstyle.records.mesh import Floats, Indices, SurfaceMesh, on_floor

SMALLEST_SHARE = 0.02
"""A support polygon below this share of the part's footprint carries nothing: a sphere has no resting face."""


@dataclass(frozen=True, eq=False)
class RestingFace:
    """The flat underside a part stands on."""

    faces: Indices  # indices of its faces, shape [resting_count]
    polygon: Floats  # corners of the support polygon seen from above, anticlockwise [mm], shape [corner_count, 2]
    height: float  # where the floor is [mm]
    area: float  # area of its faces [mm²]


def resting_face(mesh: SurfaceMesh) -> RestingFace | None:
    """The face a closed surface stands on as placed, or None if it would roll, tip or stand on a point."""
    floor = float(mesh.vertices[:, 2].min())
    faces = np.flatnonzero(on_floor(mesh)).astype(np.int32)
    support = _hull(mesh.corners[faces].reshape(-1, 3)[:, :2])
    footprint = _hull(mesh.vertices[:, :2])
    if support is None or footprint is None or support.volume < SMALLEST_SHARE * footprint.volume:
        return None
    inside = support.equations[:, :2] @ mesh.centre_of_mass[:2] + support.equations[:, 2] <= 0.0
    if not inside.all():
        return None
    return RestingFace(faces, support.points[support.vertices], floor, float(mesh.face_areas[faces].sum()))


def resting_weight(mesh: SurfaceMesh, *, low: float = 1.0, high: float = 5.0) -> Floats:
    """Factor on a relief that keeps the resting face flat, in [0, 1], shape [vertex_count]; all 1 for a part without one.

    It is 0 up to the height `low` above the floor, and 1 from `high` on [mm].
    """
    if resting_face(mesh) is None:
        return np.ones(len(mesh.vertices))
    height = mesh.vertices[:, 2] - mesh.vertices[:, 2].min()
    return np.clip((height - low) / (high - low), 0.0, 1.0)


def _hull(points: Floats) -> ConvexHull | None:
    """The convex hull of points in the plane (its `volume` is an area), or None if they lie on a line."""
    if len(points) < 3:
        return None
    try:
        return ConvexHull(points)
    except QhullError:
        return None
