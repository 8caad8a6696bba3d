"""Triangles that a remesher left without area, folded over, as slivers or across a round: taken out, or their edges turned."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechstyle.geometry.bodies import without_unused
from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.crossings import crossings
from mechstyle.geometry.remeshing.tolerances import TOL
from mechstyle.geometry.remeshing.topology import EdgePairs, among, edge_keys, edge_pairs
from mechstyle.records.mesh import Bools, Floats, Indices, SurfaceMesh

Face = tuple[int, int, int]

# --- triangles without area, one after the other


def heights(corners: Floats) -> Floats:
    """Height of triangles over their longest side, zero for those without area [mm], from corners of shape [face_count, 3, 3]."""
    double = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    return np.divide(double, longest, out=np.zeros_like(double), where=longest > 0)


def without_degenerate(mesh: SurfaceMesh, least: float, go_on: CancelCheck = never_cancel) -> SurfaceMesh:
    """The mesh without triangles lower than a height [mm], as far as that keeps its shells and handles.

    Where two corners of such a triangle are as near as that, they become one, the first of them; else its longest side is turned
    towards the vertex across, which moves the surface by less than the height. Where neither is possible, as between two rows of
    vertices on one line, the nearest two corners become one if no sound triangle turns by that. Sound triangles keep their side.
    """
    if not (heights(mesh.corners) < least).any():
        return mesh
    go_on()
    triangles = _Triangles(mesh)
    for _ in range(TOL.degenerate_passes):
        go_on()
        there = [number for number, face in enumerate(triangles.faces) if face is not None]
        flat = [number for number, height in zip(there, triangles.heights(there), strict=True) if height < least]
        if not sum(triangles.mend(number, least) for number in flat if triangles.faces[number] is not None):
            break
    return triangles.mesh()


class _Side(NamedTuple):
    start: int
    end: int
    apex: int  # the corner across


class _Triangles:
    """A closed surface whose triangles can be changed one by one."""

    def __init__(self, mesh: SurfaceMesh) -> None:
        self.vertices = mesh.vertices
        self.faces: list[Face | None] = list(zip(*mesh.faces.T.tolist(), strict=True))
        around = (np.argsort(mesh.faces.ravel(), kind="stable") // 3).tolist()  # vertex by vertex
        ends = np.cumsum(np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices))).tolist()
        self.around: list[set[int]] = [set(around[start:end]) for start, end in pairwise([0, *ends])]

    def heights(self, numbers: list[int]) -> list[float]:
        return [float(height) for height in heights(self.vertices[np.array([self.faces[number] for number in numbers])])]

    def mesh(self) -> SurfaceMesh:
        return without_unused(self.vertices, np.array([face for face in self.faces if face is not None]))

    def mend(self, number: int, least: float) -> bool:
        """Take one low triangle out; whether that was possible. It may have been mended with another one before."""
        face = self._corners(number)
        if self.heights([number])[0] >= least:
            return False
        sides = sorted((_Side(*np.roll(face, -k).tolist()) for k in range(3)), key=self._length)
        first, second = sorted(sides[0][:2])  # the first vertices of a standardised surface are on creases
        if self._length(sides[0]) < least:

            def allowed(one: int, becomes: Face) -> bool:
                return self.heights([one])[0] < least or self._turn(one, becomes) > TOL.turn_by_low_ones

            return self._merged(first, second, allowed)

        def still(one: int, becomes: Face) -> bool:
            low_before, low_after = heights(self.vertices[np.array([self._corners(one), becomes])]) < least
            return bool(low_after) if low_before else self._turn(one, becomes) > TOL.turn_by_others

        return self._turned(number, sides[-1]) or self._merged(first, second, still) or self._merged(second, first, still)

    def _merged(self, stays: int, goes: int, allowed: Callable[[int, Face], bool]) -> bool:
        """Make two neighbours one, if every triangle that gets another corner by that is allowed to."""
        if len(self._neighbours(stays) & self._neighbours(goes)) != 2:
            return False  # a handle or a shell would be pinched off
        changed: dict[int, Face] = {}
        for number in self.around[goes] - self.around[stays]:
            a, b, c = (stays if vertex == goes else vertex for vertex in self._corners(number))
            changed[number] = a, b, c
        if not all(allowed(number, face) for number, face in changed.items()):
            return False
        for number in list(self.around[goes]):
            self._replace(number, changed.get(number))
        return True

    def _turned(self, number: int, side: _Side) -> bool:
        """Turn a side towards the vertex across, if the lower of the two triangles becomes higher and none is turned over."""
        (other,) = (self.around[side.start] & self.around[side.end]) - {number}
        across = next(vertex for vertex in self._corners(other) if vertex not in side[:2])
        if across in self._neighbours(side.apex):
            return False
        new: list[Face] = [(side.apex, side.start, across), (side.apex, across, side.end)]
        was, becomes = self._vectors([self._corners(number), self._corners(other)]), self._vectors(new)
        if (becomes @ was.sum(axis=0) <= 0).any() or heights(self.vertices[np.array(new)]).min() <= min(self.heights([number, other])):
            return False
        self._replace(number, new[0])
        self._replace(other, new[1])
        return True

    def _turn(self, number: int, becomes: Face) -> float:
        """Cosine of the angle by which a triangle turns that gets another corner."""
        was, new = self._vectors([self._corners(number), becomes])
        return float(was @ new) / max(float(np.linalg.norm(was) * np.linalg.norm(new)), 1e-300)

    def _vectors(self, faces: list[Face]) -> Floats:
        a, b, c = self.vertices[np.array(faces)].transpose(1, 0, 2)
        return np.cross(b - a, c - a)

    def _length(self, side: _Side) -> float:
        return float(np.linalg.norm(self.vertices[side.end] - self.vertices[side.start]))

    def _corners(self, number: int) -> Face:
        face = self.faces[number]
        assert face is not None
        return face

    def _neighbours(self, vertex: int) -> set[int]:
        return {other for number in self.around[vertex] for other in self._corners(number)} - {vertex}

    def _replace(self, number: int, face: Face | None) -> None:
        for vertex in self._corners(number):
            self.around[vertex].discard(number)
        self.faces[number] = face
        for vertex in face or ():
            self.around[vertex].add(number)


# --- flaps, slivers and notches, many at once


class _Fit(NamedTuple):
    """Fit of triangles to the part: cosine between their normals, and their quality, shape [face_count] each."""

    cosine: Floats
    quality: Floats

    @property
    def bad(self) -> NDArray[np.bool_]:
        return (self.cosine < TOL.astray) | (self.quality < TOL.sliver)

    @property
    def worth(self) -> Floats:
        """Objective of an edge flip: first the normals, then the shape."""
        return np.minimum(self.cosine, TOL.straight) + 0.5 * self.quality

    def updated(self, changed: NDArray[np.int64], fit: _Fit) -> _Fit:
        """The same with some triangles replaced."""
        cosine, quality = self.cosine.copy(), self.quality.copy()
        cosine[changed], quality[changed] = fit
        return _Fit(cosine, quality)


def mended(mesh: SurfaceMesh, part: TriangleTree, creases: int, go_on: CancelCheck = never_cancel) -> SurfaceMesh:
    """The mesh near a part without the flaps, slivers and notches that can be mended without moving a vertex.

    A vertex of three triangles, one of them bad, is taken out; an edge of a bad triangle is turned if that makes the worse of its
    two triangles better, and one across a round, the middle of which misses the part, if it then misses less. What is good stays as it is:
    the first vertices, on `creases`, and the edges between them.
    """
    for _ in range(TOL.sliver_passes):
        before, mesh = mesh, _turned(_pruned(mesh, part, creases), part, creases, go_on)
        if mesh is before:
            break
    # Then edges that lie across rounds, except near where turning them would make walls cross each other.
    loose, most = np.ones(len(mesh.vertices), bool), -1
    for _ in range(TOL.notch_undoings):
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
    return without_unused(mesh.vertices, np.vstack([faces[~dropped], np.array(caps, faces.dtype)]))


def _turned(mesh: SurfaceMesh, part: TriangleTree, creases: int, go_on: CancelCheck, loose: Bools | None = None) -> SurfaceMesh:
    """The mesh with edges of bad triangles turned while that helps, in each round the most helpful first.

    Those across rounds, too, where all four vertices around are `loose`, shape [vertex_count]; None for nowhere.
    """
    vertices, faces = mesh.vertices, mesh.faces.copy()
    fit = _fit(vertices, faces, part)
    for _ in range(TOL.turnings):
        go_on()
        pairs = edge_pairs(faces)
        there = edge_keys(pairs.edges, len(vertices))  # ascending
        off = np.zeros(len(pairs.edges)) if loose is None else _off(vertices, pairs.edges, part)
        if loose is not None:
            off[~(loose[pairs.edges].all(axis=1) & loose[pairs.across].all(axis=1))] = 0.0
        suspect = (fit.bad[pairs.faces].any(axis=1) | (off > TOL.notch)) & (pairs.edges >= creases).any(axis=1)
        suspect[suspect] = ~among(edge_keys(pairs.across[suspect], len(vertices)), there)  # else there would be two such edges
        pairs, off = pairs.some(suspect), off[suspect]
        (a, b), (c, d) = pairs.edges.T, pairs.across.T
        halves = np.stack([np.stack([a, d, c], axis=1), np.stack([d, b, c], axis=1)], axis=1)
        new = _fit(vertices, halves.reshape(-1, 3), part).worth.reshape(-1, 2).min(axis=1)
        gain = new - fit.worth[pairs.faces].min(axis=1)
        across = off > TOL.notch
        gain[across] += TOL.notch_weight * (off[across] - _off(vertices, pairs.across[across], part))
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
    for index in np.argsort(-gain, kind="stable")[: np.count_nonzero(gain > TOL.least_gain)]:
        around, edge = set(pairs.faces[index].tolist()), tuple(sorted(pairs.across[index].tolist()))
        if busy.isdisjoint(around) and edge not in made:
            busy |= around
            made.add(edge)
            chosen.append(int(index))
    return np.array(chosen, np.int64)
