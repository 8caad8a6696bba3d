"""Poses of a part besides those on its base: where it comes to rest, and the faces, edges and corners of the smallest box around it.

A box is numbered as package standards do. It stands before its observer: face 1 is its top, 2 its right side, 3 its bottom, 4 its left
side, 5 the end near the observer and 6 the far end (ASTM D5276, ISTA 1A). Here the observer looks along +y, with +x to the right. An edge
is named by the two faces that meet in it, a corner by three.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull

from mechstyle.records.mesh import Floats

SIDES = {1: "top", 2: "right", 3: "bottom", 4: "left", 5: "near end", 6: "far end"}
"""Faces of a box by number."""

AXIS_OF = {2: (0, 1.0), 4: (0, -1.0), 6: (1, 1.0), 5: (1, -1.0), 1: (2, 1.0), 3: (2, -1.0)}
"""Axis of the box that a face is across, and on which side it lies."""

MOST_FRAGILE = (2, 3, 5)
"""The corner ISTA 1A drops unless a more fragile one is known."""

SMALLER = 0.99
"""A box that is turned must have less than this share of the volume of the upright one: a cup's box does not turn with its facets."""

SAME_SIDE = 1e-3
"""Facets whose normals differ by less than this lie on one side of the part."""

SIDES_TRIED = 200
"""Sides a box is tried on, the largest: a rounded part has thousands, and any box fits it alike."""


@dataclass(frozen=True, eq=False)
class BoundingBox:
    """A box around a part.

    Attributes:
        axes: Rows are its unit axes in the frame of the part: to the right, away from the observer, up; shape [3, 3].
        low: Its least coordinates along those axes [mm], shape [3].
        high: Its greatest [mm], shape [3].
    """

    axes: Floats
    low: Floats
    high: Floats

    def landing(self, faces: tuple[int, ...], centre: ArrayLike) -> Floats:
        """Unit floor normal with which the part lands on one to three faces that meet, its centre of mass [mm] above, shape [3]."""
        middle = self.axes @ np.asarray(centre, dtype=np.float64)
        arm = np.zeros(3)  # from the face, edge or corner to the centre of mass, by the shortest way
        for axis, side in (AXIS_OF[face] for face in faces):
            arm[axis] = middle[axis] - (self.high if side > 0.0 else self.low)[axis]
        normal = arm @ self.axes
        return np.asarray(normal / np.linalg.norm(normal))

    def length(self, edge: tuple[int, int]) -> float:
        """Length of the edge in which two faces meet [mm]."""
        (along,) = {0, 1, 2} - {AXIS_OF[face][0] for face in edge}
        return float(self.high[along] - self.low[along])

    def area(self, face: int) -> float:
        """Area of a face [mm²]."""
        return float(np.prod(np.delete(self.high - self.low, AXIS_OF[face][0])))


def named(faces: tuple[int, ...]) -> str:
    """Name of a pose: `face 3 (bottom)`, `edge 2-3`, `corner 2-3-5`."""
    number = "-".join(map(str, faces))
    return f"face {number} ({SIDES[faces[0]]})" if len(faces) == 1 else f"{('edge', 'corner')[len(faces) - 2]} {number}"


def places(poses: str, box: BoundingBox) -> tuple[tuple[int, ...], ...]:
    """What of a box is dropped on, in the order it is dropped: faces, edges as pairs of faces, corners as triples.

    `faces6` are the faces; `box26` faces, edges and corners (MIL-STD-810H, method 516.8); `box10` (ISTA 1A) a corner, the edges that
    radiate from it, shortest first, and the faces, smallest first, alike within a micrometre in the order of their numbers.
    """
    faces = [(face,) for face in SIDES]
    if poses == "faces6":
        return tuple(faces)
    if poses == "box10":
        radiating = sorted(combinations(MOST_FRAGILE, 2), key=lambda edge: round(box.length(edge), 3))
        return (MOST_FRAGILE, *radiating, *sorted(faces, key=lambda face: round(box.area(face[0]), 3)))
    meeting = [place for count in (2, 3) for place in combinations(SIDES, count) if len({AXIS_OF[face][0] for face in place}) == count]
    return (*faces, *meeting)


def box_around(points: ArrayLike) -> BoundingBox:
    """The smallest box with a side on a facet of the convex hull of points [mm], shape [n, 3]; the upright one if it is hardly larger.

    The smallest of all boxes has two sides that each hold an edge of the hull (O'Rourke 1985); that one of them holds a facet is what
    people mean by the box of a part, and is found by projecting the hull along each facet's normal.
    """
    points = np.asarray(points, dtype=np.float64)
    hull = ConvexHull(points)
    corners = points[hull.vertices]
    best, least = np.eye(3), SMALLER * float(np.prod(np.ptp(corners, axis=0)))
    for normal in _sides(hull.equations[:, :3], points[hull.simplices]):
        axes, volume = _flush(corners, normal)
        if volume < least * (1.0 - 1e-9):
            best, least = axes, volume
    axes = _seen(best)
    along = corners @ axes.T
    return BoundingBox(axes, along.min(axis=0), along.max(axis=0))


def _sides(normals: Floats, facets: Floats) -> Floats:
    """Normals of the largest sides, each with its opposite; normals are those of facets of corners [mm], shape [facets, 3, 3]."""
    largest = np.take_along_axis(normals, np.abs(normals).argmax(axis=1)[:, None], axis=1)
    one_way = np.round(normals * np.sign(largest) / SAME_SIDE).astype(np.int64)
    _, first, side = np.unique(one_way, axis=0, return_index=True, return_inverse=True)
    areas = np.linalg.norm(np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0]), axis=1)
    totals = np.bincount(side.ravel(), weights=areas)
    return np.asarray(normals[first[np.argsort(-totals, kind="stable")[:SIDES_TRIED]]])


def _flush(corners: Floats, normal: Floats) -> tuple[Floats, float]:
    """The smallest box with a side across a normal: its axes, shape [3, 3], and volume [mm³]."""
    least_aligned = np.eye(3)[np.abs(normal).argmin()]
    across = np.cross(normal, least_aligned)
    across /= np.linalg.norm(across)
    frame = np.stack([across, np.cross(normal, across)])
    shadow = corners @ frame.T
    rim = shadow[ConvexHull(shadow).vertices]
    edges = np.roll(rim, -1, axis=0) - rim
    along = edges / np.linalg.norm(edges, axis=1, keepdims=True)
    sideways = np.stack([-along[:, 1], along[:, 0]], axis=1)
    areas = np.ptp(rim @ along.T, axis=0) * np.ptp(rim @ sideways.T, axis=0)
    first = int(np.argmax(areas <= areas.min() * (1.0 + 1e-9)))
    return np.stack([along[first] @ frame, sideways[first] @ frame, normal]), float(areas[first] * np.ptp(corners @ normal))


def _seen(axes: Floats) -> Floats:
    """Axes of a box as its observer sees them: the one nearest to z up, of the others the one nearest to x to the right."""
    up = int(np.argmax(np.round(np.abs(axes[:, 2]), 6)))
    others = [axis for axis in range(3) if axis != up]
    right = others[int(np.argmax(np.round(np.abs(axes[others, 0]), 6)))]
    (away,) = set(others) - {right}
    ordered = axes[[right, away, up]]
    return np.asarray(ordered * [[math.copysign(1.0, ordered[axis, axis])] for axis in range(3)])


def stable_poses(points: ArrayLike, centre: ArrayLike) -> tuple[Floats, Floats]:
    """Floor normals of the poses a body rests in, shape [poses, 3], and their probabilities, shape [poses] (Goldberg et al. 1999).

    A body in a random orientation first lands on a facet of its convex hull with the probability of the solid angle that the facet fills
    seen from the centre of mass. Where that is not above the facet the body tips over an edge, always lower, until it is.
    trimesh computes the same, but copies the hull once for each pose: minutes for a round part.
    """
    hull = ConvexHull(np.asarray(points, dtype=np.float64) - np.asarray(centre, dtype=np.float64))
    outward, heights = hull.equations[:, :3], -hull.equations[:, 3]
    corners = hull.points[hull.simplices]
    inside, feet = np.empty((len(corners), 3)), outward * heights[:, None]
    for corner in range(3):  # distance of the foot from the edge opposite to each corner, positive inside
        opposite, start, end = (corners[:, (corner + shift) % 3] for shift in range(3))
        along = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
        across = opposite - start
        across -= np.einsum("ij,ij->i", across, along)[:, None] * along
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        inside[:, corner] = np.einsum("ij,ij->i", feet - start, across)
    facets = np.arange(len(corners))
    stable = inside.min(axis=1) > -1e-9 * np.ptp(hull.points, axis=0).max()
    end = np.where(stable, facets, hull.neighbors[facets, inside.argmin(axis=1)])
    for _ in range(len(facets).bit_length()):  # twice as many tips each time
        end = end[end]
    a, b, c = np.moveaxis(corners, 1, 0)
    la, lb, lc = np.linalg.norm(corners, axis=2).T
    volume = np.abs(np.einsum("ij,ij->i", a, np.cross(b, c)))
    ab, bc, ca = (np.einsum("ij,ij->i", one, other) for one, other in ((a, b), (b, c), (c, a)))
    # solid angles of triangles seen from the origin (Van Oosterom and Strackee 1983)
    angles = 2.0 * np.arctan2(volume, la * lb * lc + ab * lc + bc * la + ca * lb)
    chances = np.bincount(end, weights=angles, minlength=len(facets))
    ends = np.flatnonzero(chances)
    return -outward[ends], chances[ends] / chances.sum()


def merged(normals: Floats, chances: Floats, angle: float) -> tuple[Floats, Floats]:
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
