"""Shapes the models are made of: skins over rings, extrusions with rounded edges, strokes; lengths in mm, angles in degrees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import manifold3d as m3
import numpy as np
from manifold3d import CrossSection, Manifold
from numpy.typing import ArrayLike, NDArray

from mechstyle.errors import BadInput
from mechstyle.records.mesh import Floats, SurfaceMesh

Level = tuple[float, float]  # height and inset of an outline [mm]

FOOT = 0.8  # chamfer under a standing model [mm]: a printed first layer spreads by about as much
SAGITTA = 0.02  # how far a chord may lie inside the arc it stands for [mm]


def within(**given: tuple[float, float, float]) -> None:
    """Refuse lengths [mm], angles or counts that lie outside their range, each given as (value, low, high)."""
    for name, (value, low, high) in given.items():
        if not low <= value <= high:
            raise BadInput(f"{name.replace('_', ' ')} is {value:g}, but must lie in {low:g} to {high:g}")


def count(name: str, value: float, low: int, high: int) -> int:
    """A whole number in a range; BadInput for anything else."""
    within(**{name: (value, low, high)})
    if value != int(value):
        raise BadInput(f"{name} is {value:g}, but must be a whole number")
    return int(value)


def standing(body: Manifold) -> SurfaceMesh:
    """The surface of a body, centred over the origin and standing on z = 0; BadInput unless it is one closed body."""
    if body.status() != m3.Error.NoError or body.is_empty() or len(body.decompose()) != 1:
        raise BadInput("these measures do not give one solid body: parts of the model overlap or fall apart; go back towards the defaults")
    low_x, low_y, low_z, high_x, high_y, _ = body.bounding_box()
    mesh = body.translate((-(low_x + high_x) / 2, -(low_y + high_y) / 2, -low_z)).to_mesh64()
    return SurfaceMesh(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts))


def segments(radius: float) -> int:
    """Sides of a polygon that stays within `SAGITTA` of a circle, a multiple of 8, at most 240."""
    sides = math.pi / math.acos(1.0 - min(SAGITTA / max(radius, 1e-6), 0.3))
    return int(min(8 * math.ceil(sides / 8), 240))


def disc(radius: float) -> CrossSection:
    """A circle around the origin."""
    return CrossSection.circle(radius, segments(radius))


def box(width: float, depth: float, corner: float) -> CrossSection:
    """A rectangle around the origin with rounded corners."""
    core = CrossSection.square((width - 2 * corner, depth - 2 * corner), center=True)
    return core.offset(corner, m3.JoinType.Round, circular_segments=segments(corner))


def stroke(points: ArrayLike, thickness: float) -> CrossSection:
    """A line of constant thickness with round ends and joints through points [mm], shape [n, 2]."""
    spots = np.asarray(points, dtype=np.float64)
    dot = disc(thickness / 2)
    dots = [dot.translate((float(x), float(y))) for x, y in spots]
    return CrossSection.batch_boolean([CrossSection.batch_hull([a, b]) for a, b in pairwise(dots)], m3.OpType.Add)


def softened(section: CrossSection, convex: float, concave: float) -> CrossSection:
    """The section with outer corners rounded to radius `convex` and inner ones filled to radius `concave`."""
    closed = offset(offset(section, concave), -concave)
    return offset(offset(closed, -convex), convex)


def offset(section: CrossSection, distance: float) -> CrossSection:
    """The section grown by a distance, or shrunk by a negative one, with round corners."""
    return section.offset(distance, m3.JoinType.Round, circular_segments=segments(abs(distance)))


def polygon(points: ArrayLike) -> CrossSection:
    """The area inside a closed line, shape [n, 2]."""
    return CrossSection([np.asarray(points, dtype=np.float64)], m3.FillRule.NonZero)


def round_edge(radius: float, steps: int = 6) -> list[Level]:
    """Levels of a quarter round, from (0, 0) at the wall to (radius, radius) at the top face, relative to where the wall ends."""
    turn = np.linspace(0.0, math.pi / 2, steps + 1)
    return [(radius * math.sin(t), radius * (1.0 - math.cos(t))) for t in turn]


def lofted(section: CrossSection, levels: Sequence[Level]) -> Manifold:
    """A solid whose outline at each height is the section moved inwards by an inset (outwards if negative).

    Corners of the section must be rounder than the insets are deep (see `softened`); every contour keeps its points, so that
    levels join without slivers.
    """
    insets = [inset for _, inset in levels]
    contours = [_moveable(np.asarray(contour, dtype=np.float64), insets) for contour in section.simplify(1e-3).to_polygons()]
    flat = np.concatenate(contours)
    moves = np.concatenate([_mitres(contour) for contour in contours])
    layers = [np.column_stack([flat - inset * moves, np.full(len(flat), z)]) for z, inset in levels]
    count, last = len(flat), len(flat) * (len(levels) - 1)
    cap = np.asarray(m3.triangulate([contour.tolist() for contour in _split(layers[0][:, :2], contours)]), dtype=np.int64)
    lid = np.asarray(m3.triangulate([contour.tolist() for contour in _split(layers[-1][:, :2], contours)]), dtype=np.int64)
    ahead = np.concatenate([np.roll(part, -1) for part in _split(np.arange(count), contours)])
    faces = [cap[:, ::-1], lid + last]
    for level in range(len(levels) - 1):
        below, above = np.arange(count) + level * count, np.arange(count) + (level + 1) * count
        faces += [np.column_stack([below, below[ahead], above[ahead]]), np.column_stack([below, above[ahead], above])]
    return _manifold(np.concatenate(layers), np.concatenate(faces))


def slab(section: CrossSection, height: float, *, foot: float = 0.6, top: float = 1.0) -> Manifold:
    """An extrusion standing on z = 0 with a chamfered lower and a rounded upper edge, both switched off by 0."""
    levels = [(0.0, foot), (foot, 0.0)] if foot else [(0.0, 0.0)]
    levels += [(height - top + z, inset) for z, inset in round_edge(top)] if top else [(height, 0.0)]
    return lofted(section, levels)


def bar(section: CrossSection, width: float, edge: float) -> Manifold:
    """A side view (x, z) extruded over `width` along y around y = 0, its edges on both sides rounded."""
    side = [(width / 2 - edge + z, inset) for z, inset in round_edge(edge)]
    return lofted(section, [*((-z, inset) for z, inset in reversed(side)), *side]).rotate((90.0, 0.0, 0.0))


def pocket(section: CrossSection, depth: float, *, floor: float, flare: float) -> Manifold:
    """The body to subtract for a pocket of this mouth down from z = 0, with a rounded floor edge and a mouth that opens in a round lip."""
    low = [(-depth + floor - z, inset) for z, inset in reversed(round_edge(floor, 10))]
    lip = [(-flare + flare * math.sin(t), -flare * (1 - math.cos(t))) for t in np.linspace(0, math.pi / 2, 7)]
    return lofted(section, [*low, *lip, (1.0, -flare)])


def skinned(rings: ArrayLike, *, closed: bool = False) -> Manifold:
    """The solid inside a skin over rings of points.

    Args:
        rings: Points [mm], shape [ring_count, point_count, 3], each ring anticlockwise seen from where the next one lies.
        closed: Whether the last ring joins the first; otherwise both ends are closed by a fan around their mean.
    """
    points = np.asarray(rings, dtype=np.float64)
    count, around = points.shape[:2]
    index = np.arange(count * around).reshape(count, around)
    below, above = (index, np.roll(index, -1, axis=0)) if closed else (index[:-1], index[1:])
    ahead_below, ahead_above = np.roll(below, -1, axis=1), np.roll(above, -1, axis=1)
    faces = [np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((below, ahead_below, ahead_above), (below, ahead_above, above))]
    vertices = points.reshape(-1, 3)
    if not closed:
        vertices = np.concatenate([vertices, points[[0, -1]].mean(axis=1)])
        first, last = index[0], index[-1]
        faces.append(np.column_stack([np.roll(first, -1), first, np.full(around, count * around)]))
        faces.append(np.column_stack([last, np.roll(last, -1), np.full(around, count * around + 1)]))
    return _manifold(vertices, np.concatenate(faces))


def swept(path: ArrayLike, sizes: ArrayLike, *, power: float = 2.6) -> Manifold:
    """A bar along a line (y, z), shape [n, 2], of a width along x and a thickness in the plane at each point, shape [n, 2].

    `power` is the exponent of its superelliptic section: 2 is an ellipse, more is boxier.
    """
    line, half = np.asarray(path, dtype=np.float64), np.asarray(sizes, dtype=np.float64) / 2
    tangent = np.gradient(line, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    outline = superellipse(1.0, 1.0, power, segments(float(half.max())))
    x = outline[:, 0] * half[:, :1]
    offset = outline[:, 1] * half[:, 1:]
    y = line[:, :1] + offset * tangent[:, 1:]
    z = line[:, 1:] - offset * tangent[:, :1]
    return skinned(np.stack([x, y, z], axis=-1))


def superellipse(half_width: float, half_height: float, power: float, points: int) -> Floats:
    """The closed line |x / a|^p + |y / b|^p = 1 (Lamé), anticlockwise, shape [points, 2]."""
    turn = np.linspace(0.0, 2 * math.pi, points, endpoint=False)
    direction = np.column_stack([np.cos(turn), np.sin(turn)])
    radius = (np.abs(direction) ** power).sum(axis=1) ** (-1.0 / power)
    return direction * radius[:, None] * (half_width, half_height)


def turned(profile: ArrayLike) -> Manifold:
    """A solid of revolution about z from the line (radius, height), shape [n, 2], run with the material on its left."""
    line = np.asarray(profile, dtype=np.float64)
    turn = np.linspace(0.0, 2 * math.pi, segments(float(line[:, 0].max())), endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(len(turn))])
    return skinned(line[:, None, :1] * ring + line[:, None, 1:] * (0.0, 0.0, 1.0))


def revolved(section: CrossSection, *, soft: float) -> Manifold:
    """A solid of revolution about z from the half of a section (radius, height) at positive radii, its edges rounded to a radius."""
    whole = softened(section + section.mirror((1.0, 0.0)), soft, soft)
    return Manifold.revolve(whole, segments(whole.bounds()[2]))


def through(section: CrossSection, low: float, high: float) -> Manifold:
    """The body to subtract for a straight opening of this section along z."""
    return Manifold.extrude(section, high - low).translate((0.0, 0.0, low))


def screw_hole(diameter: float, depth: float) -> Manifold:
    """The body to subtract for a countersunk screw hole down from z = 0 through a wall of this thickness."""
    sink = 0.55 * diameter
    return turned([(diameter / 2, -depth - 1.0), (diameter / 2, -sink), (diameter / 2 + sink + 1.0, 1.0)])


def arc(centre: tuple[float, float], radius: float, start: float, end: float, steps: int = 33) -> Floats:
    """Points on a circle from one angle to another [degrees], shape [steps, 2]."""
    turn = np.radians(np.linspace(start, end, steps))
    return np.asarray(centre) + radius * np.column_stack([np.cos(turn), np.sin(turn)])


def _mitres(contour: Floats) -> Floats:
    """Outward moves of a polygon's corners that shift its edges by 1, shape [n, 2]."""
    edge = np.roll(contour, -1, axis=0) - contour
    normal = np.column_stack([edge[:, 1], -edge[:, 0]]) / np.linalg.norm(edge, axis=1, keepdims=True)
    before = np.roll(normal, 1, axis=0)
    return np.asarray((normal + before) / (1.0 + np.einsum("ij,ij->i", normal, before))[:, None])


def _moveable(contour: Floats, insets: Sequence[float]) -> Floats:
    """The polygon without spikes and without corners whose short edges would turn round when it is moved inwards by any inset."""
    deepest = np.array([min(insets), max(insets)])
    while len(contour) > 3:
        edge = np.roll(contour, -1, axis=0) - contour
        along = edge / np.linalg.norm(edge, axis=1, keepdims=True)
        straight = np.einsum("ij,ij->i", along, np.roll(along, 1, axis=0))
        growth = np.roll(_mitres(contour), -1, axis=0) - _mitres(contour)
        left = 1.0 - deepest[:, None] * np.einsum("ij,ij->i", growth, edge) / np.einsum("ij,ij->i", edge, edge)
        if straight.min() < -0.7:
            worst = int(straight.argmin())
        elif left.min() < 0.05:
            worst = int(left.min(axis=0).argmin())
        else:
            return contour
        contour = np.delete(contour, worst, axis=0)
    raise BadInput("an edge of the model is rounded more than its corners allow: go back towards the defaults")


def _split(values: NDArray[np.generic], contours: Sequence[Floats]) -> list[NDArray[np.generic]]:
    return np.split(values, np.cumsum([len(contour) for contour in contours])[:-1])


def _manifold(vertices: Floats, faces: NDArray[np.int64]) -> Manifold:
    return Manifold(m3.Mesh64(np.ascontiguousarray(vertices), np.ascontiguousarray(faces, dtype=np.uint64)))


def inner_radius(outer: Floats, height: Floats, turn: Floats, wall: float) -> Floats:
    """Radius [mm] inside a wall of constant thickness along its normal, to first order, of an outer radius, shape [levels, points]."""
    steep = np.gradient(outer, height, axis=0)
    around = (np.roll(outer, -1, axis=1) - np.roll(outer, 1, axis=1)) / (2.0 * turn[1] * outer)
    return np.asarray(outer - wall * np.sqrt(1.0 + steep**2 + around**2))


def rim(outer: Floats, inner: Floats, height: float, rise: float) -> tuple[Floats, Floats]:
    """Radii [9, points] and heights [9] of a round rim from the outer to the inner edge of a wall, both left out."""
    over = np.linspace(0.0, math.pi, 11)[1:-1]
    return (outer + inner) / 2 + (outer - inner) / 2 * np.cos(over)[:, None], height + rise * np.sin(over)


def bowl(inner: Floats, height: Floats, base: float, fillet: float) -> tuple[Floats, Floats]:
    """The inside of a vessel in rings, from its upper edge down over a fillet to the floor at `base`: radii [k, points], heights [k].

    The inner radius, shape [levels, points], is that at rising heights; `fillet` is how far the wall runs out onto the floor.
    """
    into = np.linspace(0.0, math.pi / 2, 9)
    above = height > base + fillet
    level = np.concatenate([height[above][::-1], base + fillet * (1.0 - np.sin(into))])
    radius = np.stack([np.interp(level, height, column) for column in inner.T], axis=1)
    radius[-len(into) :] -= fillet * (1.0 - np.cos(into))[:, None]
    return radius, level


def rings(radius: Floats, level: Floats, turn: Floats) -> Floats:
    """Points at radii [levels, points], heights [levels] and angles [points], shape [levels, points, 3]."""
    z = np.broadcast_to(level[:, None], radius.shape)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=-1)


def angles(waves: int) -> Floats:
    """Evenly spaced angles, at least 16 for each of the waves around a shell."""
    return np.linspace(0.0, 2.0 * math.pi, max(16 * waves, 192), endpoint=False)
