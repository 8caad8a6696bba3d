"""Even triangles of one size on a closed surface: splits, collapses, flips and smoothing in turn (Botsch and Kobbelt 2004).

M. Botsch, L. Kobbelt, "A remeshing approach to multiresolution modeling", Eurographics Symposium on Geometry Processing 2004. Where the
paper takes one edge after the other, here every round takes all edges at once that do not touch each other, the most urgent first.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.tolerances import TOL
from mechstyle.geometry.remeshing.topology import (
    EdgePairs,
    among,
    edge_keys,
    edge_pairs,
    edges_of,
    far_apart,
    least,
    merged,
    ranks,
    valid_collapses,
)
from mechstyle.records.mesh import Bools, Floats, Indices, SurfaceMesh

REGULAR = 6  # neighbours of a vertex among equilateral triangles


class _State(NamedTuple):
    """A closed surface being remeshed."""

    vertices: Floats  # positions [mm], shape [n, 3]
    faces: Indices  # vertex indices, shape [m, 3]
    creases: int  # the first so many vertices are on creases: they stay, and others may collapse into them
    fixed: int  # so many, those on creases among them, stay


def isotropic(
    mesh: SurfaceMesh, edge: float, part: TriangleTree, *, creases: Indices, rounds: Indices, iterations: int,
    go_on: CancelCheck = never_cancel,
) -> SurfaceMesh:  # fmt: skip
    """The surface in nearly equilateral triangles.

    Args:
        mesh: A closed surface on the part or near it.
        edge: Edge length wished for [mm].
        part: What the vertices are put down on.
        creases: Vertices that stay where they are, and come first in the result, in this order.
        rounds: Vertices that stay as well and come next; what is around them stays as close as it is, to be as round as they are.
            Edges between vertices that stay do so, too, where the surface bends.
        iterations: Rounds of splits, collapses, flips and smoothing.
        go_on: Asked before every round of one of them.

    Returns:
        A closed surface with the same shells and handles; the same input gives the same bytes.
    """
    fixed = np.concatenate([creases, rounds])
    order = np.concatenate([fixed, np.setdiff1d(np.arange(len(mesh.vertices)), fixed)])
    rank = np.empty(len(order), np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    state = _State(mesh.vertices[order], rank[mesh.faces], len(creases), len(fixed))
    for _ in range(iterations):
        state = _split(state, TOL.long * edge, go_on)
        state = _collapsed(state, TOL.short * edge, TOL.long * edge, go_on)
        state = _flipped(state, go_on)
        go_on()
        state = _smoothed(state, part)
    return SurfaceMesh(state.vertices, state.faces)


def _split(state: _State, longest: float, go_on: CancelCheck) -> _State:
    """Long edges cut in their middle, in each round those that are the longest of both their triangles."""
    vertices, faces, _, fixed = state
    for _ in range(TOL.splits):
        go_on()
        pairs = edge_pairs(faces)
        length = _norms(vertices[pairs.edges[:, 1]] - vertices[pairs.edges[:, 0]])
        wanted = (length > longest) & ~_held(vertices, faces, pairs, fixed)
        pairs, length = pairs.some(wanted), length[wanted]
        pairs = pairs.some(_foremost(pairs.faces, -length, len(faces)))
        if not len(pairs.edges):
            break
        (a, b), (c, d) = pairs.edges.T, pairs.across.T
        middle = np.arange(len(vertices), len(vertices) + len(a), dtype=np.int32)
        vertices = np.concatenate([vertices, vertices[pairs.edges].mean(axis=1)])
        faces = faces.copy()
        faces[pairs.faces[:, 0]], faces[pairs.faces[:, 1]] = np.stack([a, middle, c], 1), np.stack([b, middle, d], 1)
        faces = np.concatenate([faces, np.stack([middle, b, c], 1), np.stack([middle, a, d], 1)])
        if len(middle) < TOL.few * len(vertices):
            break
    return state._replace(vertices=vertices, faces=faces)


def _collapsed(state: _State, shortest: float, longest: float, go_on: CancelCheck) -> _State:
    """Short edges drawn together to one vertex, the shortest first, where that makes no edge too long and turns no triangle over."""
    vertices, faces, creases, fixed = state
    for _ in range(TOL.collapses):
        go_on()
        edges = edges_of(faces)
        length = _norms(vertices[edges[:, 1]] - vertices[edges[:, 0]])
        wanted = (length < shortest) & ((edges[:, 0] >= fixed) | (edges[:, 0] < creases) & (edges[:, 1] >= fixed))
        edges, length = edges[wanted], length[wanted]
        meeting = np.where((edges[:, 0] < fixed)[:, None], vertices[edges[:, 0]], 0.5 * (vertices[edges[:, 0]] + vertices[edges[:, 1]]))
        sound = valid_collapses(vertices, faces, edges, meeting, longest=longest, cosine=TOL.turn_in_collapse)
        edges, length, meeting = edges[sound], length[sound], meeting[sound]
        chosen = far_apart(edges, np.floor(length * (TOL.length_classes / shortest)), faces, len(vertices))
        if not chosen.any():
            break
        (stays, goes), vertices = edges[chosen].T, vertices.copy()
        vertices[stays] = meeting[chosen]
        vertices, faces = merged(vertices, faces, stays, goes)
        if np.count_nonzero(chosen) < TOL.few * len(vertices):
            break
    return state._replace(vertices=vertices, faces=faces)


def _flipped(state: _State, go_on: CancelCheck) -> _State:
    """Edges turned where that brings the numbers of neighbours nearer to six and folds nothing."""
    vertices, faces, _, fixed = state
    for _ in range(TOL.flips):
        go_on()
        pairs = edge_pairs(faces)
        there = edge_keys(pairs.edges, len(vertices))  # ascending
        valence = np.bincount(faces.ravel(), minlength=len(vertices))
        losing = np.abs(valence - REGULAR) - np.abs(valence - 1 - REGULAR)  # nearer to the regular one without an edge …
        gaining = np.abs(valence - REGULAR) - np.abs(valence + 1 - REGULAR)  # … and with one more
        gain = losing[pairs.edges].sum(axis=1) + gaining[pairs.across].sum(axis=1)
        pairs, gain = pairs.some(gain > 0), gain[gain > 0]
        new = ~among(edge_keys(pairs.across, len(vertices)), there)
        # Turning leaves triangles of some quality 4 √3 A / Σ l² that look where the old ones did.
        halves = [*(faces[side] for side in pairs.faces.T), *_halves(pairs)]
        normals = [_crosses(vertices, half) for half in halves]
        squares = [np.square(vertices[half] - np.roll(vertices[half], 1, axis=1)).sum(axis=(1, 2)) for half in halves]
        good = [2.0 * np.sqrt(3.0) * _norms(n) / np.maximum(square, 1e-24) for n, square in zip(normals, squares, strict=True)]
        well = np.minimum(*good[2:]) >= np.minimum(TOL.flipped_quality, np.minimum(*good[:2]))
        well &= np.logical_and.reduce([_steady(was, becomes) for was in normals[:2] for becomes in normals[2:]])
        wanted = new & ~_held(vertices, faces, pairs, fixed) & well
        pairs, gain = pairs.some(wanted), gain[wanted]
        pairs = pairs.some(_foremost(np.column_stack([pairs.edges, pairs.across]), -gain, len(vertices)))
        if not len(pairs.edges):
            break
        faces = faces.copy()
        faces[pairs.faces[:, 0]], faces[pairs.faces[:, 1]] = _halves(pairs)
        if len(pairs.edges) < TOL.few * len(vertices):
            break
    return state._replace(vertices=vertices, faces=faces)


def _smoothed(state: _State, part: TriangleTree) -> _State:
    """Free vertices moved towards the middle of their neighbours, along the surface, and put down on the part.

    Those of triangles that turn over by that go back where they were.
    """
    vertices, faces, _, fixed = state
    was = _crosses(vertices, faces)
    normals = np.column_stack([sum(np.bincount(faces[:, k], column, len(vertices)) for k in range(3)) for column in was.T])
    normals /= np.maximum(_norms(normals), 1e-30)[:, None]
    step = _neighbour_means(vertices, faces) - vertices
    step -= _dots(step, normals)[:, None] * normals
    there = part.nearest(vertices[fixed:] + step[fixed:])
    wanted = vertices.copy()
    looks = _crosses(part.vertices, part.faces[there.face])
    facing = _dots(looks, normals[fixed:]) > TOL.facing * _norms(looks)
    wanted[fixed:][facing] = there.point[facing]
    for _ in range(TOL.put_back):
        turned = ~_steady(was, _crosses(wanted, faces))
        if not turned.any():
            break
        spoilt = faces[turned].ravel()
        wanted[spoilt] = vertices[spoilt]
    return state._replace(vertices=wanted)


def _norms(vectors: Floats) -> Floats:
    return np.sqrt(_dots(vectors, vectors))


def _dots(one: Floats, other: Floats) -> Floats:
    return np.einsum("ij,ij->i", one, other)


def _crosses(vertices: Floats, faces: Indices) -> Floats:
    """Normals of triangles as long as twice their areas, shape [k, 3]."""
    a, b, c = (vertices[corner] for corner in faces.T)
    (x, y, z), (u, v, w) = (b - a).T, (c - a).T
    return np.column_stack([y * w - z * v, z * u - x * w, x * v - y * u])


def _steady(was: Floats, becomes: Floats) -> Bools:
    """Whether normals turn by less than triangles may."""
    return _dots(was, becomes) >= TOL.turn * _norms(was) * _norms(becomes)


def _neighbour_means(vertices: Floats, faces: Indices) -> Floats:
    """The mean of each vertex' neighbours: every one of them follows it in exactly one face."""
    total = np.column_stack(
        [sum(np.bincount(faces[:, k], column[faces[:, (k + 1) % 3]], len(vertices)) for k in range(3)) for column in vertices.T]
    )
    return total / np.bincount(faces.ravel(), minlength=len(vertices))[:, None]


def _held(vertices: Floats, faces: Indices, pairs: EdgePairs, fixed: int) -> Bools:
    """Whether an edge is one between fixed vertices at which the surface bends."""
    held: Bools = np.asarray((pairs.edges < fixed).all(axis=1))
    one, other = (_crosses(vertices, faces[pairs.faces[held, side]]) for side in (0, 1))
    held[held] = _dots(one, other) < TOL.bent * _norms(one) * _norms(other)
    return held


def _foremost(needs: NDArray[np.integer], urgency: NDArray[Any], count: int) -> Bools:
    """Which of some changes, urgent ones of low value, come before all others that need one of the same `count` things, shape [k, r]."""
    order = ranks(urgency)
    first = least(needs, np.repeat(order, needs.shape[1]), count, len(order))
    return (first[needs] == order[:, None]).all(axis=1)


def _halves(pairs: EdgePairs) -> tuple[Indices, Indices]:
    """The two faces that take the place of an edge's two when it is turned."""
    (a, b), (c, d) = pairs.edges.T, pairs.across.T
    return np.stack([a, d, c], axis=1), np.stack([d, b, c], axis=1)
