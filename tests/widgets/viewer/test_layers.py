"""What a checkpoint of a run has to show."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle_widgets.viewer.layers import stress_limit, subject_of


def test_a_checkpoint_shows_every_field_that_is_known_there(done):
    state = done.checkpoint(12)
    subject = subject_of(done, state)
    of_any, of_several = ["stress", "demand", "mask", "displacement", "thickness", "contact"], ["envelope", "probability"]
    assert [layer.name for layer in subject.layers] == of_any + of_several
    assert np.array_equal(subject.layer("stress").values, state.stress)
    assert np.allclose(subject.layer("mask").values, 1.0 - state.mask)
    assert np.array_equal(subject.layer("displacement").values, state.displacement)
    assert np.allclose(subject.mesh.vertices, done.part.surface.displaced(state.displacement).vertices)
    assert subject.mesh.colours is not None


def test_all_orientations_are_shown_only_where_they_were_run(done):
    assert subject_of(done, done.checkpoint(4)).layer("envelope") is None


def test_the_limits_are_those_of_the_verdict_and_of_the_recipe(done):
    subject = subject_of(done, done.checkpoint(4))
    assert subject.layer("stress").threshold == done.history[4].verdict.deciding.limit
    assert subject.layer("demand").threshold == done.recipe.threshold


def test_between_simulations_the_last_verdict_holds_and_its_age_is_told(done):
    state = done.checkpoint(6)
    assert stress_limit(done, state) == done.history[4].verdict.deciding.limit
    assert subject_of(done, state).layer("stress").note == "simulated at iteration 4"
    assert subject_of(done, done.checkpoint(4)).layer("stress").note == ""


def test_displacement_keeps_its_colours_from_iteration_to_iteration(done):
    early, late = (subject_of(done, done.checkpoint(at)).layer("displacement").limits for at in (0, 12))
    assert early == late
    assert late[1] == pytest.approx(np.abs(done.checkpoint(12).displacement).max())
