"""A closed surface in fewer triangles, chosen by quadrics (Garland and Heckbert 1997).

M. Garland, P. Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997. The quadric of a vertex is the sum of squared
distances to the planes of the triangles it has stood for. In every round the cheapest edges that do not touch each other collapse.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.geometry.remeshing.tolerances import TOL
from mechstyle.geometry.remeshing.topology import edges_of, far_apart, merged, valid_collapses
from mechstyle.records.mesh import Floats, Indices, SurfaceMesh


class _Quadrics(NamedTuple):
    """Functions xᵀ A x + 2 bᵀ x + c of a place x, shape [k, 3, 3], [k, 3], [k]."""

    a: Floats
    b: Floats
    c: Floats

    @classmethod
    def around(cls, vertices: Floats, faces: Indices) -> _Quadrics:
        """Those of vertices: squared distance to the plane of each of their faces, weighted by its area."""
        a, b, c = vertices[faces].transpose(1, 0, 2)
        normals = np.cross(b - a, c - a)
        weights = np.maximum(np.linalg.norm(normals, axis=1), 1e-30)
        normals /= weights[:, None]
        planes = np.column_stack([normals, -np.einsum("ij,ij->i", normals, a)])
        squares = np.einsum("k,ki,kj->kij", weights, planes, planes).reshape(-1, 16)
        total = np.zeros((len(vertices), 16))
        for corner in faces.T:
            np.add.at(total, corner, squares)
        whole = total.reshape(-1, 4, 4)
        return cls(whole[:, :3, :3].copy(), whole[:, :3, 3].copy(), whole[:, 3, 3].copy())

    def at_both_ends(self, edges: Indices) -> _Quadrics:
        """Those of both ends of edges together."""
        return _Quadrics(*(part[edges[:, 0]] + part[edges[:, 1]] for part in self))

    def at(self, places: Floats) -> Floats:
        return np.einsum("ki,kij,kj->k", places, self.a, places) + 2.0 * np.einsum("ki,ki->k", self.b, places) + self.c

    def lowest(self, near: Floats) -> Floats:
        """Where they are least, near the places given in directions that change little."""
        weight = TOL.tied * np.trace(self.a, axis1=1, axis2=2) + 1e-30
        downhill = -(np.einsum("kij,kj->ki", self.a, near) + self.b)
        return near + np.linalg.solve(self.a + weight[:, None, None] * np.eye(3), downhill[:, :, None])[:, :, 0]


def decimated(mesh: SurfaceMesh, faces: int, go_on: CancelCheck = never_cancel, *, longest: float = np.inf) -> SurfaceMesh:
    """The closed surface in so many triangles, an even number, or in as few as keep its shells and handles and turn none over.

    No collapse makes an edge longer than `longest` [mm]: without it nothing is left of a flat face but its corners.
    """
    centre = mesh.vertices.mean(axis=0)
    vertices, corners = mesh.vertices - centre, mesh.faces
    quadrics = _Quadrics.around(vertices, corners)
    for _ in range(TOL.decimation_rounds):
        go_on()
        edges, excess = edges_of(corners), (len(corners) - faces + 1) // 2  # a collapse takes two triangles
        shared = quadrics.at_both_ends(edges)
        places = shared.lowest(0.5 * (vertices[edges[:, 0]] + vertices[edges[:, 1]]))
        costs = shared.at(places)
        sound = np.flatnonzero(valid_collapses(vertices, corners, edges, places, longest=longest, cosine=TOL.turn_in_decimation))
        share = TOL.cheap_at_first if len(corners) > TOL.at_first * faces else TOL.cheap
        cheap = sound[np.argsort(costs[sound], kind="stable")][: max(int(share * len(edges)), 1)]
        apart = far_apart(edges[cheap], np.floor(np.log2(np.maximum(costs[cheap], 1e-12))), corners, len(vertices))
        chosen = cheap[apart][: max(excess, 0)]
        if not len(chosen):
            break
        edges = edges[chosen]
        (stays, goes), vertices = edges.T, vertices.copy()
        vertices[stays] = places[chosen]
        for part, both in zip(quadrics, quadrics.at_both_ends(edges), strict=True):
            part[stays] = both
        quadrics = _Quadrics(*(np.delete(part, goes, axis=0) for part in quadrics))
        vertices, corners = merged(vertices, corners, stays, goes)
    return SurfaceMesh(vertices + centre, corners)
