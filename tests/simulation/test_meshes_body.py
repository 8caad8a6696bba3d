"""Tetrahedra of a part: what they are made for, how well they follow a relief, and when they are good enough to judge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.geometry.thickness import local_thickness
from mechstyle.records.simulation import LEAST_CARRIED, VOLUME_ERROR
from mechstyle.simulation.meshes import Body, Followed
from mechstyle.simulation.part import Shape, Workpiece, carrying, refilled


@pytest.fixture(scope="module")
def slab():
    return even(surface_of(Manifold.cube((24.0, 16.0, 6.0))), 1500)


def body(slab, tets, at, nozzle=0.0):
    """Tetrahedra; a nozzle of no width prints everything."""
    return Body(Shape(slab, local_thickness(slab)), tets, nozzle, at=at)


@pytest.fixture(scope="module")
def relief(slab):
    x, y, z = slab.vertices.T
    return (-0.3 * (1.0 + np.sin(1.5 * x) * np.cos(1.5 * y) * np.cos(1.5 * z))).astype(np.float32)


@pytest.fixture(scope="module")
def filled(slab, relief):
    return carrying(slab, relief)


def test_they_are_made_for_half_of_it_and_carry_all_of_it(slab, relief, filled):
    tets, half = filled
    assert half == pytest.approx(0.5 * relief)
    made = body(slab, tets, half)
    fit = made.followed(made.morph.morphed(relief))
    assert fit.enough
    assert fit.whole == pytest.approx(1.0, abs=0.1)
    assert fit.base == pytest.approx(1.0, abs=0.1)


def test_a_base_that_is_laid_flat_but_left_hanging_is_not_carried(slab, relief, filled):
    """Deep bricks under a grip: with the base laid flat half of its nodes stayed tenths of a millimetre above the floor."""
    made = body(slab, *filled)
    base = made.shape.level_base
    flat = np.where(base.standing, np.float32(0.0), relief)
    followed = made.morph.morphed(flat)
    assert made.followed(followed).grounded > 0.95
    hanging = replace(followed, followed=np.where(base.standing & (slab.vertices[:, 0] > 12.0), np.float32(-0.2), followed.followed))
    fit = made.followed(hanging)
    assert 0.3 < fit.grounded < 0.7
    assert not fit.enough
    assert "of its base off the floor" in fit.words
    assert Followed(1.0, None, 0.0).is_at_least_as_good_as(fit)
    assert not fit.is_at_least_as_good_as(fit)


def test_a_plain_base_has_no_relief_that_could_be_missed_whatever_lies_beside_it(slab, relief, filled):
    """-153 % of what lies beside its edge were once followed, which is no share of anything."""
    made = body(slab, *filled, nozzle=4.0)
    above = np.where(made.shape.level_base.standing, np.float32(0.0), relief)
    assert made.followed(made.morph.morphed(above)).base is None


def test_what_goes_the_other_way_follows_nothing(slab, relief, filled):
    made = body(slab, *filled)
    morphed = made.morph.morphed(relief)
    assert made.followed(replace(morphed, followed=-morphed.followed))[:2] == (0.0, 0.0)


def test_without_relief_nothing_is_to_be_carried(slab, relief, filled):
    made = body(slab, *filled)
    assert made.followed(made.morph.morphed(np.zeros_like(relief)))[:2] == (1.0, None)


def test_what_is_finer_than_a_nozzle_does_not_count_as_missed(slab, relief, filled):
    """The boundary misses ripples of one sign at every other vertex, which no printer could show."""
    made, wide = body(slab, *filled), body(slab, *filled, nozzle=4.0)
    followed = made.morph.morphed(relief)
    ripples = np.where(made.shape.level_base.standing, 0.0, np.random.default_rng(0).choice([-0.5, 0.5], len(relief))).astype(np.float32)
    rippled = replace(followed, displacement=relief + ripples)
    assert made.followed(rippled).whole < 0.7
    assert wide.followed(rippled).whole > 0.85


@pytest.mark.parametrize(
    ("fit", "enough"),
    [
        (Followed(LEAST_CARRIED, None, 0.0), True),
        (Followed(LEAST_CARRIED - 0.01, None, 0.0), False),
        (Followed(1.0, LEAST_CARRIED - 0.01, 0.0), False),
        (Followed(1.0, 1.0, 1.01 * VOLUME_ERROR), False),
        (Followed(1.0, 1.0, -1.01 * VOLUME_ERROR), False),
        (Followed(float("nan"), 1.0, 0.0), False),
        (Followed(1.0, float("nan"), 0.0), False),
        (Followed(1.0, None, 0.0, grounded=LEAST_CARRIED), True),
        (Followed(1.0, None, 0.0, grounded=LEAST_CARRIED - 0.01), False),
    ],
)
def test_whole_base_and_volume_each_must_be_good_enough(fit, enough):
    assert fit.enough == enough


@pytest.mark.parametrize(
    ("fit", "under"),
    [
        (Followed(0.5, None, 0.0), None),
        (Followed(0.5, 0.95, 0.0, grounded=0.97), 0.95),
        (Followed(0.5, 0.95, 0.0, grounded=0.6), 0.6),
        (Followed(0.5, None, 0.0, grounded=0.6), 0.6),
    ],
)
def test_a_base_that_is_off_the_floor_where_the_surface_is_on_it_counts(fit, under):
    assert fit.under == under


def test_a_part_is_filled_again_for_another_relief_and_left_alone_where_it_is_not_known(slab, relief, filled):
    tets, half = filled
    part = Workpiece(slab, tets, np.full(len(slab.vertices), 6.0, np.float32), True, at=half)
    assert refilled(part, lambda _, **__: None) is part
    again = refilled(part, lambda _, **__: relief)
    assert again.tets.digest == tets.digest, "cached by content"
    other = refilled(part, lambda _, **__: 0.5 * relief)
    assert other.tets.digest != tets.digest
    assert other.at == pytest.approx(0.25 * relief)


def test_a_run_that_is_told_to_stop_does_not_wait_for_the_mesh(slab, monkeypatch, tmp_path):
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path))

    def stop():
        raise InterruptedError

    with pytest.raises(InterruptedError):
        carrying(slab, np.full(len(slab.vertices), 0.1, np.float32), stop)
    assert not list(tmp_path.rglob("*.npz"))
