"""Landings of a part: sets of floor normals in its frame, each with its name and its way to land.

Number 0 of every set is flat, the part as it stands. All belong to the part: a file that is turned about z, mirrored or meshed again gets
the same. What is nearly flat follows from what the part stands on: sides are found in the extended Gaussian image of the outline (Horn
1984), which sums lengths by the direction they face, so that no vertex decides. Azimuths are angles from +x towards +y [degrees].
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull, QhullError

from mechstyle.errors import BadInput, unknown
from mechstyle.fea.poses import box_around, merged, named, places, stable_poses
from mechstyle.records import POSES
from mechstyle.records.mesh import FLOOR_TOLERANCE, Floats, SurfaceMesh, frozen_array
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
    kept, weights = merged(others, left, angle)
    while weights[: count - 1].sum() < COVERED * left.sum():
        angle *= 1.5
        kept, weights = merged(others, left, angle)
    return _with_flat(kept[: count - 1], _numbered("resting pose", len(kept[: count - 1])))


def boxed(poses: str, points: ArrayLike, centre: ArrayLike, count: int) -> Orientations:
    """Flat, then on faces, edges and corners of the smallest box around the part, its centre of mass above them.

    A pose of the box that is flat is left out; args as for `orientation_set`, poses as `poses.places` explains.
    """
    box = box_around(points)
    found = {named(place): box.landing(place, centre) for place in places(poses, box)}
    others = {name: normal for name, normal in found.items() if normal @ UP < SAME_LANDING}
    return _with_flat(np.array(list(others.values()))[: count - 1], list(others)[: count - 1])


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


CUT = 3.0 * FLOOR_TOLERANCE
"""Height above the lowest vertex at which the footprint is taken [mm]: coarse meshes of one part differ by a third of it."""

LEAST_SIDE = 0.08
"""Length of a side over the diameter of the footprint: shorter ones are chamfers and facets of rounds. A footprint that is no larger than
this share of the part is a point."""

MOST_SIDES = 6
"""A footprint of more sides is round, and lands on so many azimuths."""

ALIKE = 30.0
"""What faces the same way within this belongs to one side [degrees]."""

STRAIGHT = 10.0
"""Most of a straight side faces the same way within this; the sides beside an end are parallel within it [degrees]."""

VANISHES = 0.02
"""Share of the largest they could be below which moments are zero: two meshes of one part differ by a tenth of it."""

_MOST_FOLDS = 12  # with more lobes a part is a solid of revolution


class Touchdown(NamedTuple):
    """A place of the footprint that can go down first.

    Attributes:
        azimuth: Direction it lies in, seen from the middle [degrees].
        kind: What it is; "" for a place on a round.
    """

    azimuth: float
    kind: Literal["side", "corner", "end", ""]


def touchdowns(surface: SurfaceMesh) -> tuple[Touchdown, ...]:
    """Sides, corners and rounds of what a part stands on, by azimuth.

    A corner lies where the bisector of two neighbouring sides points, an end likewise between two that are parallel. What is rounder than
    an end has a place every 60° or less. A round base has six places, spread evenly from the first axis of the part's own frame.
    """
    outline = footprint(surface)
    sides = straight_sides(outline) if _diameter(outline) > LEAST_SIDE * surface.size else np.empty(0)
    if not 1 <= len(sides) <= MOST_SIDES:
        first = own_frame(surface)[0]
        start = math.degrees(math.atan2(first[1], first[0]))
        return _in_order([Touchdown(start + place * 360.0 / MOST_SIDES, "") for place in range(MOST_SIDES)])
    found = [Touchdown(side, "side") for side in sides]
    for side, gap in zip(sides, np.append(sides[1:], sides[0] + 360.0) - sides, strict=True):
        if gap > 180.0 + STRAIGHT:  # a round: no polygon turns so far at a corner
            count = math.ceil(gap / 60.0 - 0.01)
            found += [Touchdown(side + gap * place / count, "") for place in range(1, count)]
        else:
            found.append(Touchdown(side + 0.5 * gap, "corner" if gap < 180.0 - STRAIGHT else "end"))
    return _in_order(found)


def footprint(surface: SurfaceMesh) -> Floats:
    """Convex outline of what is at most CUT above the lowest vertex [mm], anticlockwise, shape [n, 2].

    The surface is cut at that height: the outline is the part's and does not depend on where vertices are. A line has two ends.
    """
    height = surface.vertices[:, 2] - surface.vertices[:, 2].min() - CUT
    one, other = surface.edges.T
    cut = (height[one] > 0.0) != (height[other] > 0.0)
    one, other = one[cut], other[cut]
    share = (height[one] / (height[one] - height[other]))[:, None]
    crossings = (1.0 - share) * surface.vertices[one, :2] + share * surface.vertices[other, :2]
    points = np.concatenate([surface.vertices[height <= 0.0, :2], crossings])
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:
        along = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
        return np.asarray(points[[(points @ along).argmin(), (points @ along).argmax()]])


def straight_sides(outline: Floats) -> Floats:
    """Azimuths that the sides of an outline face, ascending from 0 up to 360 [degrees]; none for a round one.

    What faces a direction is summed with a smooth weight that falls to nothing ALIKE next to it. There is a side where that is largest and
    exceeds what it is ALIKE to the left and right, by no less than LEAST_SIDE: around a round it does not.
    The outline is convex: corners [mm], anticlockwise, shape [n, 2].
    """
    edges = np.roll(outline, -1, axis=0) - outline
    lengths, facing = np.linalg.norm(edges, axis=1), np.degrees(np.arctan2(-edges[:, 0], edges[:, 1]))
    grid = np.arange(0.0, 360.0, 0.5)
    alike = _weights(facing - grid[:, None], lengths, ALIKE).sum(axis=1)
    far = round(ALIKE / 0.5)
    before, after = (np.max([np.roll(alike, sign * shift) for shift in range(1, far // 2)], axis=0) for sign in (1, -1))
    beside = 0.5 * (np.roll(alike, far) + np.roll(alike, -far))
    peaks = grid[(alike > before) & (alike >= after) & (alike - beside >= LEAST_SIDE * _diameter(outline))]
    sides = []
    for peak in peaks:  # the azimuth that most of the edges around it face
        wide = _mean_facing(peak, facing, lengths, ALIKE)
        near, all_alike = (_weights(facing - wide, lengths, width).sum() for width in (STRAIGHT, ALIKE))
        sides.append((_mean_facing(wide, facing, lengths, STRAIGHT) if near > 0.5 * all_alike else wide) % 360.0)
    return np.sort(sides)


def own_frame(surface: SurfaceMesh) -> Floats:
    """Axes of a part about the vertical by its shape, the third one up, shape [3, 3]; left-handed where the determinant is -1.

    The first moment of the surface that does not vanish points along the first axis, as with principal axes. What that leaves open, a part
    of a turn and the handedness, makes the next moments as large as they can be. What is open after that is a symmetry of the part.
    A solid of revolution has the axes of its file.
    """
    moments = _moments(surface)
    fold, leading = next(((fold, moment) for fold, moment in moments if abs(moment) > VANISHES), (1, 1.0 + 0.0j))
    turns = np.repeat((np.angle(leading) + 2.0 * math.pi * np.arange(fold)) / fold, 2)
    hands = np.tile([1.0, -1.0], fold)
    for fold, moment in moments:
        for along in (True, False):
            seen = moment * np.exp(-1j * fold * turns)
            value = seen.real if along else seen.imag * hands
            largest = value >= value.max() - VANISHES
            turns, hands = turns[largest], hands[largest]
    x, y, hand = math.cos(turns[0]), math.sin(turns[0]), hands[0]
    return np.array([[x, y, 0.0], [-hand * y, hand * x, 0.0], [0.0, 0.0, 1.0]])


def _moments(surface: SurfaceMesh) -> list[tuple[int, complex]]:
    """Moments of a surface about the vertical through its middle, over the largest they could be, each with its fold.

    Of a part that is turned by an angle, a moment turns by that angle times its fold. Some know up from down.
    """
    nodes, shares = np.polynomial.legendre.leggauss(3)  # so that polynomials up to degree 4 are integrated exactly
    u, v = (axis.ravel() for axis in np.meshgrid(0.5 + 0.5 * nodes, 0.5 + 0.5 * nodes, indexing="ij"))
    parts = np.stack([1.0 - u, u * (1.0 - v), u * v], axis=1)
    points = np.einsum("pc,fcx->fpx", parts, surface.corners).reshape(-1, 3)
    weights = np.outer(surface.face_areas / surface.face_areas.sum(), 0.5 * np.outer(shares, shares).ravel() * u).ravel()
    middle = points - (weights[:, None] * points).sum(axis=0)  # no BLAS, whose sums depend on the number of cores
    z, h = middle[:, 0] + 1.0j * middle[:, 1], middle[:, 2]
    r, depth = np.abs(z), np.abs(h)
    sums = [(2, z * z, r * r), (1, z * r * r, r**3), (1, z * h, r * depth), (2, z * z * h, r * r * depth), (1, z * h * h, r * h * h)]
    power, most = z * z, r * r
    for fold in range(3, _MOST_FOLDS + 1):
        power, most = power * z, most * r
        sums.append((fold, power, most))
    return [(fold, complex((weights * value).sum()) / max(float((weights * largest).sum()), 1e-300)) for fold, value, largest in sums]


def _in_order(found: list[Touchdown]) -> tuple[Touchdown, ...]:
    """By azimuth from 0 up to 360 [degrees], in steps of 0.01 so that what is all but 360 comes first."""
    turned = [one._replace(azimuth=float(one.azimuth % 360.0)) for one in found]
    return tuple(sorted(turned, key=lambda one: round(one.azimuth, 2) % 360.0))


def _diameter(outline: Floats) -> float:
    """Largest distance of two corners [mm]."""
    return float(np.linalg.norm(outline[:, None] - outline, axis=2).max())


def _weights(away: Floats, lengths: Floats, width: float) -> Floats:
    """Lengths of edges as far as they face a direction, none beyond a width; `away` are their angles to it [degrees]."""
    away = (away + 180.0) % 360.0 - 180.0
    return np.where(np.abs(away) < width, lengths * np.cos(0.5 * math.pi * away / width) ** 2, 0.0)


def _mean_facing(azimuth: float, facing: Floats, lengths: Floats, width: float) -> float:
    """Azimuth that edges within a width around it face on average [degrees] (mean shift, Fukunaga and Hostetler 1975)."""
    for _ in range(200):
        away = (facing - azimuth + 180.0) % 360.0 - 180.0
        weights = _weights(away, lengths, width)
        azimuth += float((weights * away).sum() / weights.sum())
    return azimuth
