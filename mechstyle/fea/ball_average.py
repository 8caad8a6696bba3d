"""Stress averaged over a ball of fixed physical radius, for places where a smaller one has no limit.

Point contact is singular: the element maximum grows without bound as the mesh is refined, and even the unstylized part exceeds yield
there. The volume average over a ball converges (the volume method of the theory of critical distances, Taylor 2007).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array, csr_array
from scipy.spatial import cKDTree

from mechstyle.fea.elements import GAUSS_A, GAUSS_B
from mechstyle.fea.joined import joined
from mechstyle.records.mesh import Floats, TetMesh

RADIUS = 2.0
"""Of the ball, and of the surface that is averaged over elsewhere [mm]: of the order of a polymer's critical distance."""

ENOUGH = 25
"""Points in the ball, on average, from which their mean no longer depends on how many they are."""

CENTROID = np.full((1, 4), 0.25)
NEAR_CORNERS, NEAR_FACES = np.full((4, 4), GAUSS_B) + (GAUSS_A - GAUSS_B) * np.eye(4), np.full((4, 4), 7 / 24) - np.eye(4) / 6
SUB_POINTS = (CENTROID, NEAR_CORNERS, np.concatenate([NEAR_CORNERS, NEAR_FACES]))
"""Barycentric coordinates of one, four or eight points that stand for equal shares of a tetrahedron: the Gauss points, and four
between them, so that nothing is extrapolated, shapes [1, 4], [4, 4] and [8, 4]."""


class BallAverage:
    """Volume average over what lies within `radius` [mm] and is joined to the centre there, as a sparse operator.

    What lies across a gap is left out (`fea/joined.py`): a wall beside a slot bears what it bears, whatever the next one does.
    A tetrahedron is taken as one point, or as four or eight, between which the stress is linear, where the mesh is so coarse that
    the ball would hold fewer than ENOUGH.
    Neighbours are those of the mesh given here, the undeformed one; weights are the volumes of the mesh averaged on, so
    that the operator serves every morph of that mesh.
    """

    def __init__(self, tets: TetMesh, radius: float = RADIUS) -> None:
        in_ball = 4.0 / 3.0 * math.pi * radius**3 * len(tets.tets) / float(tets.volumes.sum())
        self.radius = radius
        self.coordinates = next((points for points in SUB_POINTS if len(points) * in_ball >= ENOUGH), SUB_POINTS[-1])
        points = self.points(tets).reshape(-1, 3)
        pairs = cKDTree(points).query_pairs(radius, output_type="ndarray").astype(np.int32)
        itself = np.arange(len(points), dtype=np.int32)
        rows = np.concatenate([pairs[:, 0], pairs[:, 1], itself])
        columns = np.concatenate([pairs[:, 1], pairs[:, 0], itself])
        near = coo_array((np.ones(len(rows), dtype=np.float32), (rows, columns)), shape=(len(points),) * 2).tocsr()
        self._near: csr_array = joined(near, tets, self.points(tets), radius)

    def points(self, tets: TetMesh) -> Floats:
        """The points averages are taken at [mm], shape [tet_count, sub_points, 3]."""
        return np.einsum("sk,nkx->nsx", self.coordinates, tets.vertices[tets.tets])

    def __call__(self, tets: TetMesh, values: ArrayLike) -> Floats:
        """Averages of `values` at the Gauss points, shape [tet_count, points], over `tets`, a morph of the mesh the operator was made for.

        Returns:
            Averages around the sub-points, shape [tet_count, sub_points].
        """
        at_points = np.asarray(values, dtype=np.float64) @ self._from_gauss(np.shape(values)[1]).T
        weights = np.repeat(tets.volumes, len(self.coordinates))
        return np.asarray((self._near @ (weights * at_points.ravel())) / (self._near @ weights)).reshape(at_points.shape)

    def _from_gauss(self, points: int) -> Floats:
        """Linear interpolation from Gauss points to sub-points, shape [sub_points, points]."""
        if points == 1:
            return np.ones((len(self.coordinates), 1))
        return np.asarray(self.coordinates @ np.linalg.inv(NEAR_CORNERS))


def largest_around(tets: TetMesh, von_mises: ArrayLike, average: BallAverage) -> Floats:
    """Largest average in the tetrahedra around each vertex [MPa], shape [vertex_count]; a maximum, so that no average is lost."""
    averaged = average(tets, von_mises).max(axis=1)
    field = np.zeros(len(tets.vertices))
    np.maximum.at(field, tets.tets.ravel(), np.repeat(averaged, 4))
    return field
