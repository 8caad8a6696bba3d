"""Surfaces with triangles without area, as exports of CAD programs and remeshers leave them; closed, of the shape they are made from."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mechstyle.records.mesh import SurfaceMesh


def seamed(mesh: SurfaceMesh, apart: float = 0.0) -> SurfaceMesh:
    """A seam along a side of every third face: a vertex on it, and beside it one whose triangles have no area, off by `apart` [mm]."""
    points, faces, random = list(mesh.vertices), mesh.faces.tolist(), np.random.default_rng(3)
    for number in range(0, len(faces), 3):
        a, b, c = faces[number]
        middle, inner = len(points), len(points) + 1
        points += [0.5 * (points[a] + points[b]), 0.3 * points[a] + 0.7 * points[b] + apart * random.normal(size=3)]
        faces[number] = [a, middle, c]
        faces += [[middle, b, c], [a, b, inner], [b, middle, inner], [middle, a, inner]]
    return SurfaceMesh(np.array(points), np.array(faces))


def twinned(mesh: SurfaceMesh, which: Iterable[int], apart: float = 0.0) -> SurfaceMesh:
    """Vertices split in two, `apart` [mm] from each other: half of the faces around each go to its twin."""
    points, faces, random = list(mesh.vertices), mesh.faces.tolist(), np.random.default_rng(3)
    for vertex in which:
        after = {}
        for number, face in enumerate(faces):
            if vertex in face:
                start = face.index(vertex)
                after[face[start - 2]] = (face[start - 1], number)
        ring = [min(after)]
        while len(ring) < len(after):
            ring.append(after[ring[-1]][0])
        twin, half = len(points), len(ring) // 2
        points.append(points[vertex] + apart * random.normal(size=3))
        for neighbour in ring[:half]:
            face = faces[after[neighbour][1]]
            face[face.index(vertex)] = twin
        faces += [[vertex, ring[0], twin], [twin, ring[half], vertex]]
    return SurfaceMesh(np.array(points), np.array(faces))


def needled(mesh: SurfaceMesh, which: Iterable[int], apart: float = 0.0) -> SurfaceMesh:
    """Faces split in three by a vertex beside their first corner, off by that share of their sides: two needles and a triangle."""
    points, faces = list(mesh.vertices), mesh.faces.tolist()
    for number in which:
        a, b, c = faces[number]
        inner = len(points)
        points.append((1.0 - 2.0 * apart) * points[a] + apart * points[b] + apart * points[c])
        faces[number] = [a, b, inner]
        faces += [[b, c, inner], [c, a, inner]]
    return SurfaceMesh(np.array(points), np.array(faces))


def railed(steps: int = 6, off: float = 0.5) -> SurfaceMesh:
    """A square bar 10 x 10 x 12 mm, one edge of which is a strip without width: two rows of vertices on one line, not beside each other.

    Exports of rounds that end in nothing have such strips.
    """
    outline = np.array([(0, 0), (10, 0), (10, 10), (10, 10), (0, 10)], float)
    count, height = len(outline), 12.0 / steps
    points = np.array([(*corner, level * height) for level in range(steps + 1) for corner in outline])
    points[count + 3 : -count : count, 2] += off
    faces = []
    for level in range(steps):
        for corner in range(count):
            a, b = level * count + corner, level * count + (corner + 1) % count
            faces += [(a, b, b + count), (a, b + count, a + count)]
    top = steps * count
    faces += [(0, k + 1, k) for k in range(1, count - 1)] + [(top, top + k, top + k + 1) for k in range(1, count - 1)]
    return SurfaceMesh(points, np.array(faces))
