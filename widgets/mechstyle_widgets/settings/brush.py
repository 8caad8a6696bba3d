"""Painting what is protected from the style: balls set down on the part by clicks, and shown on it at once."""

from __future__ import annotations

import math
from collections.abc import Sequence

import manifold3d
import numpy as np
from numpy.typing import NDArray

from mechstyle.geometry.region_selection import selected
from mechstyle.geometry.remeshing.evening import manifold_of, surface_of
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.regions import Box, HalfSpace, Point, Region, Sphere

FACES = 15_000
"""About as many triangles show where a ball ends, however few a flat wall needs."""
AGAIN = 0.5
"""A click this near to the middle of a ball, as a share of its radius, takes it away."""


def dabbed(regions: Sequence[Region], place: Point, radius: float) -> tuple[Region, ...]:
    """The regions with one more ball, or without the one that was clicked on once more.

    Args:
        regions: What is protected already.
        place: Where was clicked [mm].
        radius: Radius of the ball [mm].
    """
    hit = [one for one in regions if isinstance(one, Sphere) and math.dist(one.centre, place) <= AGAIN * one.radius]
    if hit:
        return tuple(one for one in regions if one is not hit[-1])
    x, y, z = (round(float(value), 2) for value in place)
    return (*regions, Sphere((x, y, z), radius))


def covered(regions: Sequence[Region], mesh: SurfaceMesh) -> NDArray[np.bool_]:
    """Whether each vertex lies in a ball, a box or a half-space among the regions, shape [vertex_count].

    The others take seconds to find, and a click must be answered at once.

    Raises:
        BadInput: If one of them holds nothing of the part.
    """
    chosen = np.zeros(len(mesh.vertices), bool)
    for region in regions:
        if isinstance(region, Sphere | Box | HalfSpace):
            chosen |= selected(region, mesh, ())
    return chosen


def paintable(mesh: SurfaceMesh) -> SurfaceMesh:
    """The same surface in triangles small enough to show where a ball ends; as it is where it is coloured or not closed."""
    body = manifold_of(mesh)
    if mesh.colours is not None or body.status() != manifold3d.Error.NoError or body.is_empty():
        return mesh
    edge = math.sqrt(4.0 / math.sqrt(3.0) * float(mesh.face_areas.sum()) / FACES)  # of an equilateral triangle of the mean area
    return surface_of(body.refine_to_length(edge))
