"""The two finite elements: tetrahedra that interpolate displacement linearly or quadratically, as tables of their shape functions.

Corners are numbered 0 to 3, the nodes in the middle of the edges 4 to 9 in the order of EDGES. Sides are straight: a middle node
starts halfway between its corners, so that the gradients of the barycentric coordinates L_i are constant in an element and the
chain rule is all there is, ∇N_a = Σ_i (∂N_a/∂L_i) ∇L_i.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.errors import unknown
from mechstyle.records.mesh import Floats, Indices, TetMesh

GAUSS_A, GAUSS_B = 0.25 + 0.15 * 5**0.5, 0.25 - 0.05 * 5**0.5
"""Barycentric coordinates of the four-point rule of degree two: of the near corner and of the three others (Hammer and Stroud 1956)."""

OVERSHOOT = 1.35
"""Most that a corner gets, over the largest of the four points: a fibre stress that falls to nothing at the far side of an element of a
plate in bending is 1.38 times as large at its corner as at the nearest point."""

EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
"""Corners at the ends of the edges, in the order of the nodes in their middle."""


@dataclass(frozen=True, eq=False)
class Element:
    """A tetrahedral element.

    Attributes:
        name: "tet4" or "tet10".
        derivatives: ∂N_a/∂L_i at the Gauss points, all of equal weight, shape [points, nodes, 4].
        mass_shares: Share of the element's mass that is lumped at each node, shape [nodes].
        stiffer: Its largest eigenfrequency over that of the linear element of the same shape, about: quadratic ones lie between 1.9 and
            2.6 times as high.
    """

    name: str
    derivatives: Floats
    mass_shares: Floats
    stiffer: float = 1.0

    @property
    def points(self) -> int:
        """Number of Gauss points."""
        return len(self.derivatives)

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return len(self.mass_shares)


def _quadratic_derivatives(L: Floats) -> Floats:
    """∂N_a/∂L_i of the quadratic element at points of given barycentric coordinates, [n, 4], shape [n, 10, 4]."""
    derivatives = np.zeros((len(L), 10, 4))
    for i in range(4):
        derivatives[:, i, i] = 4.0 * L[:, i] - 1.0
    for node, (i, j) in enumerate(EDGES, start=4):
        derivatives[:, node, i], derivatives[:, node, j] = 4.0 * L[:, j], 4.0 * L[:, i]
    return derivatives


LINEAR = Element("tet4", np.eye(4)[None], np.full(4, 0.25))
QUADRATIC = Element(
    "tet10", _quadratic_derivatives(np.full((4, 4), GAUSS_B) + (GAUSS_A - GAUSS_B) * np.eye(4)),
    mass_shares=np.array([1.0 / 36.0] * 4 + [4.0 / 27.0] * 6), stiffer=2.2,
)  # fmt: skip
"""N_i = L_i (2 L_i − 1) at corners and 4 L_i L_j between them; masses in the ratio of ∫N_a² (Hinton, Rock and Zienkiewicz 1976).

The row sums of the consistent mass matrix would give the corners a negative mass.
"""
ELEMENTS = {element.name: element for element in (LINEAR, QUADRATIC)}


def element_named(name: str) -> Element:
    """The element "tet4" or "tet10"; BadInput for any other."""
    if name not in ELEMENTS:
        raise unknown("element", name, tuple(ELEMENTS))
    return ELEMENTS[name]


@dataclass(frozen=True, eq=False)
class ElementMesh:
    """Tetrahedra with the nodes of their element.

    Attributes:
        tets: The straight-sided tetrahedra; their vertices are the first nodes.
        element: What interpolates between the nodes.
        connectivity: Nodes of each tetrahedron, shape [tet_count, nodes].
    """

    tets: TetMesh
    element: Element
    connectivity: Indices

    @cached_property
    def nodes(self) -> Floats:
        """Positions of the nodes [mm], shape [node_count, 3]."""
        corners = self.tets.vertices
        if self.element.nodes == 4:
            return corners
        ends = self.tets.tets[:, EDGES]
        nodes = np.empty((int(self.connectivity.max(initial=len(corners) - 1)) + 1, 3))
        nodes[: len(corners)] = corners
        nodes[self.connectivity[:, 4:]] = corners[ends].mean(axis=2)
        return nodes


def with_nodes(tets: TetMesh, element: Element) -> ElementMesh:
    """The mesh of an element on given tetrahedra, middle nodes numbered after the vertices along their sorted edges."""
    if element.nodes == 4:
        return ElementMesh(tets, element, tets.tets)
    ends = np.sort(tets.tets[:, EDGES].reshape(-1, 2), axis=1)
    _, number = np.unique(ends, axis=0, return_inverse=True)
    middle = len(tets.vertices) + number.reshape(-1, len(EDGES)).astype(np.int32)
    return ElementMesh(tets, element, np.concatenate([tets.tets, middle], axis=1))


def at_corners(values: ArrayLike) -> Floats:
    """A quantity at the corners, shape [..., 4], from what it is at the Gauss points, none of it negative, shape [..., points].

    Linear in a quadratic element, constant in a linear one. Of running maxima each was reached at another moment, so a line through
    them was never there: what it gives is kept between 0 and `OVERSHOOT` times the largest.
    """
    at_points = np.asarray(values, dtype=np.float64)
    if at_points.shape[-1] == 1:
        return np.repeat(at_points, 4, axis=-1)
    line = (at_points - GAUSS_B * at_points.sum(axis=-1, keepdims=True)) / (GAUSS_A - GAUSS_B)
    return np.clip(line, 0.0, OVERSHOOT * at_points.max(axis=-1, keepdims=True))


def at_vertices(tets: TetMesh, points: ArrayLike) -> Floats:
    """Volume-weighted mean at each vertex, shape [vertex_count], of values at the Gauss points, shape [tet_count, points]."""
    volumes, count = np.repeat(tets.volumes, 4), len(tets.vertices)
    nodes, values = tets.tets.ravel(), at_corners(points).ravel()
    weights = np.bincount(nodes, volumes, count)
    return np.bincount(nodes, volumes * values, count) / np.where(weights > 0.0, weights, 1.0)
