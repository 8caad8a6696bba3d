"""Patterns on cells of rows, looked at place by place."""

import numpy as np
import pytest

from mechstyle.styling.drawing.canvas import Bond, beneath, fans, hanging


def test_a_scale_and_the_one_beneath_it_meet_where_rows_do():
    row = Bond(np.array([0.0, 0.5, -0.5]), np.array([-0.5, 0.5, 0.5]), np.array([False, False, False]))
    upper = hanging(row)
    assert upper.aside.tolist() == [0.0, 1.0, 1.0]
    assert upper.down.tolist() == [1.0, 0.0, 0.0]  # the tip, and the two upper corners
    lower = beneath(upper)
    assert lower.aside.tolist() == [1.0, 0.0, 0.0]
    assert lower.down.tolist() == [0.0, -1.0, -1.0]


def test_of_overlapping_half_rounds_the_lowest_is_in_front():
    """Centres lie in the middle of cells, two radii apart in a row; the next row's are half a radius below and one aside."""
    x, y = np.array([0.0, 0.5, 0.25]), np.zeros(3)
    reach, angle = fans(Bond(x, y, np.zeros(3, dtype=bool)))
    assert reach == pytest.approx([0.0, 0.5, 0.5**0.5])  # a centre, the place above one, and where both reach: the lower one's
    assert angle == pytest.approx([0.0, 0.0, np.pi / 4.0])
