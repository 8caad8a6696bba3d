"""Nearest points and first ray hits on a triangle surface, through one bounding volume hierarchy (NVIDIA Warp)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from mechstyle._warp import wp
from mechstyle.geometry.kernels import nearest_points
from mechstyle.records.mesh import Floats


class Nearest(NamedTuple):
    """Nearest points on a surface."""

    face: NDArray[np.int32]  # face the point lies on, shape [point_count], int32
    weights: Floats  # barycentric weights of the face's three corners, shape [point_count, 3]
    point: Floats  # the point itself [mm], shape [point_count, 3]
    distance: Floats  # its distance from the query [mm], shape [point_count]


class TriangleTree:
    """A bounding volume hierarchy over triangles, for queries of many points at once.

    Coordinates are centred before they become single precision, so that a part far from the origin loses nothing.
    """

    def __init__(self, vertices: ArrayLike, faces: ArrayLike, device: str = "cpu", *, winding: bool = False) -> None:
        """Build the tree over faces, shape [face_count, 3], of vertices [mm], shape [n, 3]; with `winding` it knows winding numbers."""
        self.vertices = np.asarray(vertices, dtype=np.float64)
        self.faces = np.asarray(faces, dtype=np.int32)
        self.device = device
        self._centre = 0.5 * (self.vertices.min(axis=0) + self.vertices.max(axis=0))
        indices: Any = wp.array(self.faces.ravel(), dtype=wp.int32, device=device)
        self._mesh = wp.Mesh(points=self.points(self.vertices), indices=indices, support_winding_number=winding)

    @property
    def id(self) -> Any:
        """Handle for Warp kernels."""
        return self._mesh.id

    def points(self, positions: ArrayLike) -> Any:
        """Positions [mm], shape [n, 3], as a Warp array in the tree's centred frame."""
        centred = np.asarray(positions, dtype=np.float64) - self._centre
        return wp.array(centred.astype(np.float32), dtype=wp.vec3, device=self.device)

    def nearest(self, queries: ArrayLike, reach: float = 1e6) -> Nearest:
        """The nearest surface point to each query [mm], shape [n, 3]; face −1, infinitely far, where there is none within reach [mm]."""
        positions = np.asarray(queries, dtype=np.float64).reshape(-1, 3)
        count = len(positions)
        face: Any = wp.empty(count, dtype=wp.int32, device=self.device)
        uv: Any = wp.zeros(count, dtype=wp.vec2, device=self.device)
        wp.launch(nearest_points, dim=count, inputs=[self.id, self.points(positions), reach, face, uv], device=self.device)
        faces = face.numpy()
        weights = _weights(uv.numpy().astype(np.float64))
        points = np.einsum("ij,ijk->ik", weights, self.vertices[self.faces[faces]])
        return Nearest(faces, weights, points, np.where(faces < 0, np.inf, np.linalg.norm(points - positions, axis=1)))

    def interpolation(self, queries: ArrayLike) -> sp.csr_array:
        """Sparse matrix from values at the vertices to values at the nearest surface points, shape [n, vertex_count].

        Every row is a convex combination of the three corners of one face.
        """
        near = self.nearest(queries)
        rows = np.repeat(np.arange(len(near.face)), 3)
        columns = self.faces[near.face].ravel()
        return sp.csr_array((near.weights.ravel(), (rows, columns)), shape=(len(near.face), len(self.vertices)))


def _weights(uv: Floats) -> Floats:
    """Convex weights from Warp's first two barycentric coordinates, shape [n, 3]."""
    weights: Floats = np.clip(np.column_stack([uv, 1.0 - uv.sum(axis=1)]), 0.0, 1.0)
    weights /= weights.sum(axis=1, keepdims=True)
    return weights
