"""Tetrahedra made kinder to the time step of explicit integration: flat ones are peeled off the boundary, low ones made higher.

The highest frequency of a linear tetrahedron grows with Σ 1/h² over its four heights (Σ |∇N|²), so that a few low ones among tens of
thousands set the step for all. They lie at the boundary, where fTetWild has to follow the triangles it was given. Moving some hundred
vertices by no more than the tolerance it worked to doubles the step (Freitag and Ollivier-Gooch 1997 improve meshes in the same way).

What stands out lands first and bears the impact: a vertex 0.1 mm below the floor doubled the stress of a flat landing. So vertices go
inwards or slide along the surface, but not outwards.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.geometry.remeshing.tolerances import TOL
from mechstyle.records.mesh import Floats, Indices, TetMesh

ACROSS = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
"""Corners of the face across from each corner of a tetrahedron, counterclockwise from outside."""


def improved(tets: TetMesh, *, reach: float, floor: float, go_on: CancelCheck = never_cancel) -> TetMesh:
    """Tetrahedra with the same connections, but for flat ones that are gone, whose lowest are higher.

    A boundary vertex moves inwards or along the surface by `reach` [mm] at most in the first pass, and half of it in the second; of
    tetrahedra lower than twice this, those are peeled off that lie flat under the boundary. Vertices in the plane at the height `floor`
    [mm] stay in it.
    """
    peeled = _peeled(tets, 2.0 * reach)
    for share in TOL.reaches:
        peeled = peeled.moved(_moved(peeled, share * reach, floor, go_on))
    return peeled


def heights(vertices: Floats, tets: Indices) -> Floats:
    """Least height of positively oriented tetrahedra, shape [tet_count, 4], [mm], shape [tet_count]."""
    volumes, normals = _volumes_and_normals(vertices[tets])
    return np.asarray(6.0 * volumes / np.sqrt(_squares(normals)).max(axis=1))


def _peeled(tets: TetMesh, low: float) -> TetMesh:
    """Without tetrahedra lower than `low` [mm] of which two faces lie side by side in the boundary, and so do the two then laid bare.

    A flat one that lies with one face on others and has another upon it, at an inner edge of the part, would leave a crack.
    """
    kept = tets.tets
    for _ in range(TOL.peelings):
        gone = _to_peel(tets.vertices, kept, low)
        if not gone:
            break
        kept = np.delete(kept, gone, axis=0)
    used, index = np.unique(kept, return_inverse=True)
    return TetMesh(tets.vertices[used], index.reshape(-1, 4).astype(np.int32))


def _to_peel(vertices: Floats, tets: Indices, low: float) -> list[int]:
    """Tetrahedra that can be taken off together: no two share a vertex, and the edge that appears is not in the boundary yet."""
    outer, edges = _boundary(tets)
    height = heights(vertices, tets)
    candidates = np.flatnonzero((outer.sum(axis=1) == 2) & (height < low))
    _, normals = _volumes_and_normals(vertices[tets[candidates]])
    gone: list[int] = []
    touched: set[int] = set()
    for number in np.argsort(height[candidates]):
        corners = tets[candidates[number]]
        across = np.flatnonzero(outer[candidates[number]])
        bared = np.flatnonzero(~outer[candidates[number]])
        if not (_side_by_side(*normals[number, across]) and _side_by_side(*normals[number, bared])):
            continue
        if tuple(sorted(corners[across].tolist())) in edges or touched & set(corners.tolist()):
            continue
        touched |= set(corners.tolist())
        gone.append(int(candidates[number]))
    return gone


def _side_by_side(one: Floats, other: Floats) -> bool:
    """Whether two faces are almost one, by their normals, shape [3]."""
    return bool(one @ other > TOL.leaning * np.linalg.norm(one) * np.linalg.norm(other))


def _boundary(tets: Indices) -> tuple[NDArray[np.bool_], set[tuple[int, int]]]:
    """Which faces of tetrahedra, by the corner across, are boundary, shape [tet_count, 4], and the boundary's edges, lower number first."""
    faces = np.sort(tets[:, ACROSS].reshape(-1, 3), axis=1)
    _, first, index, count = np.unique(faces, axis=0, return_index=True, return_inverse=True, return_counts=True)
    outer = faces[first[count == 1]]
    edges = outer[:, [0, 1, 1, 2, 0, 2]].reshape(-1, 2)
    return (count[index.ravel()] == 1).reshape(-1, 4), {(int(a), int(b)) for a, b in edges}


def _moved(tets: TetMesh, reach: float, floor: float, go_on: CancelCheck) -> Floats:
    """Vertices [mm] after the lowest tetrahedra were made higher, shape [vertex_count, 3]."""
    height = heights(tets.vertices, tets.tets)
    wanted = float(np.quantile(height, TOL.made_higher))
    free = np.unique(tets.tets[height <= wanted])
    around = tets.tets[np.isin(tets.tets, free).any(axis=1)]
    axes, least, most = _room(tets, free, floor)
    patch = _Patch(tets.vertices, around, free, reach * axes, wanted)
    found = minimize(
        patch.value,
        np.zeros(least.size),
        jac=True,
        method="L-BFGS-B",
        bounds=np.stack([least.ravel(), most.ravel()], axis=1),
        callback=lambda _: go_on(),
        options={"maxiter": TOL.minimiser_rounds, "maxfun": 2 * TOL.minimiser_rounds},
    )
    moved = patch.moved(found.x)
    moved[:, 2] = np.maximum(moved[:, 2], floor)
    return moved


def _room(tets: TetMesh, free: Indices, floor: float) -> tuple[Floats, Floats, Floats]:
    """Where vertices may go: three axes each, shape [m, 3, 3], and how far along them at least and at most, shape [m, 3], in reaches.

    On the boundary the first axis is the normal, against which they may go by 1, or less where a face around looks the other way: inwards
    of the others is outwards of that one. The others are directions along the surface. The face around that leans towards one most says
    how far a vertex that slides along it stands out: little along an edge, much across it.
    """
    faces = tets.boundary_faces
    normals = _unit_normals(tets.vertices, faces)
    place = np.full(len(tets.vertices), -1)
    place[free] = np.arange(len(free))
    face, corner = np.nonzero(place[faces] >= 0)
    vertex, around = place[faces[face, corner]], normals[face]
    sums, tensors = np.zeros((len(free), 3)), np.zeros((len(free), 3, 3))
    np.add.at(sums, vertex, around)
    np.add.at(tensors, vertex, around[:, :, None] * around[:, None, :])
    outside = np.bincount(vertex, minlength=len(free)) > 0
    standing = outside & (tets.vertices[free, 2] <= floor)
    first = np.where(standing[:, None], [0.0, 0.0, -1.0], _normalised(sums))
    along = np.linalg.eigh(tensors)[1][:, :, 0]  # what the faces around lean towards least
    along = _normalised(along - np.einsum("vi,vi->v", along, first)[:, None] * first)
    axes = np.where(outside[:, None, None], np.stack([first, along, np.cross(first, along)], axis=1), np.eye(3))
    leaning, against = np.full((len(free), 3), 1e-6), np.full(len(free), 1e-6)
    towards = np.einsum("fki,fi->fk", axes[vertex], around)
    np.maximum.at(leaning, vertex, np.abs(towards))
    np.maximum.at(against, vertex, -towards[:, 0])
    most = np.where(outside[:, None], np.minimum(TOL.outwards / leaning, 1.0), TOL.inside)
    least = -most
    most[outside, 0], least[outside, 0] = 0.0, -np.minimum(TOL.outwards / against, 1.0)[outside]
    least[standing, 0] = 0.0
    return axes, least, most


def _unit_normals(vertices: Floats, faces: Indices) -> Floats:
    corners = vertices[faces]
    return _normalised(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def _normalised(vectors: Floats) -> Floats:
    """Vectors of length one in the same directions; zero for zero, shape [k, 3]."""
    length = np.linalg.norm(vectors, axis=1)[:, None]
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)


class _Patch(NamedTuple):
    """Tetrahedra around vertices that may move."""

    vertices: Floats  # all vertices [mm], shape [vertex_count, 3]
    tets: Indices  # the tetrahedra, shape [k, 4]
    free: Indices  # vertices that may move, shape [m]
    axes: Floats  # three axes for each of them, as long as the unit in which shifts along them are counted [mm], shape [m, 3, 3]
    wanted: float  # the height against which theirs are counted [mm]

    def moved(self, shift: Floats) -> Floats:
        """All vertices [mm] with the free ones shifted, shape [vertex_count, 3]."""
        vertices = self.vertices.copy()
        vertices[self.free] += np.einsum("vki,vk->vi", self.axes, shift.reshape(-1, 3))
        return vertices

    def value(self, shift: Floats) -> tuple[float, Floats]:
        """Logarithm of a power mean of Σ (wanted/h)² over the tetrahedra, and its gradient by the shift, shape [3 m]."""
        vertices = self.moved(shift)
        corners = vertices[self.tets]
        volumes, normals = _volumes_and_normals(corners)
        if volumes.min() <= 0.0:
            return TOL.turned_over, np.zeros_like(shift)
        inverse = self.wanted**2 / (36.0 * volumes**2)  # the normals are twice the faces' areas, and h = 3 V / A
        squares = inverse * _squares(normals).sum(axis=1)
        powers = squares**TOL.power
        weights = powers / (squares * powers.sum())
        gradient = np.zeros_like(corners)
        for corner, (a, b, c) in enumerate(ACROSS):
            normal = normals[:, corner]
            scale = (2.0 * weights * inverse)[:, None]
            by_b, by_c = scale * np.cross(corners[:, c] - corners[:, a], normal), scale * np.cross(normal, corners[:, b] - corners[:, a])
            gradient[:, b] += by_b
            gradient[:, c] += by_c
            gradient[:, a] -= by_b + by_c
            gradient[:, corner] += (weights * squares / (3.0 * volumes))[:, None] * normal  # dV = -n/6 for an outward normal n
        total = np.zeros_like(vertices)
        np.add.at(total, self.tets.ravel(), gradient.reshape(-1, 3))
        return float(np.log(powers.sum()) / TOL.power), np.einsum("vki,vi->vk", self.axes, total[self.free]).ravel()


def _volumes_and_normals(corners: Floats) -> tuple[Floats, Floats]:
    """Volumes [mm³], shape [k], and outward normals of the faces across, twice as long as these are large [mm²], shape [k, 4, 3]."""
    sides = corners[:, 1:] - corners[:, :1]
    volumes = np.einsum("ij,ij->i", np.cross(sides[:, 0], sides[:, 1]), sides[:, 2]) / 6.0
    faces = corners[:, ACROSS]
    return volumes, np.cross(faces[:, :, 1] - faces[:, :, 0], faces[:, :, 2] - faces[:, :, 0])


def _squares(vectors: Floats) -> Floats:
    return np.asarray(np.einsum("...i,...i->...", vectors, vectors))
