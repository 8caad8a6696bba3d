"""Borders of regions of a surface: where they cross its edges, and the way from them along the surface."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.sparse.csgraph import dijkstra

from mechstyle.records.mesh import Bools, Floats, Indices, SurfaceMesh

HALVINGS = 12
"""Steps in which a border is found on an edge: to a four-thousandth of it."""
LEAST_WAY = 1e-9
"""Way from a border of a vertex that lies on it [mm]: a graph has no edges of no length."""


@dataclass(frozen=True, eq=False)
class Extent:
    """The vertices that a region holds, and where its border crosses the edges between them and others.

    Attributes:
        surface: The surface.
        holds: Whether the region holds each vertex, shape [vertex_count].
        crossings: How far along each edge of `leaving` the border lies from the vertex that is held, in [0, 1], shape [k]; None where all
            that is known are vertices: then it lies at these.
    """

    surface: SurfaceMesh
    holds: Bools
    crossings: Floats | None = None

    @classmethod
    def below(cls, surface: SurfaceMesh, level: Floats) -> Extent:
        """Where a field of the vertices, shape [vertex_count], is zero or less; along edges it is a straight line."""
        holds = np.asarray(level <= 0.0)
        held, free = leaving(surface, holds)
        return cls(surface, holds, np.asarray(level[held] / (level[held] - level[free])))

    @classmethod
    def where(cls, surface: SurfaceMesh, tells: Callable[[Floats, Floats], Bools]) -> Extent:
        """Where points of the surface with their normals, shape [n, 3], are held by a rule."""
        points, normals = surface.vertices, surface.vertex_normals
        holds = np.asarray(tells(points, normals))
        held, free = leaving(surface, holds)
        near, far = np.zeros(len(held)), np.ones(len(held))
        for _ in range(HALVINGS):
            middle = 0.5 * (near + far)
            there = tells(points[held] + middle[:, None] * (points[free] - points[held]), normals[held])
            near, far = np.where(there, middle, near), np.where(there, far, middle)
        return cls(surface, holds, 0.5 * (near + far))

    def way(self, limit: float = np.inf, *, to_both_sides: bool = False) -> Floats:
        """Way from the border along edges [mm], shape [vertex_count], 0 for vertices that are held, infinite beyond a limit.

        Of regions to both sides of which it is wanted that of the vertices that are held counts from the border, too.
        """
        held, (inner, outer) = self.holds, leaving(self.surface, self.holds)
        share = np.zeros(len(inner)) if self.crossings is None else self.crossings
        length = np.linalg.norm(self.surface.vertices[inner] - self.surface.vertices[outer], axis=1)
        start = np.full(len(held), np.inf)
        np.minimum.at(start, outer, (1.0 - share) * length)
        np.minimum.at(start, inner, share * length)
        found = way_from(self.surface, start, limit)
        return found if to_both_sides else np.where(held, 0.0, found)


def leaving(surface: SurfaceMesh, holds: Bools) -> tuple[Indices, Indices]:
    """The edges that leave a region, as the vertices that it holds and those that it does not, shape [k] each."""
    crossed = surface.edges[holds[surface.edges[:, 0]] != holds[surface.edges[:, 1]]]
    held, free = np.where(holds[crossed[:, :1]], crossed, crossed[:, ::-1]).T
    return held, free


def way_from(surface: SurfaceMesh, start: ArrayLike, limit: float = np.inf) -> Floats:
    """Way along edges, with what it is long at its start [mm], infinite where it does not start; shape [vertex_count] both.

    What is farther than a limit [mm] is infinitely far.
    """
    ahead, edges, count = np.asarray(start, np.float64), surface.edges, len(surface.vertices)
    begins = np.flatnonzero(np.isfinite(ahead))
    lengths = np.linalg.norm(surface.vertices[edges[:, 0]] - surface.vertices[edges[:, 1]], axis=1)
    # One more vertex, from which all ways start.
    rows = np.concatenate([edges[:, 0], edges[:, 1], np.full(len(begins), count)])
    columns = np.concatenate([edges[:, 1], edges[:, 0], begins])
    values = np.concatenate([lengths, lengths, np.maximum(ahead[begins], LEAST_WAY)])
    graph = sp.csr_array((values, (rows, columns)), shape=(count + 1, count + 1))
    return np.asarray(dijkstra(graph, indices=count, limit=limit)[:count])
