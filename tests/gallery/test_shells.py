"""Thin walls around an axis, on a cone and a fluted tube whose thickness is known."""

import math

import numpy as np
import pytest

from mechstyle.gallery import _solids as _shells

TURN = _shells.angles(0)
LEVEL = np.linspace(0.0, 40.0, 41)


def test_the_wall_of_a_cone_is_as_thick_along_its_normal_as_asked():
    lean = 0.5
    outer = np.repeat((60.0 - lean * LEVEL)[:, None], len(TURN), axis=1)
    inner = _shells.inner_radius(outer, LEVEL, TURN, 3.0)
    assert (outer - inner) / math.hypot(1.0, lean) == pytest.approx(3.0)


def test_the_wall_of_a_fluted_tube_is_thicker_across_where_it_runs_slantwise():
    outer = np.repeat((50.0 + 2.0 * np.cos(8 * TURN))[None], len(LEVEL), axis=0)
    across = (outer - _shells.inner_radius(outer, LEVEL, TURN, 2.0))[0]
    steepest = np.abs(np.sin(8 * TURN)).argmax()
    assert across[0] == pytest.approx(2.0)
    assert across[steepest] == pytest.approx(2.0 * math.hypot(1.0, 2 * 8 / 50), rel=0.01)


def test_a_bowl_follows_the_wall_down_and_runs_out_onto_the_floor():
    inner = np.repeat((20.0 + 0.2 * LEVEL)[:, None], 7, axis=1)
    radius, level = _shells.bowl(inner, LEVEL, 3.0, 5.0)
    wall = level > 8.0 + 1e-9
    assert radius[wall, 0] == pytest.approx(20.0 + 0.2 * level[wall])
    assert (np.diff(level) < 0).all()
    assert level[-1] == pytest.approx(3.0)
    assert radius[-1, 0] == pytest.approx(20.0 + 0.2 * 3.0 - 5.0)
