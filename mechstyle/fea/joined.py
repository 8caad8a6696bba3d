"""Which points of a ball are joined to its centre by the body within the ball, and which lie across a gap.

A slot between two walls may be narrower than the ball; what is beyond it bears nothing of what is here. Tetrahedra in the ball are joined
where they share vertices: shared faces would miss the corner of one that lies between two points and has no point in the ball itself.
Around the tip of a notch both sides are joined as far as the tip, or a vertex beside it, is within the ball.

Where tetrahedra are smaller than a grain they are taken together, as far as they are joined in it, and so are balls whose centres are, or
a small part of many would ask for millions of balls with thousands of tetrahedra in each.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from mechstyle.fea.sides import SPACING, surface_points
from mechstyle.records.mesh import Bools, Floats, SurfaceMesh, TetMesh

Numbers = NDArray[np.integer[Any]]

GRAIN = 0.2
"""Edge of a grain over the radius of the balls."""

SAMPLE = 0.7
"""Edge of the cubes in which one point stands for surface that looks the same way, to the octant [mm]."""

ROUNDING = 1e-6
"""How far above the plane of a face a point is said to be [mm]."""

AT_ONCE = 1_000_000
"""Grains in balls that are looked into together; bounds the memory."""


class Grains(NamedTuple):
    """A body in grains.

    Attributes:
        of_points: Grain of each point, as ones of shape [point_count, grain_count].
        vertices: Which vertices each grain has, ones of shape [grain_count, vertex_count].
        centres: Which points have one ball together, ones of shape [point_count, ball_count].
        own: Grain of each such ball's centre, shape [ball_count].
    """

    of_points: csr_array
    vertices: csr_array
    centres: csr_array
    own: Numbers


def joined(near: csr_array, tets: TetMesh, points: Floats, radius: float) -> csr_array:
    """What is near each point, without what lies across a gap.

    Only balls that reach surface facing other surface across a gap are looked into: a convex body costs little, and loses nothing.

    Args:
        near: Which points are within the radius of which, themselves included, ones of shape [point_count, point_count].
        tets: The body.
        points: Points of each tetrahedron [mm], shape [tet_count, sub_points, 3].
        radius: Of the balls [mm].

    Returns:
        Ones of the shape of `near`; `near` itself where no gap is in any ball.
    """
    grains = _grains(tets, points, GRAIN * radius)
    balls = (grains.centres.T @ near @ grains.of_points).tocsr()
    touching = (grains.vertices @ grains.vertices.T).tocsr()[grains.own]
    apart = np.flatnonzero(np.diff(balls.indptr) > np.diff(balls.multiply(touching).tocsr().indptr))
    places = (grains.centres.T @ points.reshape(-1, 3))[apart] / grains.centres.sum(axis=0)[apart, None]
    asked = apart[_beside(places, _facing(tets, places, radius), radius)]
    lost = [_across(balls[some].tocoo(), some, grains) for some in _in_portions(asked, np.diff(balls.indptr))]
    ball, grain = np.concatenate([np.empty((2, 0), np.int64), *lost], axis=1)
    if not len(ball):
        return near
    gaps = coo_array((np.ones(len(ball), np.float32), (ball, grain)), shape=balls.shape).tocsr()
    kept = near - near.multiply(grains.centres @ gaps @ grains.of_points.T)
    kept.eliminate_zeros()
    return kept.tocsr()


def _grains(tets: TetMesh, points: Floats, edge: float) -> Grains:
    count, sub_points = points.shape[:2]
    cell = _cells(points.mean(axis=1), edge)
    shared = cell[:, None] * len(tets.vertices) + tets.tets  # a vertex joins what is in one cell
    _, corner = np.unique(shared, return_inverse=True)
    rows = np.repeat(np.arange(count), 4)
    links = coo_array((np.ones(len(rows), np.int8), (rows, count + corner.ravel())), shape=(count + int(corner.max()) + 1,) * 2)
    _, label = connected_components(links, directed=False)
    _, grain = np.unique(label[:count], return_inverse=True)
    vertices = coo_array((np.ones(len(rows), np.int32), (grain[rows], tets.tets.ravel())), shape=(int(grain.max()) + 1, len(tets.vertices)))
    of_point = np.repeat(grain, sub_points)
    _, first, ball = np.unique(
        _cells(points.reshape(-1, 3), edge) * len(label) + of_point, return_index=True, return_inverse=True
    )
    return Grains(_ones(of_point), vertices.tocsr(), _ones(ball), of_point[first])


def _cells(points: Floats, edge: float) -> Numbers:
    """Number of the cube of an edge [mm] each point is in, shape [point_count]."""
    if not len(points):
        return np.empty(0, np.int64)
    cubes = np.floor((points - points.min(axis=0)) / edge).astype(np.int64)
    sizes = cubes.max(axis=0) + 1
    return np.asarray((cubes[:, 0] * sizes[1] + cubes[:, 1]) * sizes[2] + cubes[:, 2])


def _ones(columns: Numbers) -> csr_array:
    """One in each row, at a column."""
    return coo_array((np.ones(len(columns), np.float32), (np.arange(len(columns)), columns))).tocsr()


def _in_portions(balls: Numbers, sizes: Numbers) -> list[Numbers]:
    """Balls in portions of about AT_ONCE grains each."""
    portion = np.cumsum(sizes[balls]) // AT_ONCE
    return np.split(balls, np.flatnonzero(np.diff(portion)) + 1) if len(balls) else []


def _beside(points: Floats, others: Floats, reach: float) -> Bools:
    """Which points lie within a reach of others [mm], or but for the distance of those that stand for the surface."""
    if not len(others):
        return np.zeros(len(points), dtype=bool)
    away, _ = cKDTree(others).query(points, distance_upper_bound=reach + SPACING)
    return np.isfinite(away)


def _facing(tets: TetMesh, centres: Floats, reach: float) -> Floats:
    """Points of the boundary from which a straight way out of the body comes back to it within a reach [mm], shape [n, 3].

    Surfaces that open by 90° or more are left out: what is near the one is nearer to where they meet than to the other.

    Args:
        tets: The body.
        centres: Of the balls [mm], shape [n, 3]; surface farther away than the reach does not matter.
        reach: Radius of the balls [mm].
    """
    boundary = SurfaceMesh(tets.vertices, tets.boundary_faces)
    interpolation, face = surface_points(tets, boundary.faces)
    points = interpolation @ tets.vertices
    near = np.flatnonzero(_beside(points, centres, reach))
    looks = (boundary.face_normals[face[near]] > 0.0) @ [1, 2, 4]
    _, some = np.unique(8 * _cells(points[near], SAMPLE) + looks, return_index=True)  # one of those side by side will do
    points, normals = points[near[some]], boundary.face_normals[face[near[some]]]
    one, other = cKDTree(points).query_pairs(reach + SPACING, output_type="ndarray").T
    opposed = np.einsum("nx,nx->n", normals[one], normals[other]) < 0.0
    one, other = one[opposed], other[opposed]
    way = points[other] - points[one]
    out, back = np.einsum("nx,nx->n", way, normals[one]), -np.einsum("nx,nx->n", way, normals[other])
    across = (out > ROUNDING) & (back > ROUNDING)
    return np.asarray(points[np.unique(np.concatenate([one[across], other[across]]))])


def _across(balls: coo_array, numbers: Numbers, grains: Grains) -> Numbers:
    """Pairs of a ball, by its number, and a grain in it that is not joined to the centre by grains in the ball, shape [2, n]."""
    count, (ball, grain) = len(balls.data), balls.coords
    corners = grains.vertices[grain].tocoo()
    _, corner = np.unique(ball[corners.coords[0]].astype(np.int64) * corners.shape[1] + corners.coords[1], return_inverse=True)
    links = coo_array((np.ones(len(corner), np.int8), (corners.coords[0], count + corner)), shape=(count + int(corner.max()) + 1,) * 2)
    _, label = connected_components(links, directed=False)
    home = np.empty(len(numbers), label.dtype)
    central = grain == grains.own[numbers][ball]
    home[ball[central]] = label[:count][central]
    gone = label[:count] != home[ball]
    return np.stack([numbers[ball[gone]], grain[gone]]).astype(np.int64)
