"""What a checkpoint of a run has to show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mechstyle.pictures.fields import safety_factor
from mechstyle.runs import run as module
from mechstyle.runs.report.replay_data import replay_data
from mechstyle_widgets.viewer.layers import subject_of
from mechstyle_widgets.viewer.probe import brief, table
from support.lanes import lane_on_a_sheet


@pytest.fixture
def growing(tmp_path):
    """A lane whose last iteration has the largest relief, stress and demand of all."""
    settings = {"control": "none", "guarantee": False, "threshold": 0.5, "normalisation": "own_max"}
    return lane_on_a_sheet(tmp_path / "run", iterations=20, **settings)


def test_figures_viewer_and_replay_read_a_field_alike(growing, monkeypatch):
    panels = []
    monkeypatch.setattr(module, "with_protected", lambda panel, _: panel)
    monkeypatch.setattr(module, "picture", lambda shown, **_: panels.extend(shown))
    growing.show()
    header = {layer["key"]: layer for layer in replay_data(growing).header["layers"]}
    layers = {layer.name: layer for layer in subject_of(growing, growing.checkpoint()).layers}
    drawn = {panel.title: panel for panel in panels if panel.values is not None}
    assert [name for name in header if name != "style"] == list(layers)[:5]
    assert header["demand"]["threshold"] == 0.5
    for name in ("stress", "safety_factor", "restraint", "demand", "displacement"):
        played, layer = header[name], layers[name]
        assert (played["label"], played["unit"], played["threshold"]) == (layer.label, layer.unit, layer.threshold)
        assert (played["low"], played["high"]) == pytest.approx(layer.limits, rel=1e-5)
    assert set(drawn) == {"stress", "restraint"}
    for name, panel in drawn.items():
        layer = layers[name]
        assert (panel.label, panel.unit, panel.limits, panel.threshold) == (layer.label, layer.unit, layer.limits, layer.threshold)
        assert np.array_equal(panel.values, layer.values)


def test_a_checkpoint_shows_every_field_that_is_known_there(done):
    state = done.checkpoint(12)
    subject = subject_of(done, state)
    of_any = ["stress", "safety_factor", "restraint", "demand", "displacement", "thickness", "contact"]
    of_tests = ["flat_stress", "nearly_flat_stress"]
    assert [layer.name for layer in subject.layers] == of_any + of_tests
    for name, way in zip(of_tests, ("flat", "nearly flat"), strict=True):
        [landing] = done.simulation(12).of(way)
        assert np.allclose(subject.layer(name).values, done.simulation(12).stress_of(landing=landing.name))
        assert subject.layer(name).threshold == pytest.approx(state.verdict.row(way).limit)
    assert np.array_equal(subject.layer("stress").values, state.stress)
    assert np.allclose(subject.layer("restraint").values, 1.0 - state.mask)
    assert np.array_equal(subject.layer("displacement").values, state.displacement)
    assert np.allclose(subject.mesh.vertices, done.part.surface.displaced(state.displacement).vertices)
    assert subject.mesh.colours is not None


def test_the_least_safety_factor_is_that_of_the_verdict_and_what_is_below_one_is_set_apart(done):
    layer, verdict = subject_of(done, done.checkpoint(12)).layer("safety_factor"), done.history[-1].verdict
    assert layer.values.min() == pytest.approx(verdict.safety_factor, rel=1e-5)
    assert layer.values.max() <= 10.0
    assert (layer.limits, layer.threshold, layer.title) == ((4.0, 0.0), 1.0, "safety factor")
    strength = done.recipe.test.material.yield_strength
    factors = safety_factor(strength).made(strength * np.array([0.25, 0.99, 1.01]))
    assert layer.scale.beyond(factors).tolist() == [False, False, True]


def test_contact_is_given_in_words(done):
    subject = subject_of(done, done.checkpoint(12))
    contact = subject.layer("contact")
    assert [replace(contact, values=[value]).text_at(0) for value in (0.0, 1.0)] == ["no", "yes"]
    assert replace(subject.layer("stress"), values=[12.345]).text_at(0) == "12.35 MPa"
    said = contact.text_at(5)
    assert f">{said}</td>" in table(subject, 5)
    assert f"<b>{said}</b>" in brief(subject, 5, "contact")


def test_nearly_flat_landings_are_shown_only_where_they_were_dropped(fake_run, tmp_path):
    flat_only = fake_run(tmp_path / "flat", nearly_flat=False)
    assert subject_of(flat_only.go(), flat_only.run.checkpoint(4)).layer("nearly_flat_stress") is None


def test_the_limits_are_those_of_the_verdict_and_of_the_recipe(done):
    subject = subject_of(done, done.checkpoint(4))
    assert subject.layer("stress").threshold == done.history[4].verdict.deciding.limit
    assert subject.layer("demand").threshold == done.recipe.restraint.threshold


def test_between_simulations_the_last_verdict_holds_and_its_age_is_said(done):
    state = done.checkpoint(6)
    assert subject_of(done, state).layer("stress").threshold == done.history[4].verdict.deciding.limit
    assert subject_of(done, state).layer("stress").note == "flat, simulated at iteration 4"
    assert subject_of(done, done.checkpoint(4)).layer("stress").note == "flat"


def test_displacement_keeps_its_colours_from_iteration_to_iteration(done):
    early, late = (subject_of(done, done.checkpoint(at)).layer("displacement").limits for at in (0, 12))
    assert early == late
    assert late[1] == pytest.approx(np.abs(done.checkpoint(12).displacement).max())
