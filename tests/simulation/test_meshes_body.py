"""Tetrahedra of a part: what they are made for, how well they follow a relief, and when they are good enough to judge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.geometry.thickness import local_thickness
from mechstyle.records.simulation import LEAST_GROUNDED, THICKER, VOLUME_ERROR
from mechstyle.simulation.meshes import Body, Followed
from mechstyle.simulation.part import Shape, Workpiece, mesh_for_relief, refilled


@pytest.fixture(scope="module")
def slab():
    return even(surface_of(Manifold.cube((24.0, 16.0, 6.0))), 1500)


def body(slab, tets, at, nozzle=0.0):
    """Tetrahedra; a nozzle of no width prints everything."""
    return Body(walled(slab), tets, nozzle, at=at)


def walled(slab):
    return Shape(slab, local_thickness(slab).astype(np.float32))


@pytest.fixture(scope="module")
def relief(slab):
    x, y, z = slab.vertices.T
    return (-0.3 * (1.0 + np.sin(1.5 * x) * np.cos(1.5 * y) * np.cos(1.5 * z))).astype(np.float32)


@pytest.fixture(scope="module")
def filled(slab, relief):
    return mesh_for_relief(walled(slab), relief)


def test_they_are_made_for_half_of_it_and_carry_all_of_it(slab, relief, filled):
    tets, half = filled
    assert half == pytest.approx(0.5 * relief)
    made = body(slab, tets, half)
    fit = made.followed(made.morph.morphed(relief))
    assert fit.enough
    assert fit.whole == pytest.approx(1.0, abs=0.1)
    assert fit.thicker <= THICKER


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
    assert f"{fit.grounded:.0%} of the base on the floor in the mesh" in fit.words
    assert Followed(1.0, 0.0).is_at_least_as_good_as(fit)
    assert not fit.is_at_least_as_good_as(fit)


def test_what_goes_the_other_way_follows_nothing(slab, relief, filled):
    made = body(slab, *filled)
    morphed = made.morph.morphed(relief)
    fit = made.followed(replace(morphed, followed=-morphed.followed))
    assert fit.whole == 0.0
    assert fit.thicker > THICKER
    assert not fit.enough


def test_without_relief_nothing_is_to_be_carried(slab, relief, filled):
    made = body(slab, *filled)
    fit = made.followed(made.morph.morphed(np.zeros_like(relief)))
    assert (fit.whole, fit.thicker) == (1.0, 0.0)


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
        (Followed(0.0, 0.0), True),
        (Followed(1.0, 1.01 * VOLUME_ERROR), False),
        (Followed(1.0, -1.01 * VOLUME_ERROR), False),
        (Followed(1.0, float("nan")), False),
        (Followed(1.0, 0.0, grounded=LEAST_GROUNDED), True),
        (Followed(1.0, 0.0, grounded=LEAST_GROUNDED - 0.01), False),
        (Followed(1.0, 0.0, grounded=float("nan")), False),
        (Followed(1.0, 0.0, thicker=THICKER), True),
        (Followed(1.0, 0.0, thicker=THICKER + 0.01), False),
        (Followed(1.0, 0.0, thicker=float("nan")), False),
    ],
)
def test_thickness_base_and_volume_each_must_be_good_enough(fit, enough):
    assert fit.enough == enough


def test_a_part_is_filled_again_for_another_relief_and_left_alone_where_it_is_not_known(slab, relief, filled):
    tets, half = filled
    part = Workpiece(slab, tets, walled(slab).thickness, True, at=half)
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
        mesh_for_relief(walled(slab), np.full(len(slab.vertices), 0.1, np.float32), stop)
    assert not list(tmp_path.rglob("*.npz"))
