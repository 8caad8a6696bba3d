"""Landing orientations: sets of floor normals in the frame of the part, each with the probability that a drop lands so.

Number 0 of every set is the part as it stands.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull

from mechstyle.errors import BadInput, unknown
from mechstyle.records import POSES
from mechstyle.records.mesh import Floats, frozen_array

UP = (0.0, 0.0, 1.0)

UPRIGHT_CAP = 20.0
"""Directions this close to upright are left to the upright one [degrees]: nearly the same test."""

TILT = 3.0
"""What a hand or an uneven floor adds to a flat landing [degrees]."""

NEARLY_EQUAL = 5.0
"""Resting poses this close to each other are one [degrees]: a rounded side is many facets and one way to lie."""

COVERED = 0.95
"""Share of all landings that the resting poses dropped must stand for."""


@dataclass(frozen=True, eq=False)
class Orientations:
    """Ways to land.

    Attributes:
        normals: Floor normals in the frame of the part, unit vectors out of the floor, shape [orientations, 3].
        weights: Probability of each, adding up to 1, shape [orientations].
    """

    normals: Floats
    weights: Floats

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "normals", frozen_array(self.normals, np.float64, (None, 3), "normals"))
        object.__setattr__(self, "weights", frozen_array(self.weights, np.float64, (len(self.normals),), "weights"))


def orientation_set(poses: str, count: int, points: ArrayLike, centre: ArrayLike) -> Orientations:
    """The drops of a test.

    Args:
        poses: One of `records.POSES`.
        count: Drops; of resting poses at most so many.
        points: Points of the part whose convex hull is the part's [mm], shape [n, 3].
        centre: Its centre of mass [mm], shape [3].

    Raises:
        BadInput: Unknown poses, or a count below 1.
    """
    if poses not in POSES:
        raise unknown("poses", poses, POSES)
    if poses == "resting":
        return resting(points, centre, count)
    return tilted(count) if poses == "tilts" else fibonacci(count)


def directions(count: int) -> Floats:
    """The normals of `fibonacci`, shape [count, 3]."""
    return fibonacci(count).normals


def fibonacci(count: int) -> Orientations:
    """Upright, then directions spread over the sphere: a part that tumbles, every direction as likely as any other.

    The others are a Fibonacci sphere (Swinbank and Purser 2006) less the cap around upright, and share the rest of the sphere equally.
    """
    others = _at_least_one(count) - 1
    k = np.arange(others)
    top = math.cos(math.radians(UPRIGHT_CAP))
    z = top - (top + 1.0) * (k + 0.5) / max(others, 1)
    turn = math.pi * (3.0 - math.sqrt(5.0)) * k
    radius = np.sqrt(1.0 - z**2)
    spread = np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)
    cap = 0.5 * (1.0 - top)  # share of the sphere
    return _with_upright(spread, cap, np.full(others, (1.0 - cap) / max(others, 1)))


def tilted(count: int, angle: float = TILT) -> Orientations:
    """Upright, then tilted a little to all sides, all equally likely: a part that lands as placed, as flat as things land.

    Args:
        count: Drops, the upright one included.
        angle: Tilt [degrees].
    """
    turn = 2.0 * math.pi * np.arange(_at_least_one(count) - 1) / max(count - 1, 1)
    tilt = math.radians(angle)
    sides = np.stack([math.sin(tilt) * np.cos(turn), math.sin(tilt) * np.sin(turn), np.full(count - 1, math.cos(tilt))], axis=1)
    return _with_upright(sides, 1.0, np.ones(count - 1))


def resting(points: ArrayLike, centre: ArrayLike, count: int) -> Orientations:
    """Upright, then the poses the part comes to rest in, the most likely first, each as likely as it is to end there.

    Upright weighs nothing for a part that does not stay upright. Poses are merged until `count` drops stand for nearly all landings.

    Args:
        points: As for `orientation_set`.
        centre: As for `orientation_set`.
        count: Most drops, the upright one included.
    """
    if _at_least_one(count) == 1:
        return _with_upright(np.empty((0, 3)), 1.0, np.empty(0))
    normals, chances = stable_poses(points, centre)
    upright = normals @ UP > math.cos(math.radians(NEARLY_EQUAL))
    others, left = normals[~upright], chances[~upright]
    angle = NEARLY_EQUAL
    kept, weights = _merged(others, left, angle)
    while weights[: count - 1].sum() < COVERED * left.sum():
        angle *= 1.5
        kept, weights = _merged(others, left, angle)
    return _with_upright(kept[: count - 1], float(chances[upright].sum()), weights[: count - 1])


def stable_poses(points: ArrayLike, centre: ArrayLike) -> tuple[Floats, Floats]:
    """Facets of the convex hull a body rests on, and how likely it ends there (Goldberg et al. 1999).

    A body in a random orientation first lands on the facet above which its centre of mass is, with the probability of the solid
    angle that facet fills seen from there. Where the centre is not above the facet it tips over an edge, always lower, and comes
    to rest on a facet that carries it. trimesh computes the same, but copies the hull once for each pose: minutes for a round part.

    Args:
        points: As for `orientation_set`.
        centre: As for `orientation_set`.

    Returns:
        Floor normals, shape [poses, 3], and probabilities that add up to 1, shape [poses].
    """
    hull = ConvexHull(np.asarray(points, dtype=np.float64) - np.asarray(centre, dtype=np.float64))
    outward, heights = hull.equations[:, :3], -hull.equations[:, 3]
    corners = hull.points[hull.simplices]
    inside = _distances_inside(corners, outward * heights[:, None])
    facets = np.arange(len(corners))
    stable = inside.min(axis=1) > -1e-9 * np.ptp(hull.points, axis=0).max()
    end = np.where(stable, facets, hull.neighbors[facets, inside.argmin(axis=1)])
    for _ in range(len(facets).bit_length()):  # twice as many tips each time
        end = end[end]
    chances = np.bincount(end, weights=_solid_angles(corners), minlength=len(facets))
    ends = np.flatnonzero(chances)
    return -outward[ends], chances[ends] / chances.sum()


def _distances_inside(corners: Floats, feet: Floats) -> Floats:
    """Distance of points in the planes of triangles from the edges opposite to corners 0, 1 and 2, positive inside [mm], shape [n, 3]."""
    distances = np.empty((len(corners), 3))
    for corner in range(3):
        opposite, start, end = (corners[:, (corner + shift) % 3] for shift in range(3))
        along = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
        across = opposite - start
        across -= np.einsum("ij,ij->i", across, along)[:, None] * along
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        distances[:, corner] = np.einsum("ij,ij->i", feet - start, across)
    return distances


def _solid_angles(corners: Floats) -> Floats:
    """Solid angles of triangles seen from the origin (Van Oosterom and Strackee 1983), shape [n]."""
    a, b, c = np.moveaxis(corners, 1, 0)
    la, lb, lc = np.linalg.norm(corners, axis=2).T
    volume = np.abs(np.einsum("ij,ij->i", a, np.cross(b, c)))
    ab, bc, ca = (np.einsum("ij,ij->i", one, other) for one, other in ((a, b), (b, c), (c, a)))
    return 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)


def _merged(normals: Floats, chances: Floats, angle: float) -> tuple[Floats, Floats]:
    """Directions within an angle [degrees] of a likelier one counted with it, the most likely first."""
    left, near = np.ones(len(normals), dtype=bool), math.cos(math.radians(min(angle, 180.0)))
    kept, weights = [], []
    for index in np.argsort(-chances, kind="stable"):
        if left[index]:
            alike = left & (normals @ normals[index] >= near - 1e-12)
            left &= ~alike
            kept.append(normals[index])
            weights.append(chances[alike].sum())
    order = np.argsort(-np.array(weights), kind="stable")
    return np.array(kept).reshape(-1, 3)[order], np.array(weights)[order]


def _with_upright(normals: Floats, upright: float, weights: Floats) -> Orientations:
    """Directions and weights after those of upright, the weights made to add up to 1."""
    shares = np.concatenate([[upright], weights])
    return Orientations(np.concatenate([[UP], normals]), shares / shares.sum())


def _at_least_one(count: int) -> int:
    if count < 1:
        raise BadInput(f"a drop test needs at least one orientation, not {count}")
    return count
