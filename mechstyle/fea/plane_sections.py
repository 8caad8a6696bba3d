"""Stress at a spot from the stress around it, where the surface curves away from the spot as that of a round bar does.

Plane sections remain plane, so bending stress is linear in space. Along a flat face a mean loses nothing of it; around a round bar the mean
lies deeper than the spot, and of a pin 2 mm across it sees 0.8. What it misses is the slope of the stress along the normal of the spot
times that depth. The slope is taken in space, by least squares over the patch, so that a slope along the surface, which the mean sees
rightly, is not mistaken for one across it where the normal of a coarse mesh is a few degrees off.

It only ever raises the mean, and by no more than

* to the stress at the spot itself: none is invented;
* what the mean misses around a round bar of that curvature, whose stress is nought at its axis: steeper slopes belong to notches nearby,
  of which a mean is to be told (Taylor 2007), and so do roots, around which the surface lies higher;
* nothing on an edge, which turns more sharply than a bar does: the crests of bricks are such edges.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from mechstyle.fea.sides import Sides
from mechstyle.records.mesh import Floats, TetMesh

NOISE = 0.025
"""How rough the surface of a mesh may be [mm]: over much less height no slope is told from it. A bar 12 mm across is 0.08 mm high over a
patch of 2 mm, one of 40 mm 0.025."""

BAR, EDGE = 0.3, 0.4
"""Depth of the mean below its spot over the radius of curvature: a bar has 0.3 at most, with a section of eight sides, and an edge of two
planes at 28° each 0.4."""

PAIRS = np.array([[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]])
"""The six different products of two coordinates."""


class Patches:
    """The points near each spot of a body, as far as the body's own shape goes.

    Args:
        near: Which points are near which spots, ones of shape [spot_count, point_count].
        sides: Spots and points.
        tets: The body, a morph of the mesh the sides were made from: its plane sections are those that remain plane.

    Attributes:
        weights: Area each point stands for [mm²], shape [point_count].
        areas: Of the patches [mm²], shape [spot_count].
    """

    def __init__(self, near: csr_array, sides: Sides, tets: TetMesh) -> None:
        self._near, self.weights = near, sides.weights(tets)
        middle = tets.vertices.mean(axis=0)  # squares of coordinates far from the origin would leave few digits for heights
        self._points = sides.points @ (tets.vertices - middle)
        one, other = self._points[:, PAIRS[:, 0]], self._points[:, PAIRS[:, 1]]
        self.areas = np.asarray(near @ self.weights)
        self._centres = self._mean(self.weights[:, None] * self._points)
        squares = self._mean(self.weights[:, None] * one * other)
        covariance = np.empty((len(self.areas), 3, 3))
        for square, (i, j) in zip(squares.T, PAIRS, strict=True):
            covariance[:, i, j] = covariance[:, j, i] = square - self._centres[:, i] * self._centres[:, j]
        directions = sides.directions(tets)
        positions = tets.vertices[sides.vertices] - middle
        depth = np.maximum(np.einsum("nx,nx->n", directions, positions - self._centres), 0.0)
        across = np.linalg.solve(covariance + NOISE**2 * np.eye(3), directions[:, :, None])[:, :, 0]
        self._reach = np.where(self.areas[:, None] > 0.0, depth[:, None] * across, 0.0)
        self._most = _most_missed(depth, covariance, directions)

    def along(self, at_points: Floats, at_spots: Floats) -> Floats:
        """Mean stress of the patches, raised to the height of their spots where the surface curves away; of none what is at the spot.

        Args:
            at_points: Stress at the points [MPa], shape [point_count].
            at_spots: The same at the spots [MPa], shape [spot_count].

        Returns:
            Stress [MPa], shape [spot_count].
        """
        stressed = self.weights * at_points
        mean = np.divide(self._near @ stressed, self.areas, out=at_spots.copy(), where=self.areas > 0.0)
        with np.errstate(invalid="ignore"):  # the stress of a failed drop is infinite
            slopes = self._mean(stressed[:, None] * self._points) - mean[:, None] * self._centres
            missed = np.clip(np.einsum("nx,nx->n", self._reach, slopes), 0.0, self._most * mean)
            return np.asarray(np.maximum(mean, np.fmin(mean + missed, at_spots)))

    def _mean(self, weighted: Floats) -> Floats:
        """Sums over the patches of what is multiplied by the weights, shape [point_count, n], over their areas; 0 where there is none."""
        areas = self.areas[:, None]
        return np.divide(self._near @ weighted, areas, out=np.zeros((len(areas), weighted.shape[1])), where=areas > 0.0)


def _most_missed(depth: Floats, covariance: Floats, directions: Floats) -> Floats:
    """What the mean around a round bar misses of the stress at its spot, as a share of that mean; 0 on an edge; shape [spot_count].

    Of a bar of radius R whose surface lies d deeper in the mean than the spot the mean sees 1 - d/R, and d is half the mean square of the
    distance across the bar over R.

    Args:
        depth: d [mm], shape [spot_count].
        covariance: Of the points of the patches [mm²], shape [spot_count, 3, 3].
        directions: Normals of the spots, shape [spot_count, 3].
    """
    flat = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    across = np.linalg.eigvalsh(flat @ covariance @ flat)[:, 1]  # the least is nought, along the normal
    share = np.minimum(np.divide(2.0 * depth**2, across, out=np.ones_like(depth), where=across > 0.0), EDGE)
    return np.asarray(share / (1.0 - share) * np.clip((EDGE - share) / (EDGE - BAR), 0.0, 1.0))
