"""Straight-sided linear and quadratic tetrahedra (TET4, TET10): their nodes, and how a field and its gradient follow from them.

Nodes of a quadratic tetrahedron: the corners 0 to 3, then the middles of the edges 01, 02, 03, 12, 13, 23 as nodes 4 to 9. With
the barycentric coordinates L of a point the shape functions are L_i (2 L_i − 1) at the corners and 4 L_i L_j at the middles
(Zienkiewicz and Taylor, The Finite Element Method, vol. 1, §8.8), for triangles as for tetrahedra.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from mechstyle.errors import unknown
from mechstyle.mesh import Floats, Indices, TetMesh

ElementName = Literal["tet4", "tet10"]
ELEMENTS: dict[str, int] = {"tet4": 1, "tet10": 2}
"""Degree of the shape functions by name."""

EDGES: Indices = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]], dtype=np.int32)
"""Corners at the ends of the edge whose middle is node 4 + row."""

FACES: Indices = np.array([[0, 2, 1, 5, 4, 7], [0, 1, 3, 4, 6, 8], [0, 3, 2, 6, 5, 9], [1, 2, 3, 7, 8, 9]], dtype=np.int32)
"""Nodes of each side, anticlockwise seen from outside: corners a, b, c, then the middles of ab, ac, bc."""

_NEAR, _FAR = (5.0 + 3.0 * math.sqrt(5.0)) / 20.0, (5.0 - math.sqrt(5.0)) / 20.0

GAUSS_POINTS: Floats = _FAR + (_NEAR - _FAR) * np.eye(4)
"""Barycentric coordinates of the four points that integrate quadratic polynomials exactly, a quarter of the volume each, shape [4, 4]."""


def quadratic_nodes(tets: TetMesh) -> tuple[Floats, Indices]:
    """The nodes of the quadratic tetrahedra on the same corners.

    Returns:
        Positions [mm], shape [node_count, 3], the corners first as in `tets.vertices`, then the middle of every edge; and the ten
        nodes of every element, shape [tet_count, 10].
    """
    ends = np.sort(tets.tets[:, EDGES].reshape(-1, 2), axis=1).astype(np.int64)
    count = len(tets.vertices)
    edges, middle = np.unique(ends[:, 0] * count + ends[:, 1], return_inverse=True)
    lower, upper = np.divmod(edges, count)
    nodes = np.concatenate([tets.vertices, 0.5 * (tets.vertices[lower] + tets.vertices[upper])])
    middles = count + middle.reshape(-1, len(EDGES))
    return nodes, np.concatenate([tets.tets, middles], axis=1).astype(np.int32)


def shape_functions(L: Floats, degree: int = 2) -> Floats:
    """Values of the shape functions at barycentric coordinates L, shape [n, corners] → [n, nodes]; they sum to one."""
    if degree == 1:
        return L
    first, second = np.triu_indices(L.shape[1], k=1)
    return np.concatenate([L * (2.0 * L - 1.0), 4.0 * L[:, first] * L[:, second]], axis=1)


def shape_slopes(L: Floats, degree: int = 2) -> Floats:
    """Derivatives of the shape functions of a tetrahedron by L_0 to L_3, shape [n, 4] → [n, nodes, 4]."""
    corner, row = np.arange(4), np.arange(len(EDGES))
    if degree == 1:
        return np.broadcast_to(np.eye(4), (len(L), 4, 4))
    slopes = np.zeros((len(L), 10, 4))
    first, second = EDGES.T
    slopes[:, corner, corner] = 4.0 * L - 1.0
    slopes[:, 4 + row, first] = 4.0 * L[:, second]
    slopes[:, 4 + row, second] = 4.0 * L[:, first]
    return slopes


@dataclass(frozen=True, eq=False)
class Elements:
    """A body of tetrahedra of one degree.

    Attributes:
        tets: The tetrahedra.
        degree: 1 for TET4, 2 for TET10.
        nodes: Positions of the nodes [mm], shape [node_count, 3]; the vertices of `tets` come first.
        connectivity: Nodes of every element, shape [tet_count, 4 or 10].
    """

    tets: TetMesh
    degree: int
    nodes: Floats
    connectivity: Indices

    @cached_property
    def boundary(self) -> Indices:
        """Nodes of the sides that belong to one element only, anticlockwise seen from outside, shape [side_count, 3 or 6]."""
        sides = self.connectivity[:, FACES[:, : 3 * self.degree]].reshape(-1, 3 * self.degree)
        _, first, count = np.unique(np.sort(sides[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
        return np.ascontiguousarray(sides[np.sort(first[count == 1])])

    @cached_property
    def area_vectors(self) -> Floats:
        """Outward normals of the boundary times the area of the side [mm²], shape [side_count, 3]."""
        a, b, c = (self.nodes[self.boundary[:, corner]] for corner in range(3))
        return 0.5 * np.cross(b - a, c - a)

    def gradients(self) -> Floats:
        """∇N_a at the Gauss points [1/mm], shape [tet_count, 4, nodes, 3], by the chain rule over the constant ∇L_i."""
        corners = self.tets.vertices[self.tets.tets]
        inverse = np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))
        barycentric = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)
        return np.einsum("qai,nij->nqaj", shape_slopes(GAUSS_POINTS, self.degree), barycentric)


def elements(tets: TetMesh, name: ElementName = "tet10") -> Elements:
    """The linear or quadratic elements on given tetrahedra."""
    if name not in ELEMENTS:
        raise unknown("element", name, ELEMENTS)
    nodes, connectivity = quadratic_nodes(tets) if name == "tet10" else (tets.vertices, tets.tets)
    return Elements(tets, ELEMENTS[name], nodes, connectivity)
