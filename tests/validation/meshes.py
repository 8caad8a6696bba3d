"""Structured bodies whose answers are known, and their refinement."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mechstyle.fea.elements import EDGES
from mechstyle.records.mesh import Floats, TetMesh


def box(counts: tuple[int, int, int], size: tuple[float, float, float]) -> TetMesh:
    """A box in the positive octant [mm], each of its cells cut into the six Kuhn tetrahedra."""
    axes = [np.linspace(0.0, length, count + 1) for count, length in zip(counts, size, strict=True)]
    return lattice(*axes)


def lattice(x: Floats, y: Floats, z: Floats) -> TetMesh:
    """The box between the first and last of given coordinates [mm], each cell cut into the six Kuhn tetrahedra."""
    counts = np.array([len(x), len(y), len(z)]) - 1
    vertices = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    strides = np.array([(counts[1] + 1) * (counts[2] + 1), counts[2] + 1, 1])
    cells = np.stack(np.meshgrid(*[np.arange(count) for count in counts], indexing="ij"), axis=-1).reshape(-1, 3) @ strides
    tets = []
    for order in itertools.permutations(range(3)):
        path = np.concatenate([[0], np.cumsum(strides[list(order)])])
        if np.linalg.det(np.eye(3)[list(order)]) < 0.0:
            path[[2, 3]] = path[[3, 2]]
        tets.append(cells[:, None] + path)
    return TetMesh(vertices, np.stack(tets, axis=1).reshape(-1, 4))


def ball(radius: float, cells: int, finer: float) -> TetMesh:
    """A ball that touches z = 0 from above at the origin [mm], graded towards that point.

    Args:
        radius: Its radius [mm].
        cells: Cells along each edge of the cube that is bent into the ball; even.
        finer: How many times smaller than the mean the cells at the point of contact are, about.
    """
    across, up = _graded(cells, finer)
    cube = lattice(across, across, up)
    bent = radius * _shells(cube.vertices) + [0.0, 0.0, radius]
    return _upright(cube.moved(bent))


def roller(radius: float, length: float, cells: int, along: int, finer: float) -> TetMesh:
    """A round bar along x that lies on z = 0, graded towards the line of contact [mm].

    Args:
        radius: Its radius [mm].
        length: Its length [mm].
        cells: Cells along each edge of the square that is bent into its section; even.
        along: Cells along it.
        finer: As for `ball`.
    """
    across, up = _graded(cells, finer)
    square = lattice(np.linspace(0.0, length, along + 1), across, up)
    bent = radius * _shells(square.vertices[:, 1:]) + [0.0, radius]
    return _upright(square.moved(np.column_stack([square.vertices[:, 0], bent])))


def _graded(cells: int, finer: float) -> tuple[Floats, Floats]:
    """Coordinates from −1 to 1 that lie closer in the middle, and such that lie closer at −1."""
    steepness = math.asinh(finer)
    across = np.sinh(steepness * np.linspace(-1.0, 1.0, cells + 1)) / math.sinh(steepness)
    up = 2.0 * np.sinh(0.5 * steepness * np.linspace(0.0, 1.0, cells + 1)) / math.sinh(0.5 * steepness) - 1.0
    return across, up


def _shells(square: Floats) -> Floats:
    """Shells of a square or cube from −1 to 1 as those of a disc or ball; tangents spread the cells evenly over the angle."""
    shell = np.abs(square).max(axis=1, keepdims=True)
    outward = np.tan(0.25 * math.pi * square / np.maximum(shell, 1e-12))
    return np.asarray(shell * outward / np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-12))


def cup(radius: float, height: float, wall: float, counts: tuple[int, int, int] = (36, 10, 4)) -> TetMesh:
    """A round cup with a floor, standing on z = 0 [mm]: wall and floor one element thick.

    Args:
        radius: Outer radius [mm].
        height: Height [mm].
        wall: Thickness of wall and floor [mm].
        counts: Cells around, along the height of the wall, and along the radius of the floor between its middle and the wall.
    """
    around, up, out = counts
    profile = [(r, 0.0) for r in np.linspace(0.0, radius - wall, out + 1)] + [(radius, 0.0)]
    inside = [(r, wall) for r, _ in profile]
    rings = [profile, inside]
    rings += [[(radius - wall, z), (radius, z)] for z in np.linspace(wall, height, up + 1)[1:]]
    return _revolved(rings, around)


def square_cup(width: float, height: float, wall: float) -> TetMesh:
    """A square cup with a floor, standing on z = 0 [mm]: cells as large as the wall is thick, each cut into the six Kuhn tetrahedra."""
    across, up = round(width / wall), round(height / wall)
    block = box((across, across, up), (width, width, height))
    centres = block.vertices[block.tets].mean(axis=1)
    hollow = (np.abs(centres[:, :2] - 0.5 * width).max(axis=1) < 0.5 * width - wall) & (centres[:, 2] > wall)
    return _without(block, hollow)


def bracket(leg: float, width: float, thickness: float, cell: float) -> TetMesh:
    """An angle of two equal legs, one along x on z = 0, one up along z [mm].

    Args:
        leg: Outer length of both legs [mm].
        width: Along y [mm].
        thickness: Of the legs [mm].
        cell: Edge of the cells, of which the other lengths are multiples, each cut into the six Kuhn tetrahedra [mm].
    """
    counts = (round(leg / cell), round(width / cell), round(leg / cell))
    block = box(counts, (leg, width, leg))
    centres = block.vertices[block.tets].mean(axis=1)
    return _without(block, (centres[:, 0] > thickness) & (centres[:, 2] > thickness))


def open_ring(length: float, breadth: float, thickness: float, around: int) -> TetMesh:
    """An elliptic ring that is open at one side, lying on z = 0, of square section [mm].

    Args:
        length: Half the longer axis of its middle line [mm].
        breadth: Half the shorter one [mm].
        thickness: Of the section [mm].
        around: Cells along the ring; two by two in the section.
    """
    way = lattice(np.linspace(0.1 * np.pi, 1.9 * np.pi, around + 1), np.linspace(-0.5, 0.5, 3), np.linspace(0.0, 1.0, 3))
    turn, out, up = way.vertices.T
    line = np.column_stack([length * np.cos(turn), breadth * np.sin(turn)])
    outward = np.column_stack([breadth * np.cos(turn), length * np.sin(turn)])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return _upright(way.moved(np.column_stack([line + thickness * out[:, None] * outward, thickness * up])))


def round_bar(diameter: float, length: float, rings: int, along: int) -> TetMesh:
    """A round bar along x from 0 to `length`, about the x-axis [mm].

    Args:
        diameter: Of the bar [mm].
        length: Of the bar [mm].
        rings: Cells across the square that is bent into its section; even.
        along: Cells along it.
    """
    across = np.linspace(-1.0, 1.0, rings + 1)
    square = lattice(np.linspace(0.0, length, along + 1), across, across)
    side = square.vertices[:, 1:]
    shell = np.abs(side).max(axis=1, keepdims=True) / np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-12)
    return square.moved(np.column_stack([square.vertices[:, 0], 0.5 * diameter * shell * side]))


def upright_bar(radius: float, length: float, cells: int, along: int) -> TetMesh:
    """A round bar that stands on z = 0, about the z-axis [mm].

    Args:
        radius: Of the bar [mm].
        length: Of the bar [mm].
        cells: Cells across the square that is bent into its section; even.
        along: Cells along it.
    """
    across = np.linspace(-1.0, 1.0, cells + 1)
    square = lattice(across, across, np.linspace(0.0, length, along + 1))
    return _upright(square.moved(np.column_stack([radius * _shells(square.vertices[:, :2]), square.vertices[:, 2]])))


def grooved_bar() -> TetMesh:
    """A bar of 8 x 8 mm along x, 32 mm long, with a groove 1.4 mm wide and 2 mm deep all round, 12 mm from its end."""
    across = spans((0.0, 2.0, 1), (2.0, 6.0, 3), (6.0, 8.0, 1))
    along = spans((0.0, 12.0, 4), (12.0, 13.4, 2), (13.4, 32.0, 5))
    return carved(along, across, across, lambda x, y, z: (x < 12.0) | (x > 13.4) | (np.maximum(np.abs(y - 4.0), np.abs(z - 4.0)) < 2.0))


def necked_bar() -> TetMesh:
    """Two blocks of 10 x 10 x 5 mm along x and a neck of 4 x 4 x 1 mm between them."""
    across = spans((0.0, 3.0, 1), (3.0, 7.0, 3), (7.0, 10.0, 1))
    along = spans((0.0, 5.0, 2), (5.0, 6.0, 2), (6.0, 11.0, 2))
    return carved(along, across, across, lambda x, y, z: (x < 5.0) | (x > 6.0) | (np.maximum(np.abs(y - 5.0), np.abs(z - 5.0)) < 2.0))


def spans(*each: tuple[float, float, int]) -> Floats:
    """Coordinates of cells along spans of (start, end, cells) [mm]."""
    return np.unique(np.concatenate([np.linspace(start, end, cells + 1) for start, end, cells in each]))


def carved(x: Floats, y: Floats, z: Floats, keep: Callable[[Floats, Floats, Floats], NDArray[np.bool_]]) -> TetMesh:
    """Of a lattice between given coordinates [mm] the tetrahedra of cells whose middle is to be kept.

    Args:
        x: Coordinates of the cells' corners along x, and likewise y and z.
        y: See x.
        z: See x.
        keep: Says of middles of cells [mm], each of shape [n], whether they are part of the body.
    """
    block = lattice(x, y, z)
    centres = block.vertices[block.tets].mean(axis=1)
    x_middle, y_middle, z_middle = (_middle(axis, centre) for axis, centre in zip((x, y, z), centres.T, strict=True))
    return _without(block, ~keep(x_middle, y_middle, z_middle))


def _middle(axis: Floats, place: Floats) -> Floats:
    """Middle of the cell in which a coordinate lies."""
    number = np.clip(np.searchsorted(axis, place) - 1, 0, len(axis) - 2)
    return np.asarray(0.5 * (axis[number] + axis[number + 1]))


def _without(block: TetMesh, hollow: NDArray[np.bool_]) -> TetMesh:
    """A mesh without some of its tetrahedra, [tet_count], and the vertices only they use."""
    used, numbers = np.unique(block.tets[~hollow], return_inverse=True)
    return TetMesh(block.vertices[used], numbers.reshape(-1, 4).astype(np.int32))


def _revolved(rings: list[list[tuple[float, float]]], around: int) -> TetMesh:
    """Turn the quadrilaterals between rows of (radius, z) about the z-axis; a shorter row joins the end of the one below."""
    quads = []
    for lower, upper in itertools.pairwise(rings):
        below = lower[len(lower) - len(upper) :]
        quads += [(below[k], below[k + 1], upper[k + 1], upper[k]) for k in range(len(upper) - 1)]
    angles = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    corners, tets = [], []
    for a, quad in itertools.product(range(around), quads):
        for turn in (angles[a], angles[(a + 1) % around]):
            corners += [(r * np.cos(turn), r * np.sin(turn), z) for r, z in quad]
        tets.append(8 * (len(corners) // 8 - 1) + HEXAHEDRON)
    points, number = np.unique(np.round(np.array(corners), 9), axis=0, return_inverse=True)
    cells = number.ravel()[np.concatenate(tets)]
    used = np.array([len(set(cell)) == 4 for cell in cells])  # at the axis two corners are one
    return _upright(TetMesh(points, cells[used]))


HEXAHEDRON = np.array([[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]])
"""Six tetrahedra about the diagonal 0–6 of a cell with the corners 0 to 3 on one side and 4 to 7 opposite."""


def refined(tets: TetMesh) -> TetMesh:
    """Every tetrahedron cut into eight at the middles of its edges; the shape stays."""
    ends = np.sort(tets.tets[:, EDGES].reshape(-1, 2), axis=1)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    m01, m02, m03, m12, m13, m23 = len(tets.vertices) + number.reshape(-1, 6).T
    p, q, r, s = tets.tets.T
    corners = [(p, m01, m02, m03), (m01, q, m12, m13), (m02, m12, r, m23), (m03, m13, m23, s)]
    middle = [(m01, m02, m03, m13), (m01, m02, m13, m12), (m02, m03, m13, m23), (m02, m13, m12, m23)]
    vertices = np.concatenate([tets.vertices, tets.vertices[edges].mean(axis=1)])
    return _upright(TetMesh(vertices, np.concatenate([np.stack(corner, axis=1) for corner in corners + middle])))


def _upright(tets: TetMesh) -> TetMesh:
    """The same with every tetrahedron of positive volume."""
    inverted = (tets.volumes < 0.0)[:, None]
    return TetMesh(tets.vertices, np.where(inverted, tets.tets[:, [0, 2, 1, 3]], tets.tets))
