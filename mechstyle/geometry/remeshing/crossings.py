"""Self-intersections of a surface: faces that cross, and places where more than a printer resolves is inside twice."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from mechstyle._warp import wp
from mechstyle.geometry.kernels import count_crossings, turns_exceed
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.tolerances import TOL
from mechstyle.records.mesh import Floats, Indices, SurfaceMesh


class Crossings(NamedTuple):
    """Faces of a surface that cross."""

    pairs: int  # how many pairs do
    other: Indices  # a face that each face crosses, -1 if there is none, shape [face_count]


def crossings(mesh: SurfaceMesh, tree: TriangleTree | None = None) -> Crossings:
    """The faces that cross another without sharing a corner with it (Möller 1997), by the tree over its faces, if there is one already.

    Faces that share a corner touch by nature; where they fold onto each other, `print_quality.turned_over` tells.
    """
    tree, count = tree or TriangleTree(mesh.vertices, mesh.faces), len(mesh.faces)
    device = tree.device
    centre = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
    points: Any = wp.array(mesh.vertices - centre, dtype=wp.vec3d, device=device)
    faces: Any = wp.array(mesh.faces.ravel(), dtype=wp.int32, device=device)
    crossed: Any = wp.empty(count, dtype=wp.int32, device=device)
    other: Any = wp.full(count, -1, dtype=wp.int32, device=device)
    wp.launch(count_crossings, dim=count, inputs=[tree.id, faces, points, crossed, other], device=device)
    return Crossings(int(crossed.numpy().sum()), other.numpy())


def overlaps(mesh: SurfaceMesh) -> Floats:
    """Middles of the places where a closed body reaches into itself [mm], the largest first, shape [place_count, 3].

    Around the line in which two faces cross, the winding number is w behind both, w - 1 behind one of them and w - 2 before both. A simple
    body has 0 and 1 only; 2 is inside twice, and -1 is inside out. Either must hold `TOL.deep` away from both faces.
    """
    other = crossings(mesh).other
    one = np.flatnonzero(other >= 0)
    if not len(one):
        return np.zeros((0, 3))
    one = one[:: -(-len(one) // TOL.crossings_asked)]
    depth = _depth(mesh, one, other[one])
    steep = np.isfinite(depth).all(axis=1)
    one, depth = one[steep], depth[steep]
    lines = _lines(mesh, one, other[one])
    tree = TriangleTree(mesh.vertices, mesh.faces, winding=True)
    twice = _turns_exceed(tree, lines - depth, 1.5)
    inside_out = ~_turns_exceed(tree, lines + depth, -0.5)
    return _middles(lines[twice | inside_out], TOL.one_place * mesh.size)


def _depth(mesh: SurfaceMesh, one: NDArray[np.int64], other: Indices) -> Floats:
    """Offset from an intersection line to the point `TOL.deep` below both faces [mm], shape [k, 3]; NaN where they only graze."""
    normals = mesh.face_vectors / np.maximum(np.linalg.norm(mesh.face_vectors, axis=1, keepdims=True), 1e-30)
    both = normals[one] + normals[other]
    along = 0.5 * np.square(both).sum(axis=1, keepdims=True)  # n · (n + m) = |n + m|² / 2
    return np.asarray(TOL.deep * both / np.where(along > TOL.grazing, along, np.nan))


def _lines(mesh: SurfaceMesh, one: NDArray[np.int64], other: Indices) -> Floats:
    """Middle of the line in which each two faces cross [mm], shape [k, 3]: between the points where an edge of one passes the other."""
    total, count = np.zeros((len(one), 3)), np.zeros(len(one))
    for edges, plane in ((one, other), (other, one)):
        corners, normal = mesh.corners[edges], mesh.face_vectors[plane]
        height = np.einsum("ijk,ik->ij", corners - mesh.corners[plane][:, :1], normal)
        for k in range(3):
            start, end, low, high = corners[:, k], corners[:, k - 1], height[:, k], height[:, k - 1]
            passes = low * high < 0.0
            share = np.where(passes, low / np.where(passes, low - high, 1.0), 0.0)
            point = start + share[:, None] * (end - start)
            within = passes & _within(point, mesh.corners[plane], normal)
            total += np.where(within[:, None], point, 0.0)
            count += within
    return np.where(count[:, None] > 0, total / np.maximum(count, 1.0)[:, None], mesh.corners[one].mean(axis=1))


def _within(points: Floats, corners: Floats, normals: Floats) -> NDArray[np.bool_]:
    """Whether points in the planes of triangles lie in them, shape [k]."""
    sides = np.roll(corners, -1, axis=1) - corners
    left = np.einsum("ijk,ik->ij", np.cross(sides, points[:, None] - corners), normals)
    return np.asarray((left >= 0.0).all(axis=1))


def _turns_exceed(tree: TriangleTree, points: Floats, threshold: float) -> NDArray[np.bool_]:
    """Whether the surface winds around each point more often than a threshold, shape [k]."""
    exceeds: Any = wp.empty(len(points), dtype=wp.bool, device=tree.device)
    wp.launch(turns_exceed, dim=len(points), inputs=[tree.id, tree.points(points), threshold, exceeds], device=tree.device)
    return np.asarray(exceeds.numpy())


def _middles(points: Floats, apart: float) -> Floats:
    """Means of the groups of points that hang together by steps of less than `apart`, the largest group first, shape [group_count, 3]."""
    if not len(points):
        return points
    pairs = cKDTree(points).query_pairs(apart, output_type="ndarray")
    graph = sp.coo_array((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    group = connected_components(graph, directed=False)[1]
    sizes = np.bincount(group)
    sums = np.stack([np.bincount(group, column) for column in points.T], axis=1)
    return np.asarray((sums / sizes[:, None])[np.argsort(-sizes, kind="stable")])
