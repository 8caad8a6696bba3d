"""Local thickness of walls whose thickness is known."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.geometry.thickness import local_thickness


@pytest.mark.parametrize("wall", [1.5, 4.0])
def test_a_plate_is_as_thick_as_it_is(wall):
    plate = even(surface_of(Manifold.cube((40.0, 30.0, wall), center=True)), 3000)
    thickness = local_thickness(plate)
    inner = (np.abs(plate.vertices[:, 0]) < 20 - wall) & (np.abs(plate.vertices[:, 1]) < 15 - wall)
    assert inner.sum() > 500
    assert thickness[inner] == pytest.approx(wall, rel=0.01)


def test_a_ball_is_as_thick_as_its_diameter():
    ball = even(surface_of(Manifold.sphere(10.0, 64)), 1500)
    assert np.median(local_thickness(ball)) == pytest.approx(20.0, rel=0.02)


def test_the_wall_of_a_cup(cup):
    thickness = local_thickness(cup)
    radius = np.hypot(*cup.vertices[:, :2].T)
    wall = (np.abs(cup.vertices[:, 2] - 16) < 8) & ((np.abs(radius - 20) < 0.1) | (np.abs(radius - 17) < 0.1))
    assert wall.sum() > 300
    assert thickness[wall] == pytest.approx(3.0, rel=0.05)


def test_it_is_positive_finite_and_no_more_than_the_part(cup):
    thickness = local_thickness(cup)
    assert np.isfinite(thickness).all()
    assert thickness.min() > 0
    assert thickness.max() <= cup.size


def test_it_scales_with_the_part(cup):
    assert local_thickness(cup.moved(2 * cup.vertices)) == pytest.approx(2 * local_thickness(cup), rel=1e-3)


def narrow_side(plate, height):
    """The middle of the narrow sides of a plate, away from its corners."""
    x, y, z = np.abs(plate.vertices).T
    return ((x > 20 - 1e-6) & (y < 10) | (y > 15 - 1e-6) & (x < 15)) & (z < 0.5 * height - 1e-6)


def test_the_narrow_side_of_a_plate_is_not_taken_for_thick():
    wall = 3.0
    plate = even(surface_of(Manifold.cube((40.0, 30.0, wall), center=True)), 5000)
    side = narrow_side(plate, wall)
    assert side.sum() > 100
    assert local_thickness(plate, slope=np.inf)[side].min() > 25.0  # the balls look across the whole plate
    assert local_thickness(plate)[side].max() < (np.sqrt(2) + 0.5) * wall  # the diagonal at the edge, and half a wall at slope 1


def test_thickness_grows_no_faster_than_the_slope(cup):
    thickness = local_thickness(cup, slope=0.25)
    a, b = cup.edges.T
    rise = np.abs(thickness[a] - thickness[b])
    assert np.all(rise <= 0.25 * np.linalg.norm(cup.vertices[a] - cup.vertices[b], axis=1) + 1e-9)


def test_a_slope_only_ever_lowers(cup):
    assert np.all(local_thickness(cup, slope=0.25) <= local_thickness(cup, slope=np.inf) + 1e-9)


def test_the_pure_ball_vanishes_at_a_convex_edge_and_the_default_does_not():
    box = even(surface_of(Manifold.cube((20.0, 20.0, 20.0), center=True)), 2000)
    edge = (np.abs(box.vertices) > 10 - 1e-6).sum(axis=1) == 2
    assert np.median(local_thickness(box, separation=0.0, slope=np.inf)[edge]) < 1.0
    assert local_thickness(box)[edge].min() > 10.0


def test_a_wedge_is_thin_at_its_edge_and_thick_at_its_back():
    half = Manifold.cube((40.0, 20.0, 8.0)).trim_by_plane((8.0, 0.0, -40.0), 0.0)  # height 8/40 of the way in x
    wedge = even(surface_of(half), 4000)
    thickness, (x, y, _) = local_thickness(wedge), wedge.vertices.T
    middle = (y > 4) & (y < 16) & (x > 10) & (x < 30) & (wedge.vertex_normals[:, 2] < -0.99)
    angle = np.arctan(8.0 / 40.0)
    inscribed = 2 * x[middle] * np.tan(angle / 2)  # the ball on the underside at x that touches the slope
    assert middle.sum() > 100
    assert np.all(thickness[middle] >= 0.99 * inscribed)
    assert np.all(thickness[middle] <= 1.1 * inscribed)  # as documented
