"""Balls set down and taken away, and what of them can be shown at once."""

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.records.regions import Inside, Sphere, regions
from mechstyle_widgets.settings.regions import FACES, covered, dabbed, paintable


def test_a_click_beside_a_ball_adds_one_and_a_click_in_its_middle_takes_it_away():
    one = dabbed((Inside(),), (0.001, 0.0, 0.0), 4.0)
    assert one == (Inside(), Sphere((0.0, 0.0, 0.0), 4.0))
    two = dabbed(one, (3.0, 0.0, 0.0), 4.0)
    assert len(two) == 3
    assert dabbed(two, (3.5, 0.0, 0.0), 4.0) == one
    assert dabbed(one, (0.0, 1.0, 0.0), 4.0) == (Inside(),)


def test_places_are_covered_and_what_takes_seconds_is_left_out(sphere):
    ball, half = covered(regions(["sphere 0 0 10 4", "inside"]), sphere), covered(regions("above 0"), sphere)
    assert np.array_equal(ball, np.linalg.norm(sphere.vertices - (0, 0, 10), axis=1) <= 4.0)
    assert np.array_equal(half, sphere.vertices[:, 2] >= 0.0)
    assert not covered((), sphere).any()
    with pytest.raises(BadInput, match="holds nothing"):
        covered(regions("above 99"), sphere)


def test_a_coarse_part_becomes_fine_enough_and_keeps_its_shape(cube):
    fine = paintable(cube)
    assert FACES / 2 < len(fine.faces) < 4 * FACES
    assert np.allclose(fine.extents, cube.extents)
    assert fine.face_areas.sum() == pytest.approx(cube.face_areas.sum(), rel=1e-9)
