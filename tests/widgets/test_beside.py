"""Freestyle beside MechStyle in one press, in two panes or three, with what differs and where it was decided."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mechstyle.pictures.fields import stays_bent
from mechstyle.records import sentences
from mechstyle.runs.recipes import FREESTYLE
from mechstyle.runs.run import Draft
from mechstyle_widgets.panels.branches import Branches, said_of
from mechstyle_widgets.state.on_show import on_show
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.viewer import badge
from mechstyle_widgets.viewer.run_viewer import RunViewer
from support.told import outcomes


def table(branches):
    return {name: cells for name, *cells in branches.comparison()}


def test_one_press_runs_both_and_compares_them(controller, settle):
    branches, state = Branches(controller), controller.state
    controller.both()
    settle(controller)
    assert (state.lane, state.status, state.layer, state.pinned) == ("main", "finished", "stress", ("freestyle", 12))
    free = next(branch for branch in state.branches if branch.lane == "freestyle")
    assert (free.parent, free.forked_at, free.finished) == ("main", 0, True)
    recipe = state.run.store.recipe(state.run.store.lane("freestyle").recipe)
    assert {name: recipe.settings[name] for name in FREESTYLE} == FREESTYLE
    assert table(branches)["control"] == ["none", "faster than evenly"]
    assert table(branches)["outcome"] == [said_of(state.row(12, lane).verdict) for lane in ("freestyle", "main")]


def test_pressed_again_it_finds_what_it_made(controller, settle):
    controller.both()
    settle(controller)
    heads = {lane: controller.state.run.store.lane(lane).head for lane in ("main", "freestyle")}
    controller.state.pinned = None
    controller.both()
    settle(controller)
    assert {lane: controller.state.run.store.lane(lane).head for lane in heads} == heads
    assert controller.state.pinned == ("freestyle", 12)


def test_beside_freestyle_there_is_no_freestyle(controller, fake_run, tmp_path):
    free = fake_run(tmp_path / "free", **FREESTYLE).run
    controller.wanted = lambda: Draft(free.recipe, free.part, 500, "sheet")
    controller.both()
    assert controller.state.message.startswith("this is Freestyle already")
    assert controller.state.session is None


def test_the_place_that_decides_is_that_of_the_one_that_stays_bent_most(controller, settle):
    branches, state = Branches(controller), controller.state
    controller.both()
    settle(controller)
    vertex, words = branches.decisive()
    decide = {lane: state.row(12, lane).verdict.deciding for lane in ("main", "freestyle")}
    worst = max(decide, key=lambda lane: decide[lane].used)
    assert f"where {state.called(worst)} stays bent most" in words
    assert f"{state.called(worst)} {sentences.found(decide[worst])}" in words, "where it is most bent it is what was judged"
    for lane, row in decide.items():
        there = stays_bent(row).values_in(state.simulation(state.run.store, state.checkpoint_at(12, lane)))[vertex]
        assert f"{state.called(lane)} {sentences.bend_in(row, there)}" in words
    assert words in branches._comparison.value


def test_a_third_pane_for_what_is_branched_from(controller, settle):
    branches, state = Branches(controller), controller.state
    controller.both()
    settle(controller)
    state.iteration = 6
    branches.controller.branch(6, control="frozen")
    branches.third = ("main", 12)
    settle(controller)
    assert (state.lane, branches.places) == ("branch-1", [("freestyle", 12), ("main", 12), ("branch-1", 12)])
    assert table(branches)["control"] == ["none", "faster than evenly", "only at the limit"]
    assert len(table(branches)["outcome"]) == 3
    branches._pin.click()
    assert (branches.pinned, branches.third) == (("branch-1", 12), None)


def test_three_views_share_the_camera_and_the_width(done):
    viewer = RunViewer(StudioState(done), width=900)
    viewer.also, viewer.compared = ("soft", 8), ("main", 4)
    assert [view.width for view in viewer._stage.children] == [300, 300, 300]
    assert len({view.camera for view in viewer._stage.children}) == 1
    assert viewer.names == ("MechStyle", "MechStyle, iteration 4", "soft, iteration 8")
    assert np.allclose(viewer.third.mesh.vertices, done.surface().vertices) is False
    assert len(viewer.picture().png) > 0
    viewer.also = None
    assert [view.width for view in viewer._stage.children] == [450, 450]
    viewer.compared = None
    assert viewer.names == ("styled", "plain")
    viewer.close()


@pytest.mark.usefixtures("controller")
def test_forgetting_what_is_compared_takes_the_cross_away(done, monkeypatch):
    from mechstyle_widgets.studio import Studio  # noqa: PLC0415 — after the controller's patches

    monkeypatch.setattr("mechstyle_widgets.panels.mask_inspector._freedom", lambda run, _recipe: np.ones_like(run.part.thickness))
    studio = Studio(done)
    studio.state.pinned = ("soft", 12)
    assert studio._viewer.probed is not None
    studio.state.pinned = None
    assert (studio._viewer.probed, studio._viewer.beside) == (None, False)
    studio.close()


@pytest.mark.usefixtures("controller")
def test_after_both_one_sentence_stands_over_the_panes_each_with_its_name_and_badge(done, monkeypatch):
    """The one sentence that was wanted stood behind a tab, 1300 pixels down."""
    from mechstyle_widgets.studio import Studio  # noqa: PLC0415 — after the controller's patches

    monkeypatch.setattr("mechstyle_widgets.panels.mask_inspector._freedom", lambda run, _recipe: np.ones_like(run.part.thickness))
    monkeypatch.setattr(Branches, "insight", lambda _: "Both look alike. Of both 0.06 mm stays bent, landing flat; 0.20 mm is allowed.")
    studio = Studio(done)
    studio.state.pinned = ("soft", 12)
    viewer = studio.viewer
    assert 'class="mechstyle-insight" role="status">Both look alike.' in viewer.badge._words.value
    assert viewer.names == ("MechStyle", "soft")
    assert all(studio.state.row(12, lane).outcome in html for lane, html in zip(("main", "soft"), viewer.outcomes, strict=True))
    studio.state.pinned = None
    assert "mechstyle-insight" not in viewer.badge._words.value.partition("</style>")[2]
    studio.close()


@pytest.mark.usefixtures("controller")
def test_each_of_several_panes_has_its_outcome_once_and_what_is_kept_of_all_stands_over_them(done, monkeypatch):
    """Badge, first title and Result said the same words three times."""
    from mechstyle_widgets.studio import Studio  # noqa: PLC0415 — after the controller's patches

    monkeypatch.setattr("mechstyle_widgets.panels.mask_inspector._freedom", lambda run, _recipe: np.ones_like(run.part.thickness))
    studio = Studio(done)
    assert outcomes(studio.viewer.badge._words.value) != set()
    studio.state.pinned = ("soft", 12)
    assert outcomes(studio.viewer.badge._words.value) == set()
    one, other = (replace(on_show(studio.state, lane, 12), kept=kept) for lane, kept in (("main", 0.8), ("soft", 0.5)))
    assert "Of the relief kept: MechStyle 80%, soft 50%" in badge.of_several([one, other])
    studio.state.pinned = None
    assert outcomes(studio.viewer.badge._words.value) != set()
    studio.close()


def test_the_sentence_is_made_of_the_verdicts_at_the_ends_of_freestyle_and_what_is_shown(controller, settle):
    branches, state = Branches(controller), controller.state
    assert branches.insight() == ""
    controller.both()
    settle(controller)
    free, fed = (state.row(12, lane).verdict for lane in ("freestyle", "main"))
    words = branches.insight()
    assert all(sentences.found(verdict.deciding) in words for verdict in (free, fed))
    state.lane = "freestyle"
    assert branches.insight() == ""
