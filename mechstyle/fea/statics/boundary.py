"""The outside of a body of tetrahedra, looked at in points, many to a side, and how a traction on it becomes nodal forces.

With many points a piece that is smaller than the sides of the mesh, or cut off across them, has its own area; where a piece
ends at the edges of sides, the integral over them is exact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from mechstyle.errors import BadInput
from mechstyle.fea.elements import ElementMesh
from mechstyle.records.load_cases import RESTING_FACE, Patch, Place
from mechstyle.records.mesh import Bools, Floats, Indices, SurfaceMesh, in_ball, on_floor

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
        N = POINTS  # L_i of a linear triangle; L_i (2 L_i − 1) at the corners and 4 L_i L_j at the middles of a quadratic one
        if self.sides.shape[1] > 3:
            first, second = np.triu_indices(3, k=1)
            N = np.concatenate([N * (2.0 * N - 1.0), 4.0 * N[:, first] * N[:, second]], axis=1)
        shares = inside @ N / len(POINTS)
        forces = np.zeros_like(self.mesh.nodes)
        np.add.at(forces, self.sides, shares[:, :, None] * traction[:, None, :])
        return forces


TOUCH = 1e-6
"""What lies on the border of a shape belongs to it, within this share of the body's size."""


@dataclass(frozen=True, eq=False)
class Picked:
    """A piece of a boundary.

    Attributes:
        inside: Which points of which sides belong to it, shape [side_count, point_count].
        nodes: Which nodes a support there holds, shape [node_count].
    """

    inside: Bools
    nodes: Bools

    def area(self, boundary: Boundary) -> float:
        """Its area on a body, the one it was picked on or a morph of it [mm²]."""
        return float(self.inside.mean(axis=1) @ boundary.areas)

    def normals(self, boundary: Boundary) -> Floats:
        """Mean outward unit normals of its sides at its nodes, shape [node_count, 3]; zero elsewhere."""
        sides = self.inside.any(axis=1) | self.nodes[boundary.sides].all(axis=1)
        total = np.zeros_like(boundary.mesh.nodes)
        np.add.at(total, boundary.sides[sides], boundary.area_vectors[sides][:, None, :])
        lengths = np.linalg.norm(total, axis=1, keepdims=True)
        return np.divide(total, lengths, out=np.zeros_like(total), where=lengths > 0.0)


def pick(boundary: Boundary, place: Place) -> Picked:
    """The piece of an undeformed boundary at a place; BadInput if there is none."""
    if not isinstance(place, Patch):
        picked = _of_sides(boundary, on_floor(SurfaceMesh(boundary.mesh.nodes, boundary.sides[:, :3])))
    elif place.facet is not None:
        picked = _of_sides(boundary, _facet(boundary, np.array(place.facet), place.angle))
    elif place.near is not None:
        picked = _near(boundary, np.array(place.near[:3]), place.near[3])
    else:
        touch = TOUCH * float(np.ptp(boundary.mesh.nodes, axis=0).max())
        picked = _within(boundary, partial(place.contains, margin=touch))
    if not picked.inside.any():
        if not isinstance(place, Patch):
            why = "because the part has no flat face to stand on: pick a place by sphere, box or facet"
            raise BadInput(f"{RESTING_FACE!r} selects nothing, {why}")
        low, high = boundary.mesh.nodes.min(axis=0), boundary.mesh.nodes.max(axis=0)
        span = ", ".join(f"{axis} {a:.1f} to {b:.1f}" for axis, a, b in zip("xyz", low, high, strict=True))
        raise BadInput(f"{place.words} selects no surface: the part spans {span} mm")
    return picked


def _within(boundary: Boundary, shape: Callable[[Floats], Bools]) -> Picked:
    """Boundary nodes in a shape; if fewer than three, the nodes of the faces it touches."""
    inside = shape(boundary.points)
    nodes = _nodes_of(boundary, np.ones(len(boundary.sides), dtype=bool)) & shape(boundary.mesh.nodes)
    return Picked(inside, nodes if nodes.sum() >= 3 else _nodes_of(boundary, np.asarray(inside.any(axis=1))))


def _near(boundary: Boundary, place: Floats, radius: float) -> Picked:
    """Boundary nodes around the nearest surface point, on faces that face the same way as the one there."""
    side, centre = _nearest(boundary, place)
    same = np.asarray(boundary.area_vectors @ boundary.area_vectors[side] > 0.0)
    whole = _within(boundary, lambda points: in_ball(points, centre, radius))
    return Picked(whole.inside & same[:, None], whole.nodes & _nodes_of(boundary, same))


def _of_sides(boundary: Boundary, sides: Bools) -> Picked:
    return Picked(np.repeat(sides[:, None], len(POINTS), axis=1), _nodes_of(boundary, sides))


def _nodes_of(boundary: Boundary, sides: Bools) -> Bools:
    nodes = np.zeros(len(boundary.mesh.nodes), dtype=bool)
    nodes[boundary.sides[sides]] = True
    return nodes


def _nearest(boundary: Boundary, place: Floats) -> tuple[int, Floats]:
    """The side with the point nearest to a place, and that point."""
    distance = np.linalg.norm(boundary.points - place, axis=-1)
    side, point = np.unravel_index(int(distance.argmin()), distance.shape)
    return int(side), boundary.points[side, point]


def _facet(boundary: Boundary, place: Floats, angle: float) -> Bools:
    """Sides that face as the one nearest to a place does, within an angle [degrees], and are connected with it by such sides."""
    side, _ = _nearest(boundary, place)
    normals = boundary.area_vectors / boundary.areas[:, None]
    alike = np.asarray(normals @ normals[side] >= np.cos(np.radians(angle)) - 1e-9)
    corners = boundary.sides[:, :3]
    _, edge = np.unique(np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    owner = np.repeat(np.arange(len(corners)), 3)
    kept = alike[owner]
    meets = coo_array((np.ones(kept.sum()), (owner[kept], edge.ravel()[kept])), shape=(len(corners), int(edge.max()) + 1)).tocsr()
    _, component = connected_components(meets @ meets.T, directed=False)
    return np.asarray(component == component[side])
