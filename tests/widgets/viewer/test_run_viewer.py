"""The viewer of a run follows the state, and the state follows the viewer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from msgspec.structs import replace as replace_fields

from mechstyle.errors import BadInput
from mechstyle.pictures.panels import exaggeration
from mechstyle.runs.run import Run
from mechstyle.simulation.impact import Impact
from mechstyle_widgets.jupyter import looks
from mechstyle_widgets.state.on_show import on_show
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.viewer import impact_player
from mechstyle_widgets.viewer.layers import Layer
from mechstyle_widgets.viewer.run_viewer import RunViewer
from mechstyle_widgets.viewer.shaders import OPEN
from support.models import alive
from support.records import row, verdict


def test_the_part_is_the_one_of_the_iteration(done):
    state = StudioState(done)
    viewer = RunViewer(state)
    state.iteration = 5
    assert viewer.iteration == 5
    assert np.allclose(viewer.subject.mesh.vertices, done.surface(5).vertices)
    viewer.iteration = 7
    assert state.iteration == 7
    assert np.allclose(viewer.subject.mesh.vertices, done.surface(7).vertices)


def test_a_click_on_the_styled_part_tells_the_place_on_the_unstylized_one(done):
    viewer, told = RunViewer(StudioState(done)), []
    viewer.on_click(told.append)
    face = int(np.abs(done.checkpoint(12).displacement[viewer.subject.mesh.faces]).max(axis=1).argmax())
    viewer._picker.three.faceIndex = face
    viewer._picker.three.point = tuple(viewer.subject.mesh.corners[face].mean(axis=0) - viewer._orbit.home.target)
    assert np.allclose(told, done.part.surface.corners[face].mean(axis=0), atol=1e-6)
    assert not np.allclose(told, viewer.subject.mesh.corners[face].mean(axis=0), atol=1e-3)


def test_the_original_is_the_unstylized_part(done):
    viewer = RunViewer(StudioState(done))
    assert np.allclose(viewer.original.mesh.vertices, done.part.surface.vertices)
    assert np.array_equal(viewer.original.layer("stress").values, done.checkpoint(0).stress)


def test_lane_and_layer_are_those_of_the_state(done):
    state = StudioState(done, layer="restraint")
    viewer = RunViewer(state)
    assert viewer.layer == "restraint"
    viewer.layer = "demand"
    assert state.layer == "demand"
    viewer.lane = "soft"
    assert state.lane == "soft"
    assert np.allclose(viewer.subject.layer("demand").values, state.checkpoint.demand)


def test_an_iteration_that_is_not_there_is_brought_to_the_nearest(done):
    viewer = RunViewer(StudioState(done))
    viewer.iteration = 99
    assert viewer.iteration == 12


def test_derived_layers_are_worked_out_for_every_iteration(done):
    state = StudioState(done)
    viewer = RunViewer(state)
    viewer.derived = (lambda _run, at: Layer("half", 0.5 * at.demand),)
    viewer.layer = "half"
    state.iteration = 6
    assert viewer.layer == "half"
    assert np.allclose(viewer.subject.layer("half").values, 0.5 * done.checkpoint(6).demand)


def test_without_an_iteration_there_is_nothing_to_view(fake):
    before = alive()
    for state in (StudioState(), StudioState(fake.run)):
        with pytest.raises(BadInput, match="no iteration to show yet"):
            RunViewer(state)
    assert alive() == before


def test_a_closed_viewer_follows_no_longer(done):
    state, before = StudioState(done), alive()
    viewer = RunViewer(state)
    viewer.close()
    state.iteration = 3
    assert viewer.iteration == 12
    assert alive() == before
    viewer.close()


def test_a_closed_viewer_is_left_alone_when_python_removes_it(done, monkeypatch):
    """In whatever thread, and amid whatever is being made: it went through the controls of all other widgets once more."""
    viewer, gone_through = RunViewer(StudioState(done)), []
    viewer.close()
    monkeypatch.setattr(looks, "family", lambda widget: gone_through.append(widget) or [])
    viewer.close()
    assert gone_through == []


def test_the_run_of_a_relative_folder_is_followed_from_another_one(done, monkeypatch):
    monkeypatch.chdir(done.store.root.parent)
    state = StudioState(Run.open(done.store.root.name, "cpu"))
    viewer = RunViewer(state)
    monkeypatch.chdir("/")
    state.iteration = 5
    assert np.allclose(viewer.subject.mesh.vertices, done.surface(5).vertices)


# --- the shape that stays -----------------------------------------------------------------------------------------


def test_the_layer_of_what_stays_bent_shows_the_part_in_that_shape(done):
    state = StudioState(done)
    viewer = RunViewer(state)
    state.layer = "stays_bent"
    factor = viewer.player.exaggeration
    assert factor == exaggeration(max(one.most_bent for one in (viewer._still, *viewer._rests)), done.surface(12).size)
    assert np.allclose(viewer.subject.mesh.vertices, viewer._still.bent(factor).mesh.vertices)
    assert np.allclose(viewer.original.mesh.vertices, viewer._rests[0].bent(factor).mesh.vertices)
    assert f"bend drawn × {factor:g}" in viewer._legend.value
    assert "mm" in viewer._legend.value
    viewer.player.exaggeration = 1.0
    assert np.allclose(viewer.subject.mesh.vertices, viewer._still.bent(1.0).mesh.vertices)
    state.iteration = 4
    assert np.allclose(viewer.subject.mesh.vertices, viewer._still.bent(viewer.player.exaggeration).mesh.vertices)
    state.layer = "stress"
    assert np.allclose(viewer.subject.mesh.vertices, done.surface(4).vertices)


def test_its_factor_can_be_chosen_while_it_is_shown(done):
    viewer = RunViewer(StudioState(done))
    player = viewer.player
    assert player.factor not in viewer._under.children
    viewer.layer = "stays_bent"
    assert player.factor in viewer._under.children, "under the picture, where its scale says how it is drawn"
    player.exaggeration = 100.0
    viewer.layer = "style"
    assert player.factor not in viewer._under.children
    assert player.exaggeration == 20.0, "an impact bends far more"


# --- side by side -------------------------------------------------------------------------------------------------


def test_equal_values_have_equal_colours_in_all_panes(done):
    """Each pane had the range of its own values, and the legend was that of the first."""
    state = StudioState(done)
    viewer = RunViewer(state)
    viewer.layer = "displacement"
    viewer.compared = ("main", 4)
    ours, theirs = (scene._places.array for scene in viewer._scenes)
    values = [subject.layer("displacement").values for subject in viewer._shown]
    widest = max(float(np.abs(one).max()) for one in values)
    assert viewer._layers[0].limits == viewer._layers[1].limits
    assert max(map(abs, viewer._layers[0].limits)) >= widest
    for places, of_it in zip((ours, theirs), values, strict=True):
        np.testing.assert_allclose(places - OPEN, np.clip(0.5 + of_it / (2 * viewer._layers[0].limits[1]), 0, 1), atol=1e-5)


def test_what_stands_beside_falls_with_it_and_once_after_both(done, monkeypatch):
    """The second pane fell back to its style while the first showed an impact."""
    count, dropped = len(done.part.surface.vertices), []

    def impact(_simulator, simulation, *_):
        dropped.append(simulation.displacement)
        stress = np.outer([0.0, 5.0, 9.0], np.full(count, 1.0 + len(dropped))).astype(np.float32)
        return Impact(np.array([0.0, 0.5, 1.0]), np.zeros((3, count, 3), np.float32), stress)

    monkeypatch.setattr(impact_player, "impact_of", impact)
    monkeypatch.setattr(Run, "simulator", lambda *_: None)
    state = StudioState(done)
    viewer = RunViewer(state)
    viewer.compared = ("main", 4)
    state.falls += 1
    assert len(dropped) == 2
    viewer.player.frame = 1
    assert viewer.layer == "moment"
    ours, theirs = (subject.layer("moment").values for subject in viewer._shown)
    assert (float(ours[0]), float(theirs[0])) == (10.0, 15.0)
    viewer.beside = False
    assert len(dropped) == 3, "alone it falls alone"
    viewer.player.put_away()
    assert viewer.original.layer("moment") is None


def test_the_caption_is_that_of_a_correction_of_the_same_iteration(done):
    """The badge said HOLDS of what was corrected, and the caption FAILS of what was not, as they are of one iteration."""
    state = StudioState(done)
    viewer = RunViewer(state)
    *before, last = state.history
    corrected = replace_fields(last, verdict=verdict(row(0.6)))
    state.histories = {**state.histories, "main": [*before, corrected]}
    state.history = [*before, corrected]
    assert on_show(state).fails
    assert viewer.captions[0] == on_show(state).caption


def test_a_pane_that_stays_as_it_is_is_not_drawn_again(done):
    """What stands beside the part was drawn anew with each iteration of it, by a browser that has one processor for both."""
    state = StudioState(done, layer="stays_bent")
    viewer = RunViewer(state)
    viewer.compared = ("main", 12)
    drawn = [0, 0]

    def count(number, change):
        drawn[number] += not change["new"]

    for number, view in enumerate(viewer._views):
        view.observe(lambda change, number=number: count(number, change), "_pause_autorender")
    state.iteration = 11
    state.iteration = 10
    assert drawn[0] >= 2
    assert drawn[1] <= 1, "where both are exaggerated by another factor"
    viewer.stepped = True
    assert drawn[1] > 0, "what all panes share is drawn in all of them"


def test_what_is_drawn_is_out_of_date_until_a_correction_of_the_same_iteration_is_drawn(done, monkeypatch):
    """A field of what was corrected ended at its own figure while the result told of the correction; lane and iteration are alike."""
    state = StudioState(done)
    viewer, asked = RunViewer(state), []
    assert viewer.up_to_date
    monkeypatch.setattr(viewer._newest, "ask", asked.append)
    state.checkpoint = replace(state.checkpoint)
    assert not viewer.up_to_date
    viewer._bring(asked[-1], viewer._still)
    assert viewer.up_to_date
