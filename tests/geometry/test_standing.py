"""A part on the bed: areas and heights that can be worked out by hand."""

import numpy as np
import pytest

from mechstyle.geometry.upright import standing
from mechstyle.records.mesh import SurfaceMesh


def test_a_cube_on_its_side_hangs_nowhere(cube):
    for up in np.concatenate([np.eye(3), -np.eye(3)]):
        assert standing(cube, 3.0 * up) == pytest.approx((0.0, 10.0, 100.0))


def test_a_cube_leans_out_by_45_degrees_on_its_edge_and_by_less_on_its_corner(cube):
    edge = standing(cube, (0.0, 1.0, 1.001))
    assert edge.overhang == pytest.approx(100.0)  # the steeper of two sides, by a hair
    assert edge.base == 0.0
    corner = standing(cube, (1.0, 1.0, 1.0))  # three sides lean out by 35.3 degrees from upright
    assert corner.overhang == 0.0
    assert corner.height == pytest.approx(10.0 * np.sqrt(3.0))


def test_the_cap_of_a_sphere_hangs(sphere):
    """A cap from the pole to 45 degrees has 2 pi r² (1 - cos 45°); the little that lies on the bed is none of it."""
    found = standing(sphere, (0.0, 0.0, 1.0))
    cap = 2.0 * np.pi * 100.0 * (1.0 - np.sqrt(0.5))
    assert found.overhang + found.base == pytest.approx(cap, rel=0.02)
    assert 0.0 < found.base < 2.0 * np.pi * 10.0 * 0.2 * 1.01


def test_a_table_hangs_with_its_underside(cube):
    top = cube.moved(cube.vertices * (1.0, 1.0, 0.1) + (0.0, 0.0, 20.0))
    leg = cube.moved(cube.vertices * (0.1, 0.1, 1.99))
    table = SurfaceMesh(np.concatenate([top.vertices, leg.vertices]), np.concatenate([top.faces, leg.faces + 8]))
    assert standing(table, (0.0, 0.0, 1.0)) == pytest.approx((100.0, 21.0, 1.0))
    assert standing(table, (0.0, 0.0, -1.0)).overhang == pytest.approx(1.0)  # the end of the leg, which is a body of its own
