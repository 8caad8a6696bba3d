"""Borders of protected places follow the feature they belong to, however the triangles lie."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull

from mechstyle import gallery
from mechstyle.geometry.borders import Extent
from mechstyle.geometry.mating import mating_ends
from mechstyle.geometry.region_selection import extent, faded, protection
from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.regions import HalfSpace, Holes, Region, Sphere


def ball() -> SurfaceMesh:
    return even(surface_of(manifold3d.Manifold.sphere(20.0, 96)), 2000)


def half_way(held: Extent) -> np.ndarray:
    """Where the relief grows through half of its height on the edges of a surface, shape [k, 3]: the border that is seen."""
    places, crossed = along_edges(held)
    return places[crossed]


def along_edges(held: Extent) -> tuple[np.ndarray, np.ndarray]:
    """A place on every edge, shape [edge_count, 3], and whether it is one of the border."""
    share, edges = faded(held, 0.0) - 0.5, held.surface.edges
    one, other = share[edges].T
    crossed = one * other < 0
    at = np.where(crossed, one / np.where(crossed, one - other, 1.0), 0.0)
    a, b = held.surface.vertices[edges].transpose(1, 0, 2)
    return a + at[:, None] * (b - a), crossed


def length_over_outline(held: Extent, axis: int) -> float:
    """Length of the longest border over that of its convex outline, seen along an axis: 1 of a smooth one, more of a star."""
    places, crossed = along_edges(held)
    surface = held.surface
    sides = np.sort(surface.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    number = {tuple(edge): at for at, edge in enumerate(surface.edges.tolist())}
    of_face = np.array([number[tuple(side)] for side in sides.tolist()]).reshape(-1, 3)
    through = of_face[crossed[of_face].sum(axis=1) == 2]
    steps = through[crossed[through]].reshape(-1, 2)
    count = len(places)
    loop = connected_components(coo_array((np.ones(len(steps)), steps.T), shape=(count, count)), directed=False)[1][steps[:, 0]]
    lengths = np.bincount(loop, np.linalg.norm(places[steps[:, 0]] - places[steps[:, 1]], axis=1))
    longest = int(lengths.argmax())
    return float(lengths[longest] / ConvexHull(np.delete(places[steps[loop == longest, 0]], axis, axis=1)).area)


@pytest.mark.parametrize(
    ("region", "off"),
    [
        (HalfSpace((0, 0, 5.3), (0.3, 0.2, 1)), lambda points: (points - [0, 0, 5.3]) @ np.array([0.3, 0.2, 1]) / np.sqrt(1.13)),
        (Sphere((15, 9, 9), 11), lambda points: 11 - np.linalg.norm(points - [15, 9, 9], axis=1)),
    ],
    ids=["plane", "sphere"],
)
def test_the_border_of_a_place_runs_even_with_it_at_few_vertices(region: Region, off):
    """It was a row of teeth as long as the edges, 1.6 mm here."""
    surface = ball()
    away = off(half_way(extent(region, surface, np.ones(len(surface.vertices)))))
    assert np.ptp(away) < 0.45 * surface.edge_length
    assert away.max() < 0.0, "what is protected is so up to its border"


def test_the_border_of_a_flat_end_is_the_edge_of_its_rounding():
    """The end of a grip around its slot, seen from the front, was a star: 6 % longer than its outline."""
    held = mating_ends(even(gallery.make("utensil_grip"), 5000))
    assert held.holds.any()
    assert length_over_outline(held, axis=1) < 1.03


def test_the_rim_kept_around_a_hole_is_round():
    """It was a star with ten points."""
    rod = manifold3d.Manifold.cylinder(40, 4, 4, 64).translate((20, 15, -10))
    surface = even(surface_of(manifold3d.Manifold.cube((40, 30, 12)) - rod), 2000)
    held = extent(Holes(), surface, np.ones(len(surface.vertices)))
    places = half_way(held)
    on_top = places[places[:, 2] > 11.99]
    radius = np.hypot(on_top[:, 0] - 20, on_top[:, 1] - 15)
    assert len(on_top) > 20
    assert np.ptp(radius) < 0.5 * surface.edge_length


def test_colours_end_where_the_relief_does():
    surface = ball()
    found = protection([HalfSpace((0, 0, 0), (0, 0, 1), colour=True)], surface, np.ones(len(surface.vertices)))
    assert np.allclose(found.uncoloured, 1.0 - found.freedom, atol=1e-6)
    assert ((found.uncoloured > 0.0) & (found.uncoloured < 1.0)).any()


def test_of_vertices_nothing_is_known_but_that_they_are_held():
    surface = ball()
    holds = surface.vertices[:, 2] > 3.0
    assert np.array_equal(faded(Extent(surface, holds), 0.0), ~holds)
