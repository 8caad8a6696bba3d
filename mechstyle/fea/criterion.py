"""The criterion: stress averaged over a fixed physical radius, and its measures.

Point contact is singular: the element maximum grows without bound as the mesh is refined, and even the unstylized part
exceeds yield there. The volume average over a ball of fixed radius converges (the volume method of the theory of critical
distances, Taylor 2007), so it is what drives the mask and what decides.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array, csr_array
from scipy.spatial import cKDTree

from mechstyle.fea.elements import GAUSS_A, GAUSS_B
from mechstyle.records import Measures
from mechstyle.records.mesh import Floats, TetMesh

ENOUGH = 8
"""Tetrahedra in the ball, on average, from which their means are points enough to average over."""

NEAR_CORNERS, NEAR_FACES = np.full((4, 4), GAUSS_B) + (GAUSS_A - GAUSS_B) * np.eye(4), np.full((4, 4), 7 / 24) - np.eye(4) / 6
SUB_POINTS = np.concatenate([NEAR_CORNERS, NEAR_FACES])
"""Barycentric coordinates of eight points that stand for an eighth of a tetrahedron each: the Gauss points and four between them, so
that nothing is extrapolated, shape [8, 4]."""


class BallAverage:
    """Volume average over what lies within `radius` [mm], as a sparse operator.

    A tetrahedron is taken as eight points, between which the stress is linear, or, where the mesh is fine, as one.
    Neighbours are those of the mesh given here, the undeformed one; weights are the volumes of the mesh averaged on, so
    that the operator serves every morph of that mesh.
    """

    def __init__(self, tets: TetMesh, radius: float = 2.0) -> None:
        in_ball = 4.0 / 3.0 * math.pi * radius**3 * len(tets.tets) / float(tets.volumes.sum())
        self.radius = radius
        self.coordinates = SUB_POINTS if in_ball < ENOUGH else np.full((1, 4), 0.25)
        points = self.points(tets).reshape(-1, 3)
        pairs = cKDTree(points).query_pairs(radius, output_type="ndarray").astype(np.int32)
        itself = np.arange(len(points), dtype=np.int32)
        rows = np.concatenate([pairs[:, 0], pairs[:, 1], itself])
        columns = np.concatenate([pairs[:, 1], pairs[:, 0], itself])
        self._near: csr_array = coo_array((np.ones(len(rows), dtype=np.float32), (rows, columns)), shape=(len(points),) * 2).tocsr()

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


def robust_field(tets: TetMesh, von_mises: ArrayLike, average: BallAverage) -> Floats:
    """Largest average in the tetrahedra around each vertex [MPa], shape [vertex_count].

    The field that drives the mask and the verdict that decides must be the same field, or the mask sleeps while the
    verdict fails; hence the maximum, not another mean. Its own maximum is `Measures.peak`.
    """
    averaged = average(tets, von_mises).max(axis=1)
    field = np.zeros(len(tets.vertices))
    np.maximum.at(field, tets.tets.ravel(), np.repeat(averaged, 4))
    return field


def exceedance(fields: ArrayLike, weights: ArrayLike, allowable: float) -> Floats:
    """Probability that a random drop takes the stress beyond what is allowed, place by place (Langlois et al. 2016).

    Args:
        fields: Stress in each orientation [MPa], shape [orientations, ...].
        weights: Probability of each orientation, shape [orientations].
        allowable: What the stress may at most be [MPa].

    Returns:
        Probabilities, shape [...].
    """
    beyond = np.asarray(fields, dtype=np.float64) > allowable
    return np.asarray(np.einsum("o,o...->...", np.asarray(weights), beyond.astype(np.float64)))


def percentile(values: ArrayLike, weights: ArrayLike, share: float) -> float:
    """Value below which the given share of the weight lies, linear between the values' cumulative weights."""
    values, weights = np.asarray(values, dtype=np.float64), np.asarray(weights, dtype=np.float64)
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order])
    return float(np.interp(share * below[-1], below, values[order]))


def measures(tets: TetMesh, von_mises: ArrayLike, average: BallAverage) -> Measures:
    """Peak average, volume-weighted percentiles and literal maximum of one stress field [MPa], shape [tet_count, points]."""
    stress = np.asarray(von_mises, dtype=np.float64)
    weights = np.repeat(tets.volumes, stress.shape[1])
    averaged = average(tets, stress)
    highest = np.unravel_index(np.argmax(averaged), averaged.shape)
    x, y, z = average.points(tets)[highest]
    return Measures(
        peak=float(averaged[highest]),
        p999=percentile(stress.ravel(), weights, 0.999),
        p99=percentile(stress.ravel(), weights, 0.99),
        maximum=float(stress.max()),
        where=(float(x), float(y), float(z)),
        volume=float(tets.volumes.sum()),
    )
