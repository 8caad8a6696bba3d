"""Pieces of a body's boundary, picked by place: which nodes a support holds, and how a load on the piece is shared out.

The boundary is looked at in points, many to a side, so that a piece smaller than the sides of the mesh, or cut off across
them, has its own area; where a piece ends at the edges of sides, the integral over them is exact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from mechstyle.errors import BadInput
from mechstyle.fea.elements import Elements, shape_functions
from mechstyle.load_cases import RESTING_FACE, Patch, Place
from mechstyle.mesh import Floats

SPLITS = 4
"""A side is looked at in SPLITS² equal triangles, three points each."""
FLOOR_TOLERANCE = 0.1
"""Sides whose corners are this close to the lowest point rest on the floor [mm] …"""
STEEPEST = np.cos(np.radians(5.0))
"""… if they look down within 5°."""
TOUCH = 1e-6
"""What lies on the border of a shape belongs to it, within this share of the body's size."""

Bools = NDArray[np.bool_]


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
class Picked:
    """A piece of the boundary.

    Attributes:
        inside: Which points of which sides belong to it, shape [side_count, point_count].
        nodes: Which nodes a support there holds, shape [node_count].
    """

    inside: Bools
    nodes: Bools

    def spread(self, body: Elements, traction: Floats) -> Floats:
        """Nodal forces of a traction on the piece, f_a = ∫ N_a t dA [N], shape [node_count, 3].

        Args:
            body: The body the piece was picked on, or a morph of it.
            traction: Force of every side if the whole of it were loaded, t times its area [N], shape [side_count, 3].
        """
        shares = self.inside @ shape_functions(POINTS, body.degree) / len(POINTS)
        forces = np.zeros_like(body.nodes)
        np.add.at(forces, body.boundary, shares[:, :, None] * traction[:, None, :])
        return forces

    def area(self, body: Elements) -> float:
        """Area of the piece [mm²]."""
        return float(self.inside.mean(axis=1) @ np.linalg.norm(body.area_vectors, axis=1))

    def normals(self, body: Elements) -> Floats:
        """Mean outward unit normals of the piece's sides at its nodes, shape [node_count, 3]; zero elsewhere."""
        sides = self.inside.any(axis=1) | self.nodes[body.boundary].all(axis=1)
        total = np.zeros_like(body.nodes)
        np.add.at(total, body.boundary[sides], body.area_vectors[sides][:, None, :])
        lengths = np.linalg.norm(total, axis=1, keepdims=True)
        return np.divide(total, lengths, out=np.zeros_like(total), where=lengths > 0.0)


@dataclass(frozen=True, eq=False)
class Boundary:
    """The boundary of an undeformed body, to pick pieces of it."""

    body: Elements

    def pick(self, place: Place) -> Picked:
        """The piece at a place; BadInput if there is none."""
        if not isinstance(place, Patch):
            picked = self._of_sides(self._resting())
        elif place.facet is not None:
            picked = self._of_sides(self._facet(np.array(place.facet), place.angle))
        elif place.near is not None:
            picked = self._near(np.array(place.near[:3]), place.near[3])
        else:
            picked = self._within(_shape(place, TOUCH * float(np.ptp(self.body.nodes, axis=0).max())))
        if not picked.inside.any():
            raise BadInput(self._nothing(place))
        return picked

    @cached_property
    def points(self) -> Floats:
        """The points of every side [mm], shape [side_count, point_count, 3]."""
        return np.einsum("pc,fcx->fpx", POINTS, self.body.nodes[self.body.boundary[:, :3]])

    @cached_property
    def normals(self) -> Floats:
        """Outward unit normals of the sides, shape [side_count, 3]."""
        vectors = self.body.area_vectors
        return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)

    def _within(self, shape: Callable[[Floats], Bools]) -> Picked:
        """What lies in a shape; of a piece too small for three nodes, the nodes of the sides it touches."""
        on_boundary = np.zeros(len(self.body.nodes), dtype=bool)
        on_boundary[self.body.boundary] = True
        inside, nodes = shape(self.points), on_boundary & shape(self.body.nodes)
        return Picked(inside, nodes if nodes.sum() >= 3 else self._nodes_of(np.asarray(inside.any(axis=1))))

    def _near(self, place: Floats, radius: float) -> Picked:
        """What lies around the nearest point, on sides that face the same way as the one there."""
        side, centre = self._nearest(place)
        same = np.asarray(self.normals @ self.normals[side] > 0.0)
        whole = self._within(lambda points: np.asarray(np.linalg.norm(points - centre, axis=-1) <= radius))
        return Picked(whole.inside & same[:, None], whole.nodes & self._nodes_of(same))

    def _of_sides(self, sides: Bools) -> Picked:
        return Picked(np.repeat(sides[:, None], len(POINTS), axis=1), self._nodes_of(sides))

    def _nodes_of(self, sides: Bools) -> Bools:
        nodes = np.zeros(len(self.body.nodes), dtype=bool)
        nodes[self.body.boundary[sides]] = True
        return nodes

    def _nearest(self, place: Floats) -> tuple[int, Floats]:
        """The side with the point nearest to a place, and that point."""
        distance = np.linalg.norm(self.points - place, axis=-1)
        side, point = np.unravel_index(int(distance.argmin()), distance.shape)
        return int(side), self.points[side, point]

    def _resting(self) -> Bools:
        """Sides that lie flat on the floor."""
        height = self.body.nodes[:, 2]
        low = (height[self.body.boundary[:, :3]] < height.min() + FLOOR_TOLERANCE).all(axis=1)
        return low & (self.normals[:, 2] < -STEEPEST)

    def _facet(self, place: Floats, angle: float) -> Bools:
        """Sides that face as the one nearest to a place does, within an angle [degrees], and are connected with it."""
        side, _ = self._nearest(place)
        alike = self.normals @ self.normals[side] >= np.cos(np.radians(angle)) - 1e-9
        corners = self.body.boundary[:, :3]
        ends = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        _, edge = np.unique(ends, axis=0, return_inverse=True)
        owner = np.repeat(np.arange(len(corners)), 3)
        kept = alike[owner]
        meets = coo_array((np.ones(kept.sum()), (owner[kept], edge.ravel()[kept])), shape=(len(corners), int(edge.max()) + 1)).tocsr()
        _, component = connected_components(meets @ meets.T, directed=False)
        return np.asarray(component == component[side]) & alike

    def _nothing(self, place: Place) -> str:
        if not isinstance(place, Patch):
            return f"{RESTING_FACE!r} selects nothing, because the part has no flat face to stand on: pick a place by sphere, box or facet"
        low, high = self.body.nodes.min(axis=0), self.body.nodes.max(axis=0)
        span = ", ".join(f"{axis} {a:.1f} to {b:.1f}" for axis, a, b in zip("xyz", low, high, strict=True))
        return f"{place.words} selects no surface: the part spans {span} mm"


def _shape(patch: Patch, touch: float) -> Callable[[Floats], Bools]:
    """Whether points, shape [..., 3], lie in a sphere, a box or on one side of a plane."""
    if patch.sphere is not None:
        centre, radius = np.array(patch.sphere[:3]), patch.sphere[3]
        return lambda points: np.asarray(np.linalg.norm(points - centre, axis=-1) <= radius + touch)
    if patch.box is not None:
        low, high = np.array(patch.box[:3]) - touch, np.array(patch.box[3:]) + touch
        return lambda points: np.asarray(((points >= low) & (points <= high)).all(axis=-1))
    assert patch.plane is not None, "the other shapes are picked by their sides"
    origin, towards = np.array(patch.plane[:3]), np.array(patch.plane[3:])
    towards = towards / np.linalg.norm(towards)
    return lambda points: np.asarray((points - origin) @ towards >= -touch)
