"""Triangles that a remesher left folded over, as slivers or across a round, mended by taking vertices out and turning edges."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechstyle.geometry.going_on import GoOn, regardless
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.self_intersections import crossings
from mechstyle.records.mesh import Bools, Floats, Indices, SurfaceMesh

PASSES = 3
TURNINGS = 12  # rounds of turning edges in a pass
ASTRAY = 0.5  # cosine of the angle to the part's normal, below which a triangle is folded over
SLIVER = 0.15  # quality 4 √3 A / Σ l², 1 for an equilateral triangle, below which a triangle is a sliver
LEAST_GAIN = 1e-3  # of what turning an edge should raise
OFF = 0.04  # of its length, by which the middle of an edge that lies across a round misses the part
NEARER = 2.0  # weight of that share beside normals and shape: as notches are seen from far, and slivers are not
UNDOINGS = 6  # rounds of leaving edges as they are where turning them made walls cross
STRAIGHT = 0.9  # the same cosine as ASTRAY, above which a triangle lies as well as it can


class EdgePairs(NamedTuple):
    """The edges of a closed surface with their two faces.

    Attributes:
        edges: Vertices of each, directed as in its first face, shape [k, 2].
        faces: Its two faces, shape [k, 2].
        across: The third vertex of each of them, shape [k, 2].
    """

    edges: Indices
    faces: NDArray[np.int64]
    across: Indices

    def some(self, which: NDArray[np.bool_]) -> EdgePairs:
        """Subset of the edges selected by `which`, shape [k]."""
        return EdgePairs(self.edges[which], self.faces[which], self.across[which])


def edge_pairs(faces: Indices) -> EdgePairs:
    """The edges of a closed surface, each once."""
    directed = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    start, end = directed.T
    key = np.maximum(start, end) * (np.int64(faces.max()) + 1) + np.minimum(start, end)
    order = np.argsort(key, kind="stable")  # each edge is there twice, now side by side
    across = faces[:, [2, 0, 1]].reshape(-1)[order]
    return EdgePairs(directed[order][::2], (order // 3).reshape(-1, 2), across.reshape(-1, 2))


def edge_keys(pairs: Indices, count: int) -> NDArray[np.int64]:
    """A number for each unordered pair of so many vertices, in the order in which `edge_pairs` lists edges."""
    one, other = pairs.T
    return np.maximum(one, other).astype(np.int64) * count + np.minimum(one, other)


def among(wanted: NDArray[np.int64], there: NDArray[np.int64]) -> Bools:
    """Whether keys are among others, which ascend."""
    return there[np.minimum(np.searchsorted(there, wanted), len(there) - 1)] == wanted


class _Fit(NamedTuple):
    """Fit of triangles to the part: cosine between their normals, and their quality, shape [face_count] each."""

    cosine: Floats
    quality: Floats

    @property
    def bad(self) -> NDArray[np.bool_]:
        return (self.cosine < ASTRAY) | (self.quality < SLIVER)

    @property
    def worth(self) -> Floats:
        """Objective of an edge flip: first the normals, then the shape."""
        return np.minimum(self.cosine, STRAIGHT) + 0.5 * self.quality

    def updated(self, changed: NDArray[np.int64], fit: _Fit) -> _Fit:
        """The same with some triangles replaced."""
        cosine, quality = self.cosine.copy(), self.quality.copy()
        cosine[changed], quality[changed] = fit
        return _Fit(cosine, quality)


def mended(mesh: SurfaceMesh, part: TriangleTree, creases: int, go_on: GoOn = regardless) -> SurfaceMesh:
    """The mesh without the flaps, slivers and notches that can be mended without moving a vertex.

    A vertex of three triangles, one of them bad, is taken out; an edge of a bad triangle is turned if that makes the worse of its
    two triangles better, and one across a round, the middle of which misses the part, if it then misses less. What is good stays as it is.

    Args:
        mesh: A closed surface near the part.
        part: What its triangles should lie on.
        creases: The first so many vertices are on creases of the part; they and the edges between them stay.
        go_on: Asked before every round of turning edges.
    """
    for _ in range(PASSES):
        before, mesh = mesh, _turned(_pruned(mesh, part, creases), part, creases, go_on)
        if mesh is before:
            break
    return _without_notches(mesh, part, creases, go_on)


def _without_notches(mesh: SurfaceMesh, part: TriangleTree, creases: int, go_on: GoOn) -> SurfaceMesh:
    """The mesh with edges turned that lie across rounds, except near where that would make walls cross each other."""
    loose, most = np.ones(len(mesh.vertices), bool), -1
    for _ in range(UNDOINGS):
        found = _turned(mesh, part, creases, go_on, loose)
        if found is mesh:
            break
        go_on()
        crossed, most = crossings(found), crossings(mesh).pairs if most < 0 else most
        if crossed.pairs <= most:
            return found
        loose[found.faces[crossed.other >= 0]] = False
    return mesh


def _fit(vertices: Floats, faces: Indices, part: TriangleTree) -> _Fit:
    corners = vertices[faces]
    normals, double = _normals(corners)
    wanted, _ = _normals(part.vertices[part.faces[part.nearest(corners.mean(axis=1)).face]])
    squares = np.square(corners - np.roll(corners, 1, axis=1)).sum(axis=(1, 2))
    return _Fit(np.einsum("ij,ij->i", normals, wanted), 2.0 * np.sqrt(3.0) * double / np.maximum(squares, 1e-24))


def _normals(corners: Floats) -> tuple[Floats, Floats]:
    """Unit normals of triangles, zero for those without area, and twice their areas."""
    vectors = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(vectors, axis=1)
    return vectors / np.maximum(double, 1e-12)[:, None], double


def _pruned(mesh: SurfaceMesh, part: TriangleTree, creases: int) -> SurfaceMesh:
    """Remove vertices of valence 3 that touch a bad triangle, at most one per triangle."""
    faces, count = mesh.faces, np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices))
    suspects = np.unique(faces[_fit(mesh.vertices, faces, part).bad])
    dropped, caps, touched = np.zeros(len(faces), bool), list[tuple[int, int, int]](), set[int]()
    for vertex in suspects[(count[suspects] == 3) & (suspects >= creases)]:
        around = np.flatnonzero((faces == vertex).any(axis=1))
        after = {int(b): int(c) for a, b, c in (np.roll(face, -int(np.argmax(face == vertex))) for face in faces[around])}
        if touched.isdisjoint({*after, int(vertex)}):
            touched |= {*after, int(vertex)}
            dropped[around] = True
            first = min(after)
            caps.append((first, after[first], after[after[first]]))
    if not caps:
        return mesh
    used, index = np.unique(np.vstack([faces[~dropped], np.array(caps, faces.dtype)]), return_inverse=True)
    return SurfaceMesh(mesh.vertices[used], index.reshape(-1, 3).astype(np.int32))


def _turned(mesh: SurfaceMesh, part: TriangleTree, creases: int, go_on: GoOn, loose: Bools | None = None) -> SurfaceMesh:
    """The mesh with edges of bad triangles turned while that helps, in each round the most helpful first.

    Those across rounds, too, where all four vertices around are `loose`, shape [vertex_count]; None for nowhere.
    """
    vertices, faces = mesh.vertices, mesh.faces.copy()
    fit = _fit(vertices, faces, part)
    for _ in range(TURNINGS):
        go_on()
        pairs = edge_pairs(faces)
        there = edge_keys(pairs.edges, len(vertices))  # ascending
        off = np.zeros(len(pairs.edges)) if loose is None else _off(vertices, pairs.edges, part)
        if loose is not None:
            off[~(loose[pairs.edges].all(axis=1) & loose[pairs.across].all(axis=1))] = 0.0
        suspect = (fit.bad[pairs.faces].any(axis=1) | (off > OFF)) & (pairs.edges >= creases).any(axis=1)
        suspect[suspect] = ~among(edge_keys(pairs.across[suspect], len(vertices)), there)  # else there would be two such edges
        pairs, off = pairs.some(suspect), off[suspect]
        (a, b), (c, d) = pairs.edges.T, pairs.across.T
        halves = np.stack([np.stack([a, d, c], axis=1), np.stack([d, b, c], axis=1)], axis=1)
        new = _fit(vertices, halves.reshape(-1, 3), part).worth.reshape(-1, 2).min(axis=1)
        gain = new - fit.worth[pairs.faces].min(axis=1)
        across = off > OFF
        gain[across] += NEARER * (off[across] - _off(vertices, pairs.across[across], part))
        chosen = _apart(pairs, gain)
        if not len(chosen):
            break
        changed = pairs.faces[chosen].ravel()
        faces[changed] = halves[chosen].reshape(-1, 3)
        fit = fit.updated(changed, _fit(vertices, faces[changed], part))
    return mesh if np.array_equal(faces, mesh.faces) else SurfaceMesh(vertices, faces)


def _off(vertices: Floats, edges: Indices, part: TriangleTree) -> Floats:
    """How far the middles of edges lie from the part, over their lengths, shape [k]."""
    one, other = vertices[edges].transpose(1, 0, 2)
    length = np.linalg.norm(other - one, axis=1)
    return np.asarray(part.nearest(0.5 * (one + other)).distance / np.maximum(length, 1e-12))


def _apart(pairs: EdgePairs, gain: Floats) -> NDArray[np.int64]:
    """Indices of the edges to turn, the most helpful first, no two of which share a face or would become the same edge."""
    busy, made, chosen = set[int](), set[tuple[int, ...]](), list[int]()
    for index in np.argsort(-gain, kind="stable")[: np.count_nonzero(gain > LEAST_GAIN)]:
        around, edge = set(pairs.faces[index].tolist()), tuple(sorted(pairs.across[index].tolist()))
        if busy.isdisjoint(around) and edge not in made:
            busy |= around
            made.add(edge)
            chosen.append(int(index))
    return np.array(chosen, np.int64)
