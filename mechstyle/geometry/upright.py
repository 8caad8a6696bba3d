"""Which way is up: the axis of a file that points up as the part stands, whether it seems to be another one, and how it would print so."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.errors import unknown
from mechstyle.geometry.resting_face import resting_face
from mechstyle.records.mesh import Floats, SurfaceMesh

UPS = ("z", "-z", "y", "-y", "x", "-x")
_BASE = 0.2  # share of its footprint that a flat face must have to be taken for the base of a part that lies on its side
_SLENDER, _FLATTER = 6.0, 5.0  # times its width that a part is high which stands on an edge, and how much larger its flat side is


def upright(up: str) -> Floats:
    """The rotation that turns an axis of a file up, by the shortest way, shape [3, 3]; for positions as columns; BadInput for no axis."""
    if up not in UPS:
        raise unknown("axis for up", up, UPS)
    towards = axis(up)
    if up[-1] == "z":
        return np.diag([1.0, towards[2], towards[2]])
    turn = np.zeros((3, 3))
    across = np.cross(towards, [0.0, 0.0, 1.0])  # what stays as it is
    turn += np.outer([0.0, 0.0, 1.0], towards) - np.outer(towards, [0.0, 0.0, 1.0]) + np.outer(across, across)
    return turn


def axis(up: str) -> Floats:
    """The unit vector of one of UPS, shape [3]."""
    return np.eye(3)["xyz".index(up[-1])] * (-1.0 if up[0] == "-" else 1.0)


def lying(mesh: SurfaceMesh, axes: Floats) -> str:
    """The axis that is probably up where a part [mm] stands on nothing flat but could; "" for none; `axes` turned those of its file."""
    if resting_face(mesh) is not None:
        return ""
    shares = {up: _base(mesh, axes @ axis(up)) for up in UPS}
    best = max(UPS, key=lambda up: shares[up])
    return best if shares[best] >= _BASE else ""


def on_edge(mesh: SurfaceMesh, axes: Floats) -> str:
    """The axis that is probably up where a flat part [mm] stands on its thin edge; "" for none; `axes` as for `lying`."""
    found = resting_face(mesh)
    if found is None or _width(found.polygon) > mesh.extents[2] / _SLENDER:
        return ""
    areas = {up: there.area for up in UPS if (there := resting_face(_turned(mesh, axes @ axis(up)))) is not None}
    best = max(areas, key=lambda up: areas[up])
    return best if areas[best] > _FLATTER * found.area else ""


def _width(polygon: Floats) -> float:
    """The least distance of two parallel lines that hold a convex polygon between them [mm]; its corners have shape [n, 2]."""
    edges = np.roll(polygon, -1, axis=0) - polygon
    normals = np.column_stack([-edges[:, 1], edges[:, 0]]) / np.linalg.norm(edges, axis=1, keepdims=True)
    return float(np.ptp(polygon @ normals.T, axis=0).min())


def _turned(mesh: SurfaceMesh, up: Floats) -> SurfaceMesh:
    return SurfaceMesh(mesh.vertices @ upright(named(up)).T, mesh.faces)


def _base(mesh: SurfaceMesh, up: Floats) -> float:
    """Area of the flat face a part would stand on with a direction up, over that of its footprint there; 0 if it stood on none."""
    there = _turned(mesh, up)
    found = resting_face(there)
    if found is None:
        return 0.0
    below = there.face_normals[:, 2] < 0.0
    footprint = float(there.face_areas[below] @ -there.face_normals[below, 2])
    return found.area / footprint


def named(direction: Floats) -> str:
    """The one of UPS that a direction along an axis is."""
    at = int(np.abs(direction).argmax())
    return ("-" if direction[at] < 0.0 else "") + "xyz"[at]


STEEPEST = 45.0
"""Faces that lean out further than this from upright need support [degrees]."""
ON_BED = 0.2
"""Faces with all corners this near to the bed lie on it [mm]: the first layer."""


class Standing(NamedTuple):
    """A part on the bed."""

    overhang: float  # area of faces that need support [mm²]
    height: float  # how high it is [mm]
    base: float  # area that lies on the bed [mm²]


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
