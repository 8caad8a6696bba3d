"""The outside of a body of tetrahedra, looked at in points, many to a side, and how a traction on it becomes nodal forces.

With many points a piece that is smaller than the sides of the mesh, or cut off across them, has its own area; where a piece
ends at the edges of sides, the integral over them is exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mechstyle.fea.elements import ElementMesh
from mechstyle.records.mesh import Bools, Floats, Indices

SIDES: Indices = np.array([[0, 2, 1, 5, 4, 7], [0, 1, 3, 4, 6, 8], [0, 3, 2, 6, 5, 9], [1, 2, 3, 7, 8, 9]], dtype=np.int32)
"""Nodes of each side of a tetrahedron: corners a, b, c, anticlockwise seen from outside, then the middles of ab, ac, bc."""

SPLITS = 4
"""A side is looked at in SPLITS² equal triangles, three points each."""


def _points_of_a_triangle() -> Floats:
    """Barycentric coordinates of points of equal weight that integrate quadratic polynomials exactly, shape [3 SPLITS², 3].

    The three-point rule of degree two (Strang and Fix 1973) in each of the SPLITS² triangles that a regular division gives.
    """
    i, j = (index.ravel() for index in np.meshgrid(np.arange(SPLITS), np.arange(SPLITS), indexing="ij"))
    up, down = i + j < SPLITS, i + j < SPLITS - 1
    lowest = np.array([[0, 0], [1, 0], [0, 1]])
    triangles = [np.stack([i[up], j[up]], axis=1)[:, None] + lowest, np.stack([i[down], j[down]], axis=1)[:, None] + 1 - lowest]
    rule = np.full((3, 3), 1.0 / 6.0) + 0.5 * np.eye(3)
    plane = (rule @ np.concatenate(triangles) / SPLITS).reshape(-1, 2)
    return np.concatenate([1.0 - plane.sum(axis=1, keepdims=True), plane], axis=1)


POINTS = _points_of_a_triangle()


@dataclass(frozen=True, eq=False)
class Boundary:
    """The sides of a body that belong to one tetrahedron only.

    Attributes:
        mesh: The body.
    """

    mesh: ElementMesh

    @cached_property
    def sides(self) -> Indices:
        """Nodes of every side, in the order of SIDES, shape [side_count, 3 or 6]."""
        width = 3 if self.mesh.element.nodes == 4 else 6
        sides = self.mesh.connectivity[:, SIDES[:, :width]].reshape(-1, width)
        _, first, count = np.unique(np.sort(sides[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
        return np.ascontiguousarray(sides[np.sort(first[count == 1])])

    @cached_property
    def area_vectors(self) -> Floats:
        """Outward normals times the area of the side [mm²], shape [side_count, 3]."""
        a, b, c = (self.mesh.nodes[self.sides[:, corner]] for corner in range(3))
        return 0.5 * np.cross(b - a, c - a)

    @cached_property
    def areas(self) -> Floats:
        """Areas of the sides [mm²], shape [side_count]."""
        return np.asarray(np.linalg.norm(self.area_vectors, axis=1))

    @cached_property
    def points(self) -> Floats:
        """The points of every side [mm], shape [side_count, point_count, 3]."""
        return np.einsum("pc,fcx->fpx", POINTS, self.mesh.nodes[self.sides[:, :3]])

    def forces(self, inside: Bools, traction: Floats) -> Floats:
        """Consistent nodal forces of a traction, f_a = ∫ N_a t dA [N], shape [node_count, 3].

        Args:
            inside: Which points of which sides the traction acts at, shape [side_count, point_count].
            traction: t times the area of the whole side [N], shape [side_count, 3].
        """
        shares = inside @ _shape_functions(POINTS, self.sides.shape[1]) / len(POINTS)
        forces = np.zeros_like(self.mesh.nodes)
        np.add.at(forces, self.sides, shares[:, :, None] * traction[:, None, :])
        return forces


def _shape_functions(L: Floats, nodes: int) -> Floats:
    """L_i for a linear triangle; L_i (2 L_i − 1) at the corners and 4 L_i L_j at the middles of a quadratic one, shape [n, nodes]."""
    if nodes == 3:
        return L
    first, second = np.triu_indices(3, k=1)
    return np.concatenate([L * (2.0 * L - 1.0), 4.0 * L[:, first] * L[:, second]], axis=1)
