"""Local thickness of walls whose thickness is known."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.geometry.standardise import standardise, surface_of
from mechstyle.geometry.thickness import local_thickness


@pytest.mark.parametrize("wall", [1.5, 4.0])
def test_a_plate_is_as_thick_as_it_is(wall):
    plate = standardise(surface_of(Manifold.cube((40.0, 30.0, wall), center=True)), 3000)
    thickness = local_thickness(plate)
    inner = (np.abs(plate.vertices[:, 0]) < 20 - wall) & (np.abs(plate.vertices[:, 1]) < 15 - wall)
    assert inner.sum() > 500
    assert thickness[inner] == pytest.approx(wall, rel=0.01)


def test_a_ball_is_as_thick_as_its_diameter():
    ball = standardise(surface_of(Manifold.sphere(10.0, 64)), 1500)
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
