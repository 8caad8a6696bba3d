"""Cutting the faces of a surface smaller without moving it; the vertices of the surface stay the first."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from mechstyle.records.mesh import Bools, Indices, SurfaceMesh

NEARLY = 0.9
"""Share of the wanted vertices from which on the rest comes from halving the longest edges, instead of cutting all of them once more."""


def refined_to(mesh: SurfaceMesh, vertices: int, *, most_parts: int) -> SurfaceMesh:
    """A closed surface with at least so many vertices, evenly cut; fewer where edges may not be cut into so many parts."""
    count = len(mesh.vertices)
    parts = min(max(int(np.ceil(np.sqrt(NEARLY * vertices / count))), 1), most_parts)
    # A closed surface has three edges for each vertex, but for six, of which each is cut in k - 1 places: k² (n - 2) + 2 in all.
    missing = int(np.ceil((vertices - 2) / parts**2)) + 2 - count
    topped = halved(mesh, missing if 0 < missing <= count * (1.0 / NEARLY - 1.0) + 2 else 0)
    return subdivided(topped, parts)


def subdivided(mesh: SurfaceMesh, parts: int = 2) -> SurfaceMesh:
    """Cut every edge into so many equal parts, and every face into their square; colours are interpolated."""
    count, edges = len(mesh.vertices), mesh.edges.astype(np.int64)
    inner = np.arange(1, parts)
    on_edges = np.stack([np.tile(parts - inner, len(edges)), np.tile(inner, len(edges))], axis=1)
    places = [(i, j) for j in range(1, parts) for i in range(1, parts - j)]
    in_faces = np.tile(np.array([(parts - i - j, i, j) for i, j in places]).reshape(-1, 3), (len(mesh.faces), 1))
    ends, corners = np.repeat(edges, parts - 1, axis=0), np.repeat(mesh.faces.astype(np.int64), len(places), axis=0)
    first_inside = count + len(on_edges)
    total = first_inside + len(in_faces)
    rows = np.concatenate([np.arange(count), np.repeat(np.arange(count, first_inside), 2), np.repeat(np.arange(first_inside, total), 3)])
    columns = np.concatenate([np.arange(count), ends.ravel(), corners.ravel()])
    weights = np.concatenate([np.full(count, parts), on_edges.ravel(), in_faces.ravel()]) / parts
    matrix = sp.csr_array((weights, (rows, columns)), shape=(total, count))
    inside = first_inside + np.arange(len(in_faces)).reshape(len(mesh.faces), -1)
    # Numbers of the new vertices from each corner of each face on the way to the next, shape [face_count, 3, parts - 1].
    forth = (mesh.faces < np.roll(mesh.faces, -1, axis=1))[:, :, None]
    step = np.where(forth, np.arange(parts - 1), np.arange(parts - 1)[::-1])
    along = count + _edges_of_faces(mesh.faces, edges, count)[:, :, None] * (parts - 1) + step
    # The small faces of each face one after the other: those upright in it, then those turned over.
    grid: dict[tuple[int, int], NDArray[np.integer]] = dict(zip([(0, 0), (parts, 0), (0, parts)], mesh.faces.T, strict=True))
    for at in range(1, parts):
        grid |= {(at, 0): along[:, 0, at - 1], (parts - at, at): along[:, 1, at - 1], (0, parts - at): along[:, 2, at - 1]}
    grid |= {place: inside[:, number] for number, place in enumerate(places)}
    upright = [((i, j), (i + 1, j), (i, j + 1)) for j in range(parts) for i in range(parts - j)]
    turned = [((i + 1, j), (i + 1, j + 1), (i, j + 1)) for j in range(parts - 1) for i in range(parts - 1 - j)]
    small = [np.stack([grid[corner] for corner in corners], axis=1) for corners in (*upright, *turned)]
    return _interpolated(mesh, matrix, np.stack(small, axis=1).reshape(-1, 3))


def halved(mesh: SurfaceMesh, count: int) -> SurfaceMesh:
    """Halve the longest edges, as many as are wanted and do not share a face."""
    length = np.linalg.norm(mesh.vertices[mesh.edges[:, 0]] - mesh.vertices[mesh.edges[:, 1]], axis=1)
    sides = _edges_of_faces(mesh.faces, mesh.edges, len(mesh.vertices))
    faces_of = np.argsort(sides.ravel(), kind="stable").reshape(-1, 2) // 3  # closed: every edge bounds two faces
    taken: Bools = np.zeros(len(mesh.faces), bool)
    longest: list[int] = []
    for edge in np.argsort(-length, kind="stable"):
        if len(longest) == count:
            break
        if not taken[faces_of[edge]].any():
            taken[faces_of[edge]] = True
            longest.append(int(edge))
    chosen = np.array(sorted(longest), np.int64)
    edges, total = mesh.edges, len(mesh.vertices)
    ends = edges[chosen]
    rows = np.concatenate([np.arange(total), np.repeat(np.arange(total, total + len(chosen)), 2)])
    columns, weights = np.concatenate([np.arange(total), ends.ravel()]), np.concatenate([np.ones(total), np.full(2 * len(chosen), 0.5)])
    matrix = sp.csr_array((weights, (rows, columns)), shape=(total + len(chosen), total))
    middle = np.full(len(edges), -1)
    middle[chosen] = total + np.arange(len(chosen))
    of_face = middle[_edges_of_faces(mesh.faces, edges, total)]
    faces = [mesh.faces[(of_face < 0).all(axis=1)]]
    for side in range(3):
        cut = of_face[:, side] >= 0
        (a, b, c), half = np.roll(mesh.faces[cut], -side, axis=1).T, of_face[cut, side]
        faces += [np.stack([a, half, c], axis=1), np.stack([half, b, c], axis=1)]
    return _interpolated(mesh, matrix, np.concatenate(faces))


def _interpolated(mesh: SurfaceMesh, matrix: sp.csr_array, faces: NDArray[np.integer]) -> SurfaceMesh:
    colours = None if mesh.colours is None else matrix @ mesh.colours
    return SurfaceMesh(matrix @ mesh.vertices, faces.astype(np.int32), colours)


def _edges_of_faces(faces: Indices, edges: NDArray[np.integer], count: int) -> NDArray[np.int64]:
    """Number of the edge from each corner of each face to the next, shape [face_count, 3]; `edges` are sorted."""
    one, other = faces.astype(np.int64), np.roll(faces, -1, axis=1).astype(np.int64)
    names = edges[:, 0].astype(np.int64) * count + edges[:, 1]
    return np.searchsorted(names, np.minimum(one, other) * count + np.maximum(one, other))
