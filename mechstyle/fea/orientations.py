"""Landings of a part: sets of floor normals in its frame, each with its name and its way to land.

Number 0 of every set is flat, the part as it stands. All belong to the part: a file that is turned about z or mirrored gets the same.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull

from mechstyle.errors import BadInput, unknown
from mechstyle.fea.bounding_box import box_around, named, places
from mechstyle.fea.footprint import Touchdown, own_frame, touchdowns
from mechstyle.records import POSES
from mechstyle.records.mesh import Floats, SurfaceMesh, frozen_array
from mechstyle.records.simulation import Way

UP = (0.0, 0.0, 1.0)

FLAT = "flat"
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

AZIMUTHS = ("right", "right back", "back", "left back", "left", "left front", "front", "right front")
"""Names of azimuths from +x towards +y, every 45°: the front is at -y."""


@dataclass(frozen=True, eq=False)
class Orientations:
    """Landings, flat first.

    Attributes:
        normals: Floor normals in the frame of the part, unit vectors out of the floor, shape [landings, 3].
        names: What each is called, no two alike.
        ways: How the part lands in each.
    """

    normals: Floats
    names: tuple[str, ...]
    ways: tuple[Way, ...]

    def __post_init__(self) -> None:
        """Freeze the array; lengths that differ, or names that are alike, raise ValueError."""
        object.__setattr__(self, "normals", frozen_array(self.normals, np.float64, (len(self.names), 3), "normals"))
        if len(self.ways) != len(self.names) or len(set(self.names)) != len(self.names):
            raise ValueError("each landing has one way and a name of its own")


def landings(surface: SurfaceMesh, poses: str, count: int, *, nearly_flat: bool) -> Orientations:
    """Landings of a test: flat, those that are nearly flat, then the others; none twice.

    Args:
        surface: The part without relief, closed.
        poses: One of `records.POSES`.
        count: Landings without those that are nearly flat; of resting poses and poses of a box at most so many.
        nearly_flat: Whether it lands on each corner and side of what it stands on, too.

    Raises:
        BadInput: Unknown poses, or a count below 1.
    """
    frame = own_frame(surface) if poses == "fibonacci" and count > 1 else None
    others = orientation_set(poses, count, surface.vertices, surface.centre_of_mass, frame)
    if not nearly_flat:
        return others
    first = nearly_flat_of(surface)
    new = np.flatnonzero((others.normals @ first.normals.T).max(axis=1) < SAME_LANDING)
    return Orientations(
        np.concatenate([first.normals, others.normals[new]]),
        (*first.names, *(others.names[number] for number in new)),
        (*first.ways, *(others.ways[number] for number in new)),
    )


def nearly_flat_of(surface: SurfaceMesh) -> Orientations:
    """Flat, then tilted by TILT onto each side and corner of what the part stands on, by azimuth; a round base evenly onto six azimuths.

    A landing is named by what goes down and touches first, seen from above: the front is at -y, the right at +x.
    """
    found = touchdowns(surface)
    azimuths, tilt = np.radians([one.azimuth for one in found]), math.radians(TILT)
    across = -math.sin(tilt) * np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
    return _with_flat(np.column_stack([across, np.full(len(found), math.cos(tilt))]), _called(found), "nearly flat")


def orientation_set(poses: str, count: int, points: ArrayLike, centre: ArrayLike, frame: ArrayLike | None = None) -> Orientations:
    """Flat, then the other landings of a kind of poses.

    Args:
        poses: One of `records.POSES`.
        count: Landings, the flat one included; of resting poses and poses of a box at most so many.
        points: Points of the part whose convex hull is the part's [mm], shape [n, 3].
        centre: Its centre of mass [mm], shape [3].
        frame: Axes, as rows, in which directions are spread, shape [3, 3]; None for those of the file.

    Raises:
        BadInput: Unknown poses, or a count below 1.
    """
    if poses not in POSES:
        raise unknown("poses", poses, POSES)
    if count < 1:
        raise BadInput(f"a drop test needs at least one orientation, not {count}")
    if poses == "resting":
        return resting(points, centre, count)
    if poses == "fibonacci":
        return fibonacci(count, frame)
    return boxed(poses, points, centre, count)


def directions(count: int) -> Floats:
    """The normals of `fibonacci`, shape [count, 3]."""
    return orientation_set("fibonacci", count, (), ()).normals


def fibonacci(count: int, frame: ArrayLike | None = None) -> Orientations:
    """Flat, then a Fibonacci sphere (Swinbank and Purser 2006) less the cap around upright; args as for `orientation_set`."""
    others = count - 1
    k = np.arange(others)
    top = math.cos(math.radians(UPRIGHT_CAP))
    z = top - (top + 1.0) * (k + 0.5) / max(others, 1)
    turn = math.pi * (3.0 - math.sqrt(5.0)) * k
    radius = np.sqrt(1.0 - z**2)
    spread = np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)
    return _with_flat(spread if frame is None else spread @ np.asarray(frame), _numbered("direction", others))


def resting(points: ArrayLike, centre: ArrayLike, count: int) -> Orientations:
    """Flat, then the poses the part comes to rest in, the most likely first; args as for `orientation_set`.

    Poses are merged until `count` landings stand for nearly all.
    """
    if count == 1:
        return _with_flat(np.empty((0, 3)), ())
    normals, chances = stable_poses(points, centre)
    upright = normals @ UP > math.cos(math.radians(NEARLY_EQUAL))
    others, left = normals[~upright], chances[~upright]
    angle = NEARLY_EQUAL
    kept, weights = _merged(others, left, angle)
    while weights[: count - 1].sum() < COVERED * left.sum():
        angle *= 1.5
        kept, weights = _merged(others, left, angle)
    return _with_flat(kept[: count - 1], _numbered("resting pose", len(kept[: count - 1])))


def boxed(poses: str, points: ArrayLike, centre: ArrayLike, count: int) -> Orientations:
    """Flat, then on faces, edges and corners of the smallest box around the part, its centre of mass above them.

    A pose of the box that is flat is left out; args as for `orientation_set`, poses as `bounding_box.places` explains.
    """
    box = box_around(points)
    found = {named(place): box.landing(place, centre) for place in places(poses, box)}
    others = {name: normal for name, normal in found.items() if normal @ UP < SAME_LANDING}
    return _with_flat(np.array(list(others.values()))[: count - 1], list(others)[: count - 1])


def stable_poses(points: ArrayLike, centre: ArrayLike) -> tuple[Floats, Floats]:
    """Floor normals of the poses a body rests in, shape [poses, 3], and their probabilities, shape [poses] (Goldberg et al. 1999).

    A body in a random orientation first lands on a facet of its convex hull with the probability of the solid angle that the facet fills
    seen from the centre of mass. Where that is not above the facet the body tips over an edge, always lower, until it is.
    trimesh computes the same, but copies the hull once for each pose: minutes for a round part.
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


def _with_flat(normals: Floats, names: Sequence[str], way: Way = "any landing") -> Orientations:
    """Landings of one way after the flat one."""
    return Orientations(np.concatenate([[UP], normals]), (FLAT, *names), ("flat", *([way] * len(names))))


def _called(found: Sequence[Touchdown]) -> list[str]:
    """Names of tilts by what goes down first, with its azimuth where another has the same."""
    names = []
    for one in found:
        side = AZIMUTHS[math.floor((one.azimuth + 22.51) / 45.0) % 8]
        names.append(f"tilted {TILT:g}° onto the {side} {one.kind}" if one.kind else f"tilted {TILT:g}° to the {side}")
    several = Counter(names)
    return [f"{name} ({one.azimuth:.0f}°)" if several[name] > 1 else name for name, one in zip(names, found, strict=True)]


def _numbered(what: str, others: int) -> list[str]:
    """Names of all but number 0, by their numbers."""
    return [f"{what} {number + 1}" for number in range(others)]
