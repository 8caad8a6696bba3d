"""What a checkpoint of a run has to show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mechstyle.pictures.fields import stays_bent
from mechstyle.runs import run as module
from mechstyle_widgets.viewer import legend
from mechstyle_widgets.viewer.layers import subject_of
from mechstyle_widgets.viewer.probe import brief, table
from support.lanes import lane_on_a_sheet


@pytest.fixture
def growing(tmp_path):
    """A lane whose last iteration has the largest relief, stress and demand of all."""
    settings = {"control": "none", "guarantee": False, "threshold": 0.5, "normalisation": "own_max"}
    return lane_on_a_sheet(tmp_path / "run", iterations=20, **settings)


def test_figures_and_viewer_read_a_field_alike(growing, monkeypatch):
    panels = []
    monkeypatch.setattr(module, "with_protected", lambda panel, _: panel)
    monkeypatch.setattr(module, "picture", lambda shown, **_: panels.extend(shown))
    growing.show()
    layers = {layer.name: layer for layer in subject_of(growing, growing.checkpoint()).layers}
    titles = {"what stays bent": "stays_bent"}  # which has the factor of what is drawn behind it
    drawn = {titles.get(name := panel.title.partition(",")[0], name): panel for panel in panels if panel.values is not None}
    assert layers["demand"].threshold == 0.5
    assert set(drawn) == {"stress", "stays_bent", "restraint"}
    for name, panel in drawn.items():
        layer = layers[name]
        assert (panel.label, panel.unit, panel.threshold, panel.edge) == (layer.label, layer.unit, layer.threshold, layer.edge)
        assert panel.limits == pytest.approx(layer.limits)
        assert np.array_equal(panel.values, layer.values)


def test_a_checkpoint_shows_every_field_that_is_known_there(done):
    state = done.checkpoint(12)
    subject, tested = subject_of(done, state), done.simulation(12)
    of_any = ["stress", "stays_bent", "restraint", "demand", "displacement", "thickness", "contact"]
    of_tests = [f"stress_{name}" for name in ("flat", "tilted_3")]
    assert [layer.name for layer in subject.layers] == of_any + of_tests
    strength = done.recipe.test.material.yield_strength
    for name, landing in zip(of_tests, tested.landings, strict=True):
        assert np.allclose(subject.layer(name).values, tested.stress_of(landing=landing.name))
        assert subject.layer(name).threshold == strength
    row = state.verdict.deciding
    assert np.array_equal(subject.layer("stays_bent").values, stays_bent(row).values_in(tested))
    assert np.array_equal(subject.layer("stress").values, state.stress)
    assert np.allclose(subject.layer("restraint").values, 1.0 - state.mask)
    assert np.array_equal(subject.layer("displacement").values, state.displacement)
    assert np.allclose(subject.mesh.vertices, done.part.surface.displaced(state.displacement).vertices)
    assert subject.mesh.colours is not None


def test_what_stays_bent_is_drawn_exaggerated_and_its_layer_says_how_much(done):
    subject, row = subject_of(done, done.checkpoint(12)), done.history[-1].verdict.deciding
    bent = subject.bent(20.0)
    assert np.allclose(bent.mesh.vertices - subject.mesh.vertices, 20.0 * done.simulation(12).set_of(landing=row.landing), atol=1e-4)
    assert bent.layer("stays_bent").note == f"{row.landing}, bend drawn × 20"
    assert np.array_equal(bent.layer("stays_bent").values, subject.layer("stays_bent").values)
    assert subject.most_bent == pytest.approx(row.permanent_set, rel=1e-5)
    unknown = replace(subject, bend=None)
    assert (unknown.bent(20.0), unknown.most_bent) == (unknown, 0.0)


def test_contact_is_given_in_words(done):
    subject = subject_of(done, done.checkpoint(12))
    contact = subject.layer("contact")
    assert [replace(contact, values=[value]).text_at(0) for value in (0.0, 1.0)] == ["no", "yes"]
    assert replace(subject.layer("stress"), values=[12.345]).text_at(0) == "12.35 MPa"
    said = contact.text_at(5)
    assert f">{said}</td>" in table(subject, 5)
    assert f"<b>{said}</b>" in brief(subject, 5, "contact")


def test_the_limits_are_those_of_the_verdict_and_of_the_recipe(done):
    subject = subject_of(done, done.checkpoint(4))
    assert subject.layer("stress").threshold == done.recipe.test.material.yield_strength
    assert subject.layer("stays_bent").threshold == done.history[4].verdict.deciding.allowed
    assert subject.layer("demand").threshold == done.recipe.restraint.threshold


def test_between_simulations_the_last_verdict_holds_and_its_age_is_said(done):
    state = done.checkpoint(6)
    assert subject_of(done, state).layer("stays_bent").threshold == done.history[4].verdict.deciding.allowed
    assert subject_of(done, state).layer("stress").note == "flat, simulated at iteration 4"
    assert subject_of(done, done.checkpoint(4)).layer("stress").note == "flat"


def test_what_was_found_on_an_earlier_surface_is_no_answer_on_this_one(done):
    """Under a styled part that nobody had dropped stood that nothing stays bent of it, which was so of the plain one."""
    subjects = [subject_of(done, done.checkpoint(iteration)) for iteration in (6, 4)]
    told = [legend.colour_bar(one.layer("stays_bent"), one.mesh) for one in subjects]
    assert ["stays bent by more than the allowed" in words for words in told] == [False, True]
    assert not subjects[0].layer("displacement").aged


def test_displacement_keeps_its_colours_from_iteration_to_iteration(done):
    early, late = (subject_of(done, done.checkpoint(at)).layer("displacement").limits for at in (0, 12))
    assert early == late
    assert late[1] == pytest.approx(np.abs(done.checkpoint(12).displacement).max())
