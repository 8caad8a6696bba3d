"""Tetrahedra that carry a relief: what they are made for, and when they are good enough to judge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.geometry.level_base import LevelBase
from mechstyle.geometry.morph import Morph
from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.geometry.transfer import SurfaceMean
from mechstyle.records.simulation import LEAST_CARRIED, VOLUME_ERROR
from mechstyle.simulation.carrying import Carried, carried, carrying
from mechstyle.simulation.part import Workpiece, refilled


@pytest.fixture(scope="module")
def slab():
    return even(surface_of(Manifold.cube((24.0, 16.0, 6.0))), 1500)


def as_it_is(relief):
    """A printer that prints everything."""
    return relief


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
    morph, base = Morph(slab, tets, half), LevelBase(slab)
    fit = carried(morph, morph.morphed(relief), base, as_it_is)
    assert fit.enough
    assert fit.whole == pytest.approx(1.0, abs=0.1)
    assert fit.base == pytest.approx(1.0, abs=0.1)


def test_a_base_that_is_laid_flat_but_left_hanging_is_not_carried(slab, relief, filled):
    """Deep bricks under a grip: with the base laid flat half of its nodes stayed tenths of a millimetre above the floor."""
    made, half = filled
    morph, base = Morph(slab, made, half), LevelBase(slab)
    flat = np.where(base.standing, np.float32(0.0), relief)
    followed = morph.morphed(flat)
    assert carried(morph, followed, base, as_it_is).stands > 0.95
    hanging = replace(followed, followed=np.where(base.standing & (slab.vertices[:, 0] > 12.0), np.float32(-0.2), followed.followed))
    fit = carried(morph, hanging, base, as_it_is)
    assert 0.3 < fit.stands < 0.7
    assert not fit.enough
    assert "of its base off the floor" in fit.words
    assert Carried(1.0, None, 0.0).serves_instead_of(fit)
    assert not fit.serves_instead_of(fit)


def test_without_relief_nothing_is_to_be_carried(slab, relief, filled):
    tets, half = filled
    morph = Morph(slab, tets, half)
    assert carried(morph, morph.morphed(np.zeros_like(relief)), LevelBase(slab), as_it_is)[:2] == (1.0, None)


def test_what_is_finer_than_a_nozzle_does_not_count_as_missed(slab, relief, filled):
    """The boundary misses ripples of one sign at every other vertex, which no printer could show."""
    tets, half = filled
    morph, base = Morph(slab, tets, half), LevelBase(slab)
    followed = morph.morphed(relief)
    ripples = np.where(base.standing, 0.0, np.random.default_rng(0).choice([-0.5, 0.5], len(relief))).astype(np.float32)
    rippled = replace(followed, displacement=relief + ripples)
    assert carried(morph, rippled, base, as_it_is).whole < 0.7
    assert carried(morph, rippled, base, SurfaceMean(slab, 2.0)).whole > 0.85


@pytest.mark.parametrize(
    ("fit", "enough"),
    [
        (Carried(LEAST_CARRIED, None, 0.0), True),
        (Carried(LEAST_CARRIED - 0.01, None, 0.0), False),
        (Carried(1.0, LEAST_CARRIED - 0.01, 0.0), False),
        (Carried(1.0, 1.0, 1.01 * VOLUME_ERROR), False),
        (Carried(1.0, 1.0, -1.01 * VOLUME_ERROR), False),
        (Carried(float("nan"), 1.0, 0.0), False),
        (Carried(1.0, float("nan"), 0.0), False),
        (Carried(1.0, None, 0.0, stands=LEAST_CARRIED), True),
        (Carried(1.0, None, 0.0, stands=LEAST_CARRIED - 0.01), False),
    ],
)
def test_whole_base_and_volume_each_must_be_good_enough(fit, enough):
    assert fit.enough == enough


@pytest.mark.parametrize(
    ("fit", "under"),
    [
        (Carried(0.5, None, 0.0), None),
        (Carried(0.5, 0.95, 0.0, stands=0.97), 0.95),
        (Carried(0.5, 0.95, 0.0, stands=0.6), 0.6),
        (Carried(0.5, None, 0.0, stands=0.6), 0.6),
    ],
)
def test_a_base_that_does_not_stand_where_the_surface_does_is_told_the_verdict(fit, under):
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
