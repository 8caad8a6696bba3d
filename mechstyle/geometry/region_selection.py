"""Vertices of regions, and the share of relief allowed around those that are protected."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from mechstyle.errors import BadInput
from mechstyle.geometry.inside_outside import in_hole, is_inside
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.records.mesh import Floats, Indices, SurfaceMesh
from mechstyle.records.regions import End, Holes, Inside, Outside, Region, Rim, Segment, Shape, Sides

TURN = float(np.cos(np.radians(25.0)))
"""Segments end where the surface turns by more than this between two neighbouring vertices …"""
SLOPE, NEAR, STEP = 0.7, 1.5, 2.0
"""… or where the wall gets thicker this steeply (thickness as measured jumps with a slope of 1) and, within as many times its own
thickness, is so many times as thick. Where two equal walls meet it is not."""
LEAST_SEGMENT = 0.005
"""Smaller pieces, of the area, are no segments of their own."""
RIM = 0.08
"""Width of a rim over the size of the part, by default."""
HOLE, AROUND = 0.25, 0.03
"""Widest hole over the size of the part, by default, and the width of the rim that is kept around it: as wide as the head of a screw."""
UPRIGHT = float(np.cos(np.radians(45.0)))
"""A surface stands upright if its normal does not rise or fall more steeply than this."""


class Protection(NamedTuple):
    """Freedom of the style around protected regions."""

    freedom: NDArray[np.float32]  # factor on the relief, 0 in the regions, growing to 1 over their ramps, shape [vertex_count], float32
    uncoloured: NDArray[np.bool_]  # whether a vertex keeps the part's own colour, shape [vertex_count]
    notes: tuple[str, ...]  # one sentence for each region: what it is and how much of the surface it holds


def protection(regions: Sequence[Region], surface: SurfaceMesh, thickness: ArrayLike) -> Protection:
    """Freedom left by all regions together; where several meet, the strictest counts.

    The local wall thickness [mm], shape [vertex_count], sets segments apart. BadInput if a region holds nothing, or nothing is left to
    style.
    """
    count = len(surface.vertices)
    freedom, uncoloured, notes = np.ones(count), np.zeros(count, bool), []
    areas = surface.vertex_areas / surface.vertex_areas.sum()
    for region in regions:
        chosen = selected(region, surface, thickness)
        freedom = np.minimum(freedom, faded(surface, chosen, region.ramp))
        uncoloured |= chosen & region.colour
        notes.append(f"protected: {region.words}, {areas[chosen].sum():.0%} of the surface")
    if not freedom.any():
        raise BadInput("the protected regions hold all of the surface, so nothing is left to style; protect less")
    return Protection(freedom.astype(np.float32), uncoloured, tuple(notes))


def selected(region: Region, surface: SurfaceMesh, thickness: ArrayLike) -> NDArray[np.bool_]:
    """Whether each vertex lies in a region, shape [vertex_count]; thickness in mm, of that shape; BadInput if none does."""
    points = surface.vertices
    chosen: NDArray[np.bool_]
    if isinstance(region, Shape | End):
        chosen = region.contains(points)
    elif isinstance(region, Inside | Outside):
        chosen = is_inside(surface) ^ isinstance(region, Outside)
    elif isinstance(region, Sides):
        chosen = np.asarray(np.abs(surface.vertex_normals[:, 2]) < UPRIGHT)
    elif isinstance(region, Holes):
        hole = in_hole(surface, region.width or HOLE * surface.size)
        chosen = _way(surface, np.flatnonzero(hole), AROUND * surface.size) < np.inf
    elif isinstance(region, Rim):
        border = np.diff(is_inside(surface)[surface.edges], axis=1)[:, 0]
        chosen = _way(surface, np.unique(surface.edges[border]), region.width or RIM * surface.size) < np.inf
    elif isinstance(region, Segment):
        labels = segments(surface, thickness)
        near = TriangleTree(points, surface.faces).nearest([region.point])
        chosen = labels == labels[surface.faces[near.face[0], near.weights[0].argmax()]]
    else:
        if max(region.indices) >= len(points):
            last = len(points) - 1
            raise BadInput(f"vertex {max(region.indices)} cannot be protected: the standardised surface has vertices 0 to {last}")
        chosen = np.zeros(len(points), bool)
        chosen[list(region.indices)] = True
    if not chosen.any():
        low, high = (" ".join(f"{x:g}" for x in np.round(f(axis=0), 1)) for f in (surface.vertices.min, surface.vertices.max))
        raise BadInput(f"the region {region.words!r} holds nothing of this part, which reaches from {low} to {high} mm")
    return chosen


def faded(surface: SurfaceMesh, chosen: NDArray[np.bool_], ramp: float) -> Floats:
    """Factor on a relief: 0 where chosen, growing linearly to 1 over `ramp` [mm], shape [vertex_count].

    The way is measured along the edges of the surface, not through the air: the other side of a thin wall is far away.
    """
    if ramp == 0.0 or not chosen.any():
        return (~chosen).astype(np.float64)
    return np.asarray(np.minimum(_way(surface, np.flatnonzero(chosen), ramp) / ramp, 1.0))


def _way(surface: SurfaceMesh, start: ArrayLike, limit: float) -> Floats:
    """Way along edges from the nearest of some vertices [mm], infinite beyond a limit, shape [vertex_count]."""
    if not len(np.atleast_1d(start)):
        return np.full(len(surface.vertices), np.inf)
    lengths = np.linalg.norm(np.diff(surface.vertices[surface.edges], axis=1)[:, 0], axis=1)
    return np.asarray(dijkstra(_graph(surface, lengths), directed=False, indices=start, min_only=True, limit=limit))


def segments(surface: SurfaceMesh, thickness: ArrayLike) -> Indices:
    """Smooth pieces of surface of one wall thickness [mm], shape [vertex_count], numbered from 0, of that shape.

    A border is where neighbours' normals differ by more than 25° or where the wall doubles in a step. Connected vertices away from any
    border make a segment if they are half a per cent of the area or more; all others go to the segment nearest along the surface.
    """
    a, b = surface.edges.T
    wall = np.asarray(thickness, dtype=np.float64)
    turned = np.einsum("ij,ij->i", surface.vertex_normals[a], surface.vertex_normals[b]) < TURN
    lengths = np.linalg.norm(surface.vertices[a] - surface.vertices[b], axis=1)
    stepped = np.abs(np.diff(wall[surface.edges], axis=1)[:, 0]) > SLOPE * lengths
    thinner, which = np.unique(surface.edges[np.arange(len(a)), wall[surface.edges].argmin(axis=1)][stepped], return_inverse=True)
    around = cKDTree(surface.vertices).query_ball_point(surface.vertices[thinner], NEAR * wall[thinner])
    doubled = np.array([wall[near].max() > STEP * wall[vertex] for near, vertex in zip(around, thinner, strict=True)], bool)
    stepped[stepped] = doubled[which]
    calm = np.ones(len(wall), bool)
    calm[surface.edges[turned | stepped]] = False
    piece = connected_components(_graph(surface, (calm[a] & calm[b]).astype(np.float64)), directed=False)[1]
    areas = np.bincount(piece, surface.vertex_areas)
    seeds = calm & (areas >= LEAST_SEGMENT * areas.sum())[piece]
    if not seeds.any():
        return np.zeros(len(wall), np.int32)
    found = dijkstra(_graph(surface, lengths), directed=False, indices=np.flatnonzero(seeds), min_only=True, return_predecessors=True)
    nearest = np.where(found[2] >= 0, found[2], np.flatnonzero(seeds)[0])
    return np.unique(piece[nearest], return_inverse=True)[1].astype(np.int32)


def _graph(surface: SurfaceMesh, values: Floats) -> sp.csr_array:
    """Sparse upper triangular matrix with one value per edge; zero means no edge."""
    count = len(surface.vertices)
    kept = values > 0.0
    return sp.csr_array((values[kept], tuple(surface.edges[kept].T)), shape=(count, count))
