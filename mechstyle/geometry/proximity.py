"""Nearest points and first ray hits on a triangle surface, through one bounding volume hierarchy (NVIDIA Warp).

Also what is known at the vertices of tetrahedra, brought to those of the surface.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from mechstyle._warp import wp
from mechstyle.errors import BadInput, unknown
from mechstyle.geometry.kernels import nearest_points
from mechstyle.records.mesh import Floats, SurfaceMesh, TetMesh


class Nearest(NamedTuple):
    """Nearest points on a surface.

    Attributes:
        face: Face the point lies on, shape [point_count], int32.
        weights: Barycentric weights of the face's three corners, shape [point_count, 3].
        point: The point itself [mm], shape [point_count, 3].
        distance: Its distance from the query [mm], shape [point_count].
    """

    face: NDArray[np.int32]
    weights: Floats
    point: Floats
    distance: Floats


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

    def nearest(self, queries: ArrayLike) -> Nearest:
        """The nearest surface point to each query [mm], shape [n, 3]."""
        positions = np.asarray(queries, dtype=np.float64).reshape(-1, 3)
        count = len(positions)
        face: Any = wp.empty(count, dtype=wp.int32, device=self.device)
        uv: Any = wp.zeros(count, dtype=wp.vec2, device=self.device)
        wp.launch(nearest_points, dim=count, inputs=[self.id, self.points(positions), 1e6, face, uv], device=self.device)
        faces = face.numpy()
        weights = _weights(uv.numpy().astype(np.float64))
        points = np.einsum("ij,ijk->ik", weights, self.vertices[self.faces[faces]])
        return Nearest(faces, weights, points, np.linalg.norm(points - positions, axis=1))

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


METHODS = ("barycentric", "nearest")

RADIUS = 1.0
"""Of the disc along a surface that a field is averaged over [mm]."""


class SurfaceMean:
    """Area-weighted mean over a disc along one side of a surface, as a sparse operator.

    Args:
        surface: The surface; vertices whose normals point away from each other lie on other sides.
        radius: Radius of the disc [mm].
    """

    def __init__(self, surface: SurfaceMesh, radius: float = RADIUS) -> None:
        pairs = cKDTree(surface.vertices).query_pairs(radius, output_type="ndarray")
        normals, count = surface.vertex_normals, len(surface.vertices)
        pairs = pairs[np.einsum("ij,ij->i", normals[pairs[:, 0]], normals[pairs[:, 1]]) > 0.0]
        itself = np.arange(count)
        rows, columns = np.concatenate([pairs[:, 0], pairs[:, 1], itself]), np.concatenate([pairs[:, 1], pairs[:, 0], itself])
        weights = np.maximum(surface.vertex_areas, 1e-12)[columns]
        self._sums = sp.csr_array((weights, (rows, columns)), shape=(count, count))
        self._total = self._sums @ np.ones(count)

    def __call__(self, values: ArrayLike) -> Floats:
        """The mean around each vertex of values there, shape [vertex_count]."""
        return np.asarray((self._sums @ np.asarray(values, np.float64)) / self._total)


class Transfer:
    """A fixed linear map from the vertices of a tetrahedral mesh to those of a surface, worked out once.

    `barycentric` interpolates linearly on the boundary face nearest to each surface vertex. `nearest` is the published
    variant (Faruqi et al. 2025): both are scaled to the unit box, axis by axis, and the value of the nearest boundary
    vertex is taken; on smooth fields it is about ten times less exact.

    Args:
        surface: Where values are wanted, n vertices.
        tets: Where they are known, k vertices.
        method: `barycentric` or `nearest`.
        device: Warp device of the search.

    Raises:
        BadInput: If the method is neither.
    """

    def __init__(self, surface: SurfaceMesh, tets: TetMesh, method: str = "barycentric", *, device: str = "cpu") -> None:
        if method not in METHODS:
            raise unknown("transfer", method, METHODS)
        self.method = method
        if method == "barycentric":
            self._matrix = TriangleTree(tets.vertices, tets.boundary_faces, device).interpolation(surface.vertices)
        else:
            outer, count = np.unique(tets.boundary_faces), len(surface.vertices)
            nearest = cKDTree(_in_unit_box(tets.vertices[outer])).query(_in_unit_box(surface.vertices))[1]
            self._matrix = sp.csr_array((np.ones(count), outer[nearest], np.arange(count + 1)), shape=(count, len(tets.vertices)))

    def to_surface(self, values: ArrayLike) -> Floats:
        """Values at the surface vertices, shape [n], from values at the tetrahedra's vertices, shape [k].

        Raises:
            BadInput: If there is not one value per vertex of the tetrahedra.
        """
        known = np.asarray(values, dtype=np.float64)
        if known.shape != self._matrix.shape[1:]:
            raise BadInput(f"{known.shape} values cannot go to the surface: there must be one for each of {self._matrix.shape[1]} vertices")
        return np.asarray(self._matrix @ known)


def _in_unit_box(positions: Floats) -> Floats:
    scaled: Floats = (positions - positions.min(axis=0)) / np.maximum(np.ptp(positions, axis=0), 1e-12)
    return scaled
