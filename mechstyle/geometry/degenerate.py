"""Triangles without area, taken out of a closed surface that otherwise stays as it is."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mechstyle.geometry.going_on import GoOn, regardless
from mechstyle.records.mesh import Floats, SurfaceMesh

PASSES = 20
STEADY = 0.5  # cosine of the angle by which a sound triangle may turn when a corner of it moves by less than the height
STILL = 0.999  # the same when it moves further, as it may along a straight crease or in a plane

Face = tuple[int, int, int]


def heights(corners: Floats) -> Floats:
    """Height of triangles over their longest side, zero for those without area [mm], shape [face_count].

    Args:
        corners: Their corners [mm], shape [face_count, 3, 3].
    """
    double = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    return np.divide(double, longest, out=np.zeros_like(double), where=longest > 0)


def without_degenerate(mesh: SurfaceMesh, least: float, go_on: GoOn = regardless) -> SurfaceMesh:
    """The mesh without triangles lower than a height, as far as that keeps its shells and handles.

    Where two corners of such a triangle are as near as that, they become one, the first of them; else its longest side is turned
    towards the vertex across, which moves the surface by less than the height. Where neither is possible, as between two rows of
    vertices on one line, the nearest two corners become one if no sound triangle turns by that. Sound triangles keep their side.

    Args:
        mesh: A closed surface.
        least: The height [mm].
        go_on: Asked at the beginning, if there is anything to do, and before every pass over them.
    """
    if not (heights(mesh.corners) < least).any():
        return mesh
    go_on()
    triangles = _Triangles(mesh)
    for _ in range(PASSES):
        go_on()
        flat = [face for face, height in zip(triangles.alive(), triangles.heights(triangles.alive()), strict=True) if height < least]
        if not sum(triangles.mend(face, least) for face in flat if triangles.faces[face] is not None):
            break
    return triangles.mesh()


class _Side(NamedTuple):
    """A side of a triangle and the corner across from it."""

    start: int
    end: int
    apex: int


class _Triangles:
    """A closed surface whose triangles can be changed one by one."""

    def __init__(self, mesh: SurfaceMesh) -> None:
        self.vertices = mesh.vertices
        self.faces: list[Face | None] = list(zip(*mesh.faces.T.tolist(), strict=True))
        around = (np.argsort(mesh.faces.ravel(), kind="stable") // 3).tolist()  # vertex by vertex
        ends = np.cumsum(np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices))).tolist()
        self.around: list[set[int]] = [set(around[start:end]) for start, end in pairwise([0, *ends])]

    def alive(self) -> list[int]:
        return [number for number, face in enumerate(self.faces) if face is not None]

    def heights(self, numbers: list[int]) -> list[float]:
        return [float(height) for height in heights(self.vertices[np.array([self.faces[number] for number in numbers])])]

    def mesh(self) -> SurfaceMesh:
        used, index = np.unique(np.array([face for face in self.faces if face is not None]), return_inverse=True)
        return SurfaceMesh(self.vertices[used], index.reshape(-1, 3).astype(np.int32))

    def mend(self, number: int, least: float) -> bool:
        """Take one low triangle out; whether that was possible. It may have been mended with another one before."""
        face = self.faces[number]
        assert face is not None
        if self.heights([number])[0] >= least:
            return False
        sides = sorted((_Side(*np.roll(face, -k).tolist()) for k in range(3)), key=self._length)
        first, second = sorted(sides[0][:2])  # the first vertices of a standardised surface are on creases
        if self._length(sides[0]) < least:
            return self._merged(first, second, partial(self._keeps_its_side, least=least))
        still = partial(self._stays_where_it_is, least=least)
        return self._turned(number, sides[-1]) or self._merged(first, second, still) or self._merged(second, first, still)

    def _merged(self, stays: int, goes: int, allowed: Callable[[int, Face], bool]) -> bool:
        """Make two neighbours one, if every triangle that gets another corner by that is allowed to."""
        if len(self._neighbours(stays) & self._neighbours(goes)) != 2:
            return False  # a handle or a shell would be pinched off
        changed = {number: self._with(number, goes, stays) for number in self.around[goes] - self.around[stays]}
        if not all(allowed(number, face) for number, face in changed.items()):
            return False
        for number in list(self.around[goes]):
            self._replace(number, changed.get(number))
        return True

    def _turned(self, number: int, side: _Side) -> bool:
        """Turn a side towards the vertex across, if the lower of the two triangles becomes higher and none is turned over."""
        (other,) = (self.around[side.start] & self.around[side.end]) - {number}
        across = next(vertex for vertex in self._corners(other) if vertex not in side[:2])
        if across in self._neighbours(side.apex):
            return False
        new: list[Face] = [(side.apex, side.start, across), (side.apex, across, side.end)]
        was, becomes = self._vectors([self._corners(number), self._corners(other)]), self._vectors(new)
        if (becomes @ was.sum(axis=0) <= 0).any() or heights(self.vertices[np.array(new)]).min() <= min(self.heights([number, other])):
            return False
        self._replace(number, new[0])
        self._replace(other, new[1])
        return True

    def _keeps_its_side(self, number: int, becomes: Face, least: float) -> bool:
        return self.heights([number])[0] < least or self._turn(number, becomes) > STEADY

    def _stays_where_it_is(self, number: int, becomes: Face, least: float) -> bool:
        low_before, low_after = heights(self.vertices[np.array([self._corners(number), becomes])]) < least
        return bool(low_after) if low_before else self._turn(number, becomes) > STILL

    def _turn(self, number: int, becomes: Face) -> float:
        """Cosine of the angle by which a triangle turns that gets another corner."""
        was, new = self._vectors([self._corners(number), becomes])
        return float(was @ new) / max(float(np.linalg.norm(was) * np.linalg.norm(new)), 1e-300)

    def _vectors(self, faces: list[Face]) -> Floats:
        a, b, c = self.vertices[np.array(faces)].transpose(1, 0, 2)
        return np.cross(b - a, c - a)

    def _length(self, side: _Side) -> float:
        return float(np.linalg.norm(self.vertices[side.end] - self.vertices[side.start]))

    def _corners(self, number: int) -> Face:
        face = self.faces[number]
        assert face is not None
        return face

    def _with(self, number: int, old: int, new: int) -> Face:
        a, b, c = (new if vertex == old else vertex for vertex in self._corners(number))
        return a, b, c

    def _neighbours(self, vertex: int) -> set[int]:
        return {other for number in self.around[vertex] for other in self._corners(number)} - {vertex}

    def _join(self, number: int, face: Face | None) -> None:
        for vertex in face or ():
            self.around[vertex].add(number)

    def _replace(self, number: int, face: Face | None) -> None:
        for vertex in self._corners(number):
            self.around[vertex].discard(number)
        self.faces[number] = face
        self._join(number, face)
