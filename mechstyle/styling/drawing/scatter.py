"""Points spread over a surface, and the cells and stamps around them.

Distances are taken between (position, reach · normal), so that the two sides of a thin wall, though near in space, do not share cells.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mechstyle.records.mesh import Floats, Indices, SurfaceMesh
from mechstyle.styling.drawing.operators import Operators

_REACH = 0.6  # weight of the normal over the spacing: opposite sides of a wall are 1.2 spacings apart
_NEIGHBOURS = 8  # points looked at for the nearest border of a cell


class Cells(NamedTuple):
    """Worley (1996) cells."""

    identity: Indices  # index of the nearest point, shape [n]
    edge: Floats  # distance to the nearest border of the cell [mm], shape [n]
    beside: Indices  # index of the point behind that border, shape [n]

    @property
    def facet(self) -> NDArray[np.int64]:
        """Identity of the part of the cell that is nearest to one border, shape [n]."""
        return (self.identity.astype(np.int64) << 32) + self.beside


class Stamps(NamedTuple):
    """The nearest stamps at each vertex by rising identity, each in its own tangent plane; all shape [n, k]."""

    identity: Indices  # index of the stamp; scattered points have a random order, which serves to stack overlapping stamps
    x: Floats  # offset along its first axis [mm]
    y: Floats  # offset along its second axis [mm]
    facing: Floats  # cosine between the normals here and at its centre, -1 beyond a sharp edge; drawn around one a stamp would be smeared


def embedded(points: Floats, normals: Floats, spacing: float) -> Floats:
    """Coordinates whose distance separates the sides of a wall, shape [n, 6]."""
    return np.hstack([points, _REACH * spacing * normals])


def poisson_disc(mesh: SurfaceMesh, spacing: float, seed: int, among: NDArray[np.bool_] | None = None) -> Indices:
    """Vertices in random order, each kept if no kept one is within `spacing` [mm] (dart throwing); only `among` if given."""
    coordinates = embedded(mesh.vertices, mesh.vertex_normals, spacing)
    tree = cKDTree(coordinates)
    free = np.ones(len(coordinates), dtype=bool) if among is None else among.copy()
    kept = []
    for vertex in np.random.default_rng(seed).permutation(len(coordinates)):
        if free[vertex]:
            kept.append(vertex)
            free[tree.query_ball_point(coordinates[vertex], spacing)] = False
    return np.array(kept, dtype=np.int32)


def worley(places: Floats, normals: Floats, points: Indices, queries: Floats, spacing: float) -> Cells:
    """Cells around the vertices `points`, looked up at `queries` [n, 3], places that may be warped first."""
    sites = embedded(places, normals, spacing)[points]
    distance, nearest = cKDTree(sites).query(embedded(queries, normals, spacing), k=min(_NEIGHBOURS, max(len(sites), 2)))
    found = np.isfinite(distance[:, 1:])  # a part with one cell has no border
    others = np.where(found, nearest[:, 1:], nearest[:, :1])
    apart = np.linalg.norm(sites[nearest[:, :1]] - sites[others], axis=2)
    # The second nearest point need not be the one behind the nearest border.
    borders = np.where(found, (distance[:, 1:] ** 2 - distance[:, :1] ** 2) / (2.0 * np.maximum(apart, 1e-9)), spacing)
    closest = borders.argmin(axis=1)
    edge, beside = (np.take_along_axis(field, closest[:, None], axis=1)[:, 0] for field in (borders, others))
    return Cells(nearest[:, 0].astype(np.int32), edge, beside.astype(np.int32))


def stamps(operators: Operators, points: Indices, axis: Floats, count: int, spacing: float) -> Stamps:
    """The `count` nearest of the stamps at vertices `points`, each with its first axis along `axis` [n, 3], a tangent field."""
    mesh, sides, count = operators.mesh, operators.sides, min(count, len(points))
    coordinates = embedded(mesh.vertices, mesh.vertex_normals, spacing)
    _, nearest = cKDTree(coordinates[points]).query(coordinates, k=count)
    identity = np.sort(np.asarray(nearest, dtype=np.int32).reshape(len(coordinates), count), axis=1)
    centre = points[identity]
    offset = mesh.vertices[:, None, :] - mesh.vertices[centre]
    first = axis[centre]
    second = np.cross(mesh.vertex_normals[centre], first)
    x, y = (np.einsum("nki,nki->nk", offset, direction) for direction in (first, second))
    # Around a bend the projection shortens offsets; the true distance is put back.
    stretch = np.clip(np.linalg.norm(offset, axis=2) / np.maximum(np.hypot(x, y), 1e-9), 1.0, 1.5)
    facing = np.einsum("nki,ni->nk", mesh.vertex_normals[centre], mesh.vertex_normals)
    beyond = (sides[:, None] != sides[centre]) & (sides[:, None] >= 0)
    return Stamps(identity, x * stretch, y * stretch, np.where(beyond, -1.0, facing))
