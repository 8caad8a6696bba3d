"""Even triangles on a closed surface, which stays the closed surface it is."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings
from manifold3d import Manifold

from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.evening import _fixed, _shape, surface_of
from mechstyle.geometry.remeshing.isotropic import isotropic
from mechstyle.records.mesh import SurfaceMesh

NONE = np.empty(0, np.int32)


def evened(body: Manifold, edge: float, iterations: int = 6) -> tuple[SurfaceMesh, SurfaceMesh, np.ndarray]:
    """The even surface, the one it was made from, and the places of the vertices on creases."""
    part, fine = surface_of(body), surface_of(body.refine_to_length(edge))
    creases, rounds = _fixed(fine, edge)
    tree = TriangleTree(part.vertices, part.faces)
    return isotropic(fine, edge, tree, creases=creases, rounds=rounds, iterations=iterations), part, fine.vertices[creases]


def lengths(mesh: SurfaceMesh) -> np.ndarray:
    one, other = mesh.vertices[mesh.edges].transpose(1, 0, 2)
    return np.linalg.norm(other - one, axis=1)


def test_a_sphere_gets_edges_of_one_length():
    even, part, _ = evened(Manifold.sphere(10.0, 64), 1.5)
    long = lengths(even)
    assert long.mean() == pytest.approx(1.5, rel=0.08)
    assert long.std() / long.mean() < 0.15
    assert _shape(even) == _shape(part)
    assert np.abs(np.linalg.norm(even.vertices, axis=1) - 10.0).max() < 0.05  # facets of 64 segments lie up to 0.024 mm inside


def test_regular_triangles_have_six_neighbours_nearly_everywhere():
    even, _, _ = evened(Manifold.sphere(10.0, 64), 1.0)
    valence = np.bincount(even.faces.ravel())
    assert np.mean(np.abs(valence - 6) <= 1) > 0.95


def test_vertices_on_creases_come_first_and_stay_exactly_where_they_are():
    even, part, creases = evened(Manifold.cube((30.0, 20.0, 10.0)), 1.5)
    assert np.array_equal(even.vertices[: len(creases)], creases)
    assert even.volume == pytest.approx(part.volume, rel=1e-6)


def test_the_sides_of_a_wall_thinner_than_its_triangles_do_not_mix():
    """A vertex put down on the nearest place could land on the other side."""
    even, part, _ = evened(Manifold.cylinder(20.0, 10.0, 10.0, 96) - Manifold.cylinder(20.0, 9.7, 9.7, 96), 1.2)
    assert _shape(even) == _shape(part)
    assert even.volume == pytest.approx(part.volume, rel=0.02)


def test_handles_are_kept():
    ring = Manifold.cylinder(6.0, 15.0, 15.0, 48) - Manifold.cylinder(6.0, 9.0, 9.0, 48)
    even, _, _ = evened(ring, 2.0)
    assert _shape(even) == (True, 0, 1)


def test_the_same_input_gives_the_same_bytes():
    body = Manifold.sphere(8.0, 40)
    assert evened(body, 1.2)[0].digest == evened(body, 1.2)[0].digest


def test_an_even_surface_stays_as_even_and_of_the_same_size():
    even, part, _ = evened(Manifold.sphere(10.0, 64), 1.5)
    again = isotropic(even, 1.5, TriangleTree(part.vertices, part.faces), creases=NONE, rounds=NONE, iterations=3)
    assert len(again.vertices) == pytest.approx(len(even.vertices), rel=0.03)
    assert lengths(again).std() <= 1.05 * lengths(even).std()


@settings(max_examples=12)
@given(
    places=st.lists(st.tuples(*[st.floats(-8.0, 8.0)] * 3, st.floats(2.0, 6.0)), min_size=1, max_size=4),
    edge=st.floats(0.8, 3.0),
)
def test_a_closed_surface_stays_one_with_its_shells_and_handles(places, edge):
    body = Manifold()
    for x, y, z, size in places:
        body += Manifold.cube((size, size, size), center=True).rotate((10 * x, 10 * y, 10 * z)).translate((x, y, z))
    even, _, _ = evened(body, edge, iterations=3)
    assert _shape(even) == _shape(surface_of(body.refine_to_length(edge)))
