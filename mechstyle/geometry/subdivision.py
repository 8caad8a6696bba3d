"""Quartering: every face cut into four at the middles of its edges, without moving the surface."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from mechstyle.records.mesh import Indices, SurfaceMesh


class Quartered(NamedTuple):
    """A surface in four times as many faces.

    Attributes:
        mesh: The finer surface of the same shape; the vertices of the coarse one come first.
        parents: The two coarse vertices each vertex lies in the middle of, the same one twice for a coarse vertex, shape [fine_count, 2].
        interpolation: Takes values at the coarse vertices to the fine ones, shape [fine_count, coarse_count].
    """

    mesh: SurfaceMesh
    parents: Indices
    interpolation: sp.csr_array


def quartered(mesh: SurfaceMesh) -> Quartered:
    """Cut every face into four by midpoint subdivision; colours are interpolated."""
    count, edges = len(mesh.vertices), mesh.edges.astype(np.int64)
    parents = np.concatenate([np.repeat(np.arange(count), 2).reshape(-1, 2), edges])
    a, b, c = mesh.faces.T
    ab, bc, ca = (_number_of(edges, count, one, other) for one, other in ((a, b), (b, c), (c, a)))
    faces = np.stack([np.stack(corners, axis=1) for corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))], axis=1)
    rows = np.repeat(np.arange(len(parents)), 2)
    matrix = sp.csr_array((np.full(len(rows), 0.5), (rows, parents.ravel())), shape=(len(parents), count))
    colours = None if mesh.colours is None else matrix @ mesh.colours
    return Quartered(SurfaceMesh(matrix @ mesh.vertices, faces.reshape(-1, 3), colours), parents.astype(np.int32), matrix)


def _number_of(edges: NDArray[np.int64], count: int, one: Indices, other: Indices) -> NDArray[np.int64]:
    """Number of the vertex in the middle of each edge between two vertices; `edges` are sorted."""
    low, high = np.minimum(one, other).astype(np.int64), np.maximum(one, other)
    return np.asarray(count + np.searchsorted(edges[:, 0] * count + edges[:, 1], low * count + high))
