"""Flat ends with which a part meets something else: feet, the rim of a box, the ends of a tube."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from mechstyle.geometry.borders import Extent
from mechstyle.records.mesh import Bools, Indices, SurfaceMesh

WAYS = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1))
"""Directions in which ends are looked for; downwards lies the base, which is another matter."""
FLAT = 5e-4
"""How far off a plane its faces may lie, over the size of the part."""
ALONG = float(np.cos(np.radians(2.0)))
"""Least cosine of the angle between a face and the plane in which it lies."""
LEAST, MOST = 0.005, 0.05
"""Least and largest share of the surface: what is smaller is where a curve touches the plane, what is larger carries the style."""
FILLED = 0.6
"""Largest share that the ends have of what they span: a side that is filled is a wall, not feet or a rim."""


def mating_ends(mesh: SurfaceMesh) -> Extent:
    """The flat ends of a closed surface [mm] that may meet something else.

    A flat thing that is laid against the part along an axis touches feet in several places, and a rim or the end of a tube around a hole,
    both in a small share of what they span.
    """
    depth = np.full(len(mesh.vertices), np.inf)
    for way in WAYS:
        below = mesh.vertices @ -np.array(way, np.float64)
        below -= below.min() + FLAT * mesh.size
        there = (below < 0.0)[mesh.faces].all(axis=1) & (mesh.face_normals @ np.array(way) > ALONG)
        touched, whole = float(mesh.face_areas[there].sum()), float(mesh.face_areas.sum())
        small = LEAST * whole < touched < MOST * whole and touched < FILLED * _spanned(mesh, there, int(np.abs(way).argmax()))
        if small and _feet_or_ring(mesh.faces[there]):
            flat = np.isin(np.arange(len(below)), mesh.faces[there])
            depth = np.minimum(depth, np.where(flat, below, np.maximum(below, np.finfo(float).tiny)))
    return Extent.below(mesh, depth)


def _feet_or_ring(faces: Indices) -> bool:
    """Whether faces in a plane lie in several places or around a hole: the Euler characteristic of one place without is 1."""
    edges = np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0)
    used, ends = np.unique(edges, return_inverse=True)
    ends = ends.reshape(-1, 2)
    places = connected_components(coo_array((np.ones(len(ends)), ends.T), shape=(len(used),) * 2), directed=False)[0]
    return bool(places > 1 or len(used) - len(edges) + len(faces) < places)


def _spanned(mesh: SurfaceMesh, faces: Bools, axis: int) -> float:
    """Area of the convex outline of faces in a plane across an axis [mm²]."""
    try:
        return float(ConvexHull(np.delete(mesh.corners[faces].reshape(-1, 3), axis, axis=1)).volume)
    except QhullError:
        return 0.0
