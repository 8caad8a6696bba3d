"""Bringing what is known at the tetrahedra's vertices to the vertices of the surface."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from mechstyle.errors import BadInput, unknown
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.records.mesh import Floats, SurfaceMesh, TetMesh

METHODS = ("barycentric", "nearest")

RADIUS = 1.0
"""Of the disc along a surface that a field is averaged over [mm]."""


class SurfaceMean:
    """Area-weighted mean over a disc of a radius [mm] along one side of a surface, whose normals point one way, as a sparse operator."""

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
    vertex is taken; on smooth fields it is about ten times less exact. BadInput for any other method.
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
        """Values at the surface vertices from one for each vertex of the tetrahedra; BadInput if there are not as many."""
        known = np.asarray(values, dtype=np.float64)
        if known.shape != self._matrix.shape[1:]:
            raise BadInput(f"{known.shape} values cannot go to the surface: there must be one for each of {self._matrix.shape[1]} vertices")
        return np.asarray(self._matrix @ known)


def _in_unit_box(positions: Floats) -> Floats:
    scaled: Floats = (positions - positions.min(axis=0)) / np.maximum(np.ptp(positions, axis=0), 1e-12)
    return scaled
