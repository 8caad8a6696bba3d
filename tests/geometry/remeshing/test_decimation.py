"""Fewer triangles, and the same closed surface."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.decimation import decimated
from mechstyle.geometry.remeshing.evening import _shape, surface_of


def test_planes_and_corners_of_a_box_cost_nothing():
    fine = surface_of(Manifold.cube((30.0, 20.0, 10.0)).refine(12))
    fewer = decimated(fine, 100)
    assert len(fewer.faces) == 100
    assert fewer.volume == pytest.approx(6000.0, rel=1e-6)
    assert fewer.extents == pytest.approx([30.0, 20.0, 10.0], abs=1e-3)


def test_a_ring_keeps_its_handle_down_to_the_last_triangles():
    ring = surface_of((Manifold.cylinder(6.0, 15.0, 15.0, 48) - Manifold.cylinder(6.0, 9.0, 9.0, 48)).refine(2))
    for count in (400, 2):
        fewer = decimated(ring, count)
        assert _shape(fewer) == _shape(ring) == (True, 0, 1)
        assert len(fewer.faces) == count or count == 2


def test_a_relief_is_kept_where_triangles_of_its_own_size_would_miss_it():
    """A ridge narrower than even triangles of the same number: the quadrics leave the flat parts to it."""
    plate = Manifold.cube((40.0, 40.0, 4.0)) + Manifold.cube((0.6, 40.0, 1.0)).translate((20.0, 0.0, 4.0))
    fine = surface_of(plate.refine_to_length(2.0))
    fewer = decimated(fine, 400)
    assert TriangleTree(fewer.vertices, fewer.faces).nearest(fine.vertices).distance.max() < 0.05


def test_a_ball_stays_as_round_as_its_number_of_triangles_allows():
    """Facets of edge l miss a sphere of radius r by about l² / 6 r; quadrics put vertices a little outside."""
    ball = surface_of(Manifold.sphere(10.0, 96))
    fewer = decimated(ball, 600)
    edge = np.sqrt(4.0 / np.sqrt(3.0) * ball.face_areas.sum() / 600)
    assert TriangleTree(fewer.vertices, fewer.faces).nearest(ball.vertices).distance.max() < edge**2 / 20.0
    assert fewer.volume == pytest.approx(ball.volume, rel=0.01)


def test_the_same_input_gives_the_same_bytes_and_enough_triangles_stay_as_they_are():
    ball = surface_of(Manifold.sphere(10.0, 48))
    assert decimated(ball, 300).digest == decimated(ball, 300).digest
    assert np.array_equal(decimated(ball, len(ball.faces)).faces, ball.faces)


def test_it_is_asked_before_every_round_whether_to_go_on(sphere):
    asked = []
    decimated(sphere, 100, lambda: asked.append(len(asked)))
    assert len(asked) > 3

    def enough():
        raise InterruptedError

    with pytest.raises(InterruptedError):
        decimated(sphere, 100, enough)
