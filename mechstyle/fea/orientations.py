"""Landing orientations: sets of floor normals in the frame of the part, each with its name and its share of all landings.

Number 0 of every set is the part as it stands.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull

from mechstyle.errors import BadInput, unknown
from mechstyle.fea.bounding_box import box_around, named, places
from mechstyle.records import POSES
from mechstyle.records.mesh import Floats, frozen_array

UP = (0.0, 0.0, 1.0)

AS_PLACED = "as placed"
"""Name of number 0."""

UPRIGHT_CAP = 20.0
"""Directions this close to upright are left to the upright one [degrees]: nearly the same test."""

TILT = 3.0
"""What a hand or an uneven floor adds to a flat landing [degrees]."""

NEARLY_EQUAL = 5.0
"""Resting poses this close to each other are one [degrees]: a rounded side is many facets and one way to lie."""

COVERED = 0.95
"""Share of all landings that the resting poses dropped must stand for."""

SAME_LANDING = math.cos(1e-4)
"""Cosine of the angle up to which two landings are one: 10 µm across a part of 100 mm."""


@dataclass(frozen=True, eq=False)
class Orientations:
    """Ways to land.

    Attributes:
        normals: Floor normals in the frame of the part, unit vectors out of the floor, shape [orientations, 3].
        weights: Share of each, adding up to 1, shape [orientations]: its probability in poses that are a sample of random drops
            (`records.RANDOM_POSES`), else all alike.
        names: What each is called, no two alike.
    """

    normals: Floats
    weights: Floats
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        """Freeze the arrays."""
        object.__setattr__(self, "normals", frozen_array(self.normals, np.float64, (None, 3), "normals"))
        object.__setattr__(self, "weights", frozen_array(self.weights, np.float64, (len(self.normals),), "weights"))


def orientation_set(poses: str, count: int, points: ArrayLike, centre: ArrayLike) -> Orientations:
    """The drops of a test.

    Args:
        poses: One of `records.POSES`.
        count: Drops; of resting poses and poses of a box at most so many.
        points: Points of the part whose convex hull is the part's [mm], shape [n, 3].
        centre: Its centre of mass [mm], shape [3].

    Raises:
        BadInput: Unknown poses, or a count below 1.
    """
    if poses not in POSES:
        raise unknown("poses", poses, POSES)
    if poses == "resting":
        return resting(points, centre, count)
    if poses in ("tilts", "fibonacci"):
        return tilted(count) if poses == "tilts" else fibonacci(count)
    return boxed(poses, points, centre, count)


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
    return _with_upright(spread, cap, np.full(others, (1.0 - cap) / max(others, 1)), _numbered("direction", others))


def tilted(count: int, angle: float = TILT) -> Orientations:
    """Upright, then tilted a little to all sides, all of one weight: a part that lands as placed, as flat as things land.

    A tilt is named by the side that goes down and touches first; angles are from +x towards +y.

    Args:
        count: Drops, the upright one included.
        angle: Tilt [degrees].
    """
    turn = 2.0 * math.pi * np.arange(_at_least_one(count) - 1) / max(count - 1, 1)
    tilt = math.radians(angle)
    sides = np.stack([math.sin(tilt) * np.cos(turn), math.sin(tilt) * np.sin(turn), np.full(count - 1, math.cos(tilt))], axis=1)
    names = [f"tilted {angle:g}° towards {_side(round(math.degrees(side) + 180.0, 1) % 360.0)}" for side in turn]
    return _with_upright(sides, 1.0, np.ones(count - 1), names)


def nearly(ways: Orientations, tilts: int) -> Orientations:
    """Ways to land with some tilted by TILT after number 0, which shares its weight with them: exactly flat is nothing that happens.

    Args:
        ways: Number 0 is upright.
        tilts: How many; 0 leaves the ways as they are.
    """
    if tilts == 0:
        return ways
    flat = tilted(tilts + 1)
    others = [number for number, name in enumerate(ways.names) if number and name not in flat.names]
    weights = np.concatenate([np.full(tilts + 1, ways.weights[0] / (tilts + 1)), ways.weights[others]])
    return Orientations(
        np.concatenate([flat.normals, ways.normals[others]]),
        weights / weights.sum(),
        (ways.names[0], *flat.names[1:], *(ways.names[number] for number in others)),
    )


def resting(points: ArrayLike, centre: ArrayLike, count: int) -> Orientations:
    """Upright, then the poses the part comes to rest in, the most likely first, each as likely as it is to end there.

    Upright weighs nothing for a part that does not stay upright. Poses are merged until `count` drops stand for nearly all landings.

    Args:
        points: As for `orientation_set`.
        centre: As for `orientation_set`.
        count: Most drops, the upright one included.
    """
    if _at_least_one(count) == 1:
        return _with_upright(np.empty((0, 3)), 1.0, np.empty(0), ())
    normals, chances = stable_poses(points, centre)
    upright = normals @ UP > math.cos(math.radians(NEARLY_EQUAL))
    others, left = normals[~upright], chances[~upright]
    angle = NEARLY_EQUAL
    kept, weights = _merged(others, left, angle)
    while weights[: count - 1].sum() < COVERED * left.sum():
        angle *= 1.5
        kept, weights = _merged(others, left, angle)
    names = _numbered("resting pose", len(kept[: count - 1]))
    return _with_upright(kept[: count - 1], float(chances[upright].sum()), weights[: count - 1], names)


def boxed(poses: str, points: ArrayLike, centre: ArrayLike, count: int) -> Orientations:
    """Upright, then on faces, edges and corners of the smallest box around the part, its centre of mass above them, all of one weight.

    A pose of the box that is the upright one is not dropped twice.

    Args:
        poses: `box26`, `box10` or `faces6`, as `bounding_box.places` explains.
        points: As for `orientation_set`.
        centre: As for `orientation_set`.
        count: Most drops, the upright one included.
    """
    _at_least_one(count)
    box = box_around(points)
    landings = {named(place): box.landing(place, centre) for place in places(poses, box)}
    upright = [name for name, normal in landings.items() if normal @ UP >= SAME_LANDING]
    others = {name: normal for name, normal in landings.items() if name not in upright}
    names, normals = list(others)[: count - 1], np.array(list(others.values()))[: count - 1]
    return _with_upright(normals, 1.0, np.ones(len(normals)), names, as_placed=", ".join((AS_PLACED, *upright)))


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


def _with_upright(normals: Floats, upright: float, weights: Floats, names: Sequence[str], as_placed: str = AS_PLACED) -> Orientations:
    """Directions, weights and names after those of upright, the weights made to add up to 1."""
    shares = np.concatenate([[upright], weights])
    return Orientations(np.concatenate([[UP], normals]), shares / shares.sum(), (as_placed, *names))


def _numbered(what: str, others: int) -> list[str]:
    """Names of all but number 0, by their numbers."""
    return [f"{what} {number + 1}" for number in range(others)]


def _side(degrees: float) -> str:
    """A horizontal direction by the axis it follows, or by its angle from +x."""
    return {0.0: "+x", 90.0: "+y", 180.0: "-x", 270.0: "-y"}.get(degrees, f"{degrees:g}° from +x")


def _at_least_one(count: int) -> int:
    if count < 1:
        raise BadInput(f"a drop test needs at least one orientation, not {count}")
    return count
