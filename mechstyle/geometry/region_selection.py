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
from mechstyle.geometry.borders import Extent
from mechstyle.geometry.inside_outside import HALF, in_hole, insideness
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
    uncoloured: NDArray[np.float32]  # share of the part's own colour that a vertex keeps, in [0, 1], shape [vertex_count], float32
    notes: tuple[str, ...]  # one sentence for each region: what it is and how much of the surface it holds


def protection(
    regions: Sequence[Region], surface: SurfaceMesh, thickness: ArrayLike, also: Sequence[tuple[Extent, float]] = ()
) -> Protection:
    """Freedom left by all regions together; where several meet, the strictest counts.

    The local wall thickness [mm], shape [vertex_count], sets segments apart. What is protected also, each with the ramp around it [mm],
    keeps its colour and gets no note. BadInput if a region holds nothing, or nothing is left to style.
    """
    count = len(surface.vertices)
    freedom, uncoloured, notes = np.ones(count), np.zeros(count), []
    areas = surface.vertex_areas / surface.vertex_areas.sum()
    found = [(extent(region, surface, thickness), region.ramp, region.colour) for region in regions]
    for region, (held, _, _) in zip(regions, found, strict=True):
        notes.append(f"protected: {region.words}, {areas[held.holds].sum():.0%} of the surface")
    for held, ramp, colour in (*found, *((held, ramp, True) for held, ramp in also)):
        freedom = np.minimum(freedom, faded(held, ramp))
        uncoloured = np.maximum(uncoloured, colour * (1.0 - faded(held, 0.0)))
    if not freedom.any():
        raise BadInput("the protected regions hold all of the surface, so nothing is left to style; protect less")
    return Protection(freedom.astype(np.float32), uncoloured.astype(np.float32), tuple(notes))


def selected(region: Region, surface: SurfaceMesh, thickness: ArrayLike) -> NDArray[np.bool_]:
    """Whether each vertex lies in a region, shape [vertex_count]; thickness in mm, of that shape; BadInput if none does."""
    return extent(region, surface, thickness).holds


def extent(region: Region, surface: SurfaceMesh, thickness: ArrayLike) -> Extent:
    """What a region holds, and where its border crosses the edges; as `selected`."""
    found = _extent(region, surface, thickness)
    if not found.holds.any():
        points = surface.vertices
        low, high = (" ".join(f"{x:g}" for x in np.round(f(axis=0), 1)) for f in (points.min, points.max))
        raise BadInput(f"the region {region.words!r} holds nothing of this part, which reaches from {low} to {high} mm")
    return found


def _extent(region: Region, surface: SurfaceMesh, thickness: ArrayLike) -> Extent:
    found: Extent
    if isinstance(region, Shape):
        found = Extent.where(surface, lambda points, _: region.contains(points))
    elif isinstance(region, End):
        found = Extent.below(surface, region.beyond(surface.vertices))
    elif isinstance(region, Inside):
        found = inside(surface)
    elif isinstance(region, Outside):
        found = Extent.below(surface, insideness(surface) - HALF)
    elif isinstance(region, Sides):
        found = Extent.below(surface, np.abs(surface.vertex_normals[:, 2]) - np.nextafter(UPRIGHT, 0.0))
    elif isinstance(region, Holes):
        hole = Extent.where(surface, in_hole(surface, region.width or HOLE * surface.size))
        found = Extent.below(surface, hole.way() - AROUND * surface.size)
    elif isinstance(region, Rim):
        found = Extent.below(surface, inside(surface).way(to_both_sides=True) - (region.width or RIM * surface.size))
    elif isinstance(region, Segment):
        labels = segments(surface, thickness)
        near = TriangleTree(surface.vertices, surface.faces).nearest([region.point])
        found = Extent(surface, labels == labels[surface.faces[near.face[0], near.weights[0].argmax()]])
    else:
        last = len(surface.vertices) - 1
        if max(region.indices) > last:
            raise BadInput(f"vertex {max(region.indices)} cannot be protected: the standardised surface has vertices 0 to {last}")
        found = Extent(surface, np.isin(np.arange(last + 1), region.indices))
    return found


def inside(surface: SurfaceMesh) -> Extent:
    """The surfaces of hollows that open to the outside."""
    level = HALF - insideness(surface)
    return Extent.below(surface, np.where(level == 0.0, np.finfo(float).tiny, level))


def faded(held: Extent, ramp: float) -> Floats:
    """Factor on a relief: 0 in a region, growing linearly to 1 over `ramp` [mm] from its border, shape [vertex_count].

    Over the length of an edge at least, where it is known how far along the edges the border lies: else it would be as ragged as they
    are. The way is measured along the edges of the surface, not through the air: the other side of a thin wall is far away.
    """
    over = ramp if held.crossings is None else max(ramp, held.surface.edge_length)
    if over == 0.0 or not held.holds.any():
        return (~held.holds).astype(np.float64)
    return np.asarray(np.minimum(held.way(over) / over, 1.0))


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
