"""The mask inspector: what it foretells is what a branch begins with."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from mechstyle.records.checkpoint import restrained
from mechstyle.runs.run import Draft
from mechstyle_widgets.panels.mask_inspector import LAYER, MaskInspector, plots
from mechstyle_widgets.state.controller import Controller
from mechstyle_widgets.state.studio_state import StudioState


@pytest.fixture
def inspector(controller, settle, monkeypatch):
    """An inspector of a finished run, nothing of whose sheet is protected."""
    monkeypatch.setattr("mechstyle_widgets.panels.mask_inspector._freedom", lambda run, _recipe: np.ones_like(run.part.thickness))
    controller.run()
    settle(controller)
    return MaskInspector(controller)


def test_it_begins_with_the_settings_in_force(inspector):
    assert inspector.selector.control == "exponential"
    inspector.state.iteration = 4
    assert np.allclose(inspector.would_be, inspector.state.checkpoint.mask, atol=1e-6)


def test_a_stricter_threshold_freezes_more_at_once(inspector):
    inspector.state.iteration = 8
    frozen, held = [float((inspector.would_be <= 0.0).mean())], 0.0
    for threshold in (0.5, 0.2):
        inspector._slider.value = threshold
        assert inspector.state.layer == LAYER
        frozen.append(float((inspector.would_be <= 0.0).mean()))
        held = float(restrained(inspector.would_be).mean())
    assert frozen == sorted(frozen)
    assert frozen[-1] > frozen[0]
    assert f"now, {held:.1%} with this. “Use this” goes on from iteration 8" in inspector._note.value


def test_the_plots_follow_threshold_and_iteration(inspector):
    seen = {inspector._plots.value}
    inspector.selector.threshold = 0.3
    seen.add(inspector._plots.value)
    inspector.state.iteration = 4
    seen.add(inspector._plots.value)
    assert len(seen) == 3


def test_nothing_is_run_or_written_by_looking(inspector):
    before = sorted(inspector.state.run.store.root.rglob("*"))
    inspector.selector.control, inspector.selector.threshold = "frozen", 0.1
    assert sorted(inspector.state.run.store.root.rglob("*")) == before


def test_use_this_branches_with_the_very_mask_that_was_shown(inspector, settle):
    inspector.state.iteration = 4
    inspector.selector.control, inspector.selector.threshold = "linear", 0.6
    shown = inspector.would_be.copy()
    state = inspector.state.checkpoint_at(4)
    inspector._use.click()
    settle(inspector.controller)
    run = inspector.state.run
    assert (run.lane, run.recipe.restraint.control, run.recipe.restraint.threshold) == ("branch-1", "linear", 0.6)
    # The first step of the branch moves by what the mask lets through, so where it let nothing through nothing moved.
    moved = run.checkpoint(5).displacement - state.displacement
    assert np.array_equal(moved != 0.0, shown > 0.0)


def test_it_is_a_layer_for_the_viewer(inspector):
    layer = inspector.layer()(inspector.state.run, inspector.state.checkpoint)
    assert np.allclose(layer.values, 1.0 - inspector.would_be)
    inspector._show_layer.value = True
    assert inspector.state.layer == LAYER
    inspector.state.layer = "style"
    assert not inspector._show_layer.value


def test_without_a_run_there_is_nothing_to_inspect():
    inspector = MaskInspector(Controller(StudioState(), lambda: Draft(None, None, 500, "part")))
    assert inspector._use.disabled
    assert "run something first" in inspector._note.value


def test_demands_far_above_one_leave_the_numbers_around_one_apart():
    """A demand of twenty drew 0, 0.5 and 1 on top of each other."""
    state = SimpleNamespace(demand=np.array([0.0, 0.3, 0.9, *[20.0] * 7], np.float32), mask=np.ones(10, np.float32))
    drawn = plots(state, np.ones(10, np.float32), threshold=1.0)
    places = [float(re.search(rf'<text x="([\d.]+)"[^>]*>{number}</text>', drawn)[1]) for number in ("0", "0.5", "1")]
    assert np.diff(places).min() > 20.0
    assert "2 and more in the last bar" in drawn
