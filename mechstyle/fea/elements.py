"""Straight-sided quadratic tetrahedra (TET10): where their nodes are, and how displacement and its gradient follow from them.

Nodes of an element: the corners 0 to 3, then the middles of the edges 01, 02, 03, 12, 13, 23 as nodes 4 to 9. With the
barycentric coordinates L of a point the shape functions are L_i (2 L_i − 1) at the corners and 4 L_i L_j at the middles
(Zienkiewicz and Taylor, The Finite Element Method, vol. 1, §8.8).
"""

from __future__ import annotations

import math

import numpy as np

from mechstyle.mesh import Floats, Indices, TetMesh

EDGES: Indices = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]], dtype=np.int32)
"""Corners at the ends of the edge whose middle is node 4 + row."""

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


def shape_functions(L: Floats) -> Floats:
    """Values of the ten shape functions at barycentric coordinates L, shape [n, 4] → [n, 10]; they sum to one."""
    first, second = EDGES.T
    return np.concatenate([L * (2.0 * L - 1.0), 4.0 * L[:, first] * L[:, second]], axis=1)


def shape_slopes(L: Floats) -> Floats:
    """Derivatives of the ten shape functions by the four barycentric coordinates, shape [n, 4] → [n, 10, 4]."""
    slopes = np.zeros((len(L), 10, 4))
    corner, row = np.arange(4), np.arange(len(EDGES))
    first, second = EDGES.T
    slopes[:, corner, corner] = 4.0 * L - 1.0
    slopes[:, 4 + row, first] = 4.0 * L[:, second]
    slopes[:, 4 + row, second] = 4.0 * L[:, first]
    return slopes
