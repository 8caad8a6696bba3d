"""A levelled relief: never below the floor, never on points, face by face."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from manifold3d import Manifold

from mechstyle.geometry.level_base import LEAST_SHARE, QUANTILES, LevelBase, flat_faces
from mechstyle.geometry.remeshing.evening import even, surface_of


@pytest.fixture(scope="module")
def table():
    """A plate on two square feet, one of them twice as far across as the other."""
    feet = Manifold.cube((20.0, 20.0, 8.0)) + Manifold.cube((10.0, 10.0, 8.0)).translate((50.0, 5.0, 0.0))
    return even(surface_of(feet + Manifold.cube((60.0, 20.0, 4.0)).translate((0.0, 0.0, 6.0))), 4000)


def noise(surface, seed=0, height=0.5):
    return np.random.default_rng(seed).normal(0.0, height, len(surface.vertices)).astype(np.float32)


def waves(surface, height=0.5):
    x, y, _ = surface.vertices.T
    return (height * np.sin(x) * np.sin(y)).astype(np.float32)


def lowest(surface, relief):
    return surface.displaced(relief).vertices[:, 2].min() - surface.vertices[:, 2].min()


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("draw", [noise, lambda surface, seed: waves(surface, 0.3 + seed)], ids=["noise", "waves"])
def test_nothing_goes_below_the_floor_and_every_foot_stands(table, cup, seed, draw):
    for surface in (table, cup):
        base, relief = LevelBase(surface), draw(surface, seed)
        level = base.levelled(relief)
        assert lowest(surface, relief) < -0.1
        assert lowest(surface, level) >= -1e-6
        assert base.share(level) >= LEAST_SHARE
        for face in base.faces:
            assert face.share(level[face.vertices] >= -1e-6) >= LEAST_SHARE


def test_a_shift_to_the_highest_point_would_stand_on_points(table):
    """Why the quantile: all of the contrast is left, and next to nothing of the base."""
    base = LevelBase(table)
    relief = waves(table)
    resting = base.resting == 1.0
    assert base.share(base.clipped(relief - base.resting * relief[resting].max())) < LEAST_SHARE


def test_each_foot_is_levelled_by_its_own_quantile(table):
    base = LevelBase(table)
    assert len(base.faces) == 2
    higher, lower = 0.4, 0.1
    relief = waves(table, 0.2) + np.where(table.vertices[:, 0] > 30, np.float32(higher), np.float32(lower))
    level = base.levelled(relief)
    for face in base.faces:
        order = np.argsort(relief[face.vertices])
        weight = np.cumsum(face.weights[order]) / face.weights.sum()
        highest = (float(relief[face.vertices][order][np.searchsorted(weight, quantile)]) for quantile in QUANTILES)
        wanted = next(height for height in highest if face.share(relief[face.vertices] - face.resting * height >= 0.0) >= LEAST_SHARE)
        assert wanted > 0.0
        within = face.resting == 1.0
        assert level[face.vertices][within] == pytest.approx(np.minimum(relief[face.vertices][within] - wanted, 0.0), abs=1e-5)


def test_a_few_high_places_do_not_draw_the_others_deeper(table):
    """A fifth of a foot stands higher than the quantile: it is cut down to it, and the foot does not come to stand on it alone."""
    base, level = LevelBase(table), 0.3
    relief = np.full(len(table.vertices), level)
    for face in base.faces:
        x = table.vertices[face.vertices, 0]
        relief[face.vertices[x < np.quantile(x, 0.2)]] = 2.0
    for face in base.faces:
        assert face.shift(relief[face.vertices]) == pytest.approx(level)


def test_what_stands_are_the_vertices_of_the_feet_with_their_rims(table):
    base, on_floor = LevelBase(table), table.vertices[:, 2] < 1e-6
    assert np.array_equal(base.standing, on_floor)
    assert base.standing.any()
    assert not base.standing.all()


def test_a_quantile_that_leaves_too_little_is_lowered(table):
    """A step upwards at one vertex in four leaves hardly a triangle that is level at 70 %."""
    base = LevelBase(table)
    relief = noise(table, height=0.3)
    for face in base.faces:
        first = face.shift(relief[face.vertices].astype(np.float64))
        order = np.argsort(relief[face.vertices][face.weights > 0])
        weights = face.weights[face.weights > 0][order]
        highest = relief[face.vertices][face.weights > 0][order][np.searchsorted(np.cumsum(weights), QUANTILES[0] * weights.sum())]
        assert face.share(relief[face.vertices] - face.resting * highest >= 0.0) < LEAST_SHARE
        assert first < highest


def test_a_face_that_no_shift_leaves_level_is_not_cut_at_all(table):
    """All of it a rim that hardly rests, and drawn inwards: a shift does not reach it."""
    base = LevelBase(table)
    face = base.faces[0]
    base.faces = (replace(face, resting=np.zeros_like(face.resting)),)
    level = base.levelled(np.full(len(table.vertices), -1.0))
    assert not level[face.vertices].any()
    assert base.share(level) == 1.0


@given(scale=st.floats(0.01, 3.0))
def test_levelling_scales_and_does_not_care_to_be_done_twice(table, scale):
    base, relief = LevelBase(table), waves(table)
    level, on_faces = base.levelled(relief), base.resting == 1.0
    assert base.levelled(level) == pytest.approx(level, abs=1e-6)
    assert base.levelled(scale * relief)[on_faces] == pytest.approx(scale * level[on_faces], abs=1e-5)


def test_a_relief_that_lies_inwards_already_keeps_its_depth_where_enough_is_level(table):
    base, x = LevelBase(table), table.vertices[:, 0]
    grooves = np.where((x % 4.0) < 2.5, np.float32(-0.4), np.float32(0.0))
    assert np.array_equal(base.levelled(grooves)[base.resting == 1.0], grooves[base.resting == 1.0])


def test_no_relief_stays_none(table):
    base, nothing = LevelBase(table), np.zeros(len(table.vertices), np.float32)
    assert not base.levelled(nothing).any()
    assert base.share(nothing) == 1.0


def test_what_is_drawn_above_the_base_stays_as_it_is(table):
    base, relief = LevelBase(table), noise(table)
    above = table.vertices[:, 2] > 5.0
    assert np.array_equal(base.levelled(relief)[above], relief[above])


def test_a_ball_has_nothing_to_level_but_a_floor_all_the_same(sphere):
    base, relief = LevelBase(sphere), noise(sphere)
    assert flat_faces(sphere) == ()
    assert base.share(relief) is None
    assert np.array_equal(base.contrast(relief), relief)
    assert lowest(sphere, base.levelled(relief)) >= -1e-6
    high = sphere.vertices[:, 2] > -5.0
    assert np.array_equal(base.levelled(relief)[high], relief[high])


def test_a_shift_loses_no_contrast(table):
    base, relief = LevelBase(table), waves(table)
    shifted = relief - np.float32(0.3) * base.resting.astype(np.float32)
    assert base.contrast(shifted) == pytest.approx(base.contrast(relief), abs=1e-6)
