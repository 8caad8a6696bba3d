"""Nearest points on surfaces where they are known."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.evening import surface_of


@pytest.fixture(scope="module")
def cube():
    return surface_of(Manifold.cube((10.0, 10.0, 10.0), center=True).refine(4))


@pytest.fixture(scope="module")
def outside():
    """Points within 2 mm outside the cube of 10 mm."""
    points = np.random.default_rng(0).uniform(-7.0, 7.0, (500, 3))
    return points[np.abs(points).max(axis=1) > 5.0]


def test_the_nearest_point_of_a_cube_is_the_point_clipped_to_it(cube, outside):
    near = TriangleTree(cube.vertices, cube.faces).nearest(outside)
    clipped = np.clip(outside, -5.0, 5.0)
    assert near.point == pytest.approx(clipped, abs=1e-5)  # single precision of a 14 mm span
    assert near.distance == pytest.approx(np.linalg.norm(outside - clipped, axis=1), abs=1e-5)


def test_the_point_is_what_face_and_weights_say(cube, outside):
    near = TriangleTree(cube.vertices, cube.faces).nearest(outside)
    assert np.einsum("ij,ijk->ik", near.weights, cube.corners[near.face]) == pytest.approx(near.point, abs=1e-12)
    assert near.weights.min() >= 0.0
    assert near.weights.sum(axis=1) == pytest.approx(1.0, abs=1e-12)


def test_what_lies_beyond_reach_is_infinitely_far(cube, outside):
    tree = TriangleTree(cube.vertices, cube.faces)
    everything, near, none = tree.nearest(outside), tree.nearest(outside, 1.0), tree.nearest(np.empty((0, 3)), 1.0)
    within = everything.distance < 1.0
    assert within.any()
    np.testing.assert_array_equal(near.distance, np.where(within, everything.distance, np.inf))
    np.testing.assert_array_equal(near.face, np.where(within, everything.face, -1))
    assert none.distance.shape == (0,)


def test_far_from_the_origin_is_as_exact_as_near_it(cube, outside):
    far = np.array([1e5, -2e5, 3e5])
    here = TriangleTree(cube.vertices, cube.faces).nearest(outside).distance
    assert TriangleTree(cube.vertices + far, cube.faces).nearest(outside + far).distance == pytest.approx(here, abs=1e-5)


def test_interpolation_of_positions_gives_the_nearest_points(cube, outside):
    tree = TriangleTree(cube.vertices, cube.faces)
    assert tree.interpolation(outside) @ cube.vertices == pytest.approx(tree.nearest(outside).point, abs=1e-12)


def test_no_query_has_no_answer(cube):
    assert TriangleTree(cube.vertices, cube.faces).nearest(np.zeros((0, 3))).point.shape == (0, 3)
