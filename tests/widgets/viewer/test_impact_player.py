"""The player of impacts, with an impact that is known."""

from __future__ import annotations

import asyncio
from dataclasses import replace

import numpy as np
import pytest

from mechstyle.errors import SimulationFailed
from mechstyle.pictures.fields import MOMENT, STAYS_BENT
from mechstyle.pictures.panels import exaggeration
from mechstyle.records.sentences import bend
from mechstyle.runs.run import Run
from mechstyle.simulation.impact import FALLING, Impact, heights
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.viewer import impact_player
from mechstyle_widgets.viewer.layers import Subject
from mechstyle_widgets.viewer.run_viewer import RunViewer
from support.models import alive


@pytest.fixture
def state(done):
    return StudioState(done)


@pytest.fixture
def impact(done):
    """Two moments of a sheet that bulges, by 0 and 0.1 mm along x, and the shape that it keeps, by 0.2 mm."""
    x = done.part.surface.vertices[:, 0]
    bulge = np.zeros((3, len(x), 3), np.float32)
    bulge[:, :, 0] = np.array([0.0, 0.1, 0.2])[:, None] * np.sin(x)
    return Impact(np.array([0.0, 0.5, 1.0]), bulge, np.outer([0.0, 20.0, 10.0], np.linspace(0.5, 1.0, len(x))).astype(np.float32))


@pytest.fixture
def viewer(state, impact, monkeypatch):
    def worked_out(_simulator, simulation, landing, progress):
        progress(0.5)
        return replace(impact, normal=simulation.landing(landing).normal)

    monkeypatch.setattr(impact_player, "impact_of", worked_out)
    monkeypatch.setattr(Run, "simulator", lambda *_: None)
    return RunViewer(state)


def test_an_impact_shows_the_stress_of_the_moment_on_the_deformed_part(viewer, impact):
    viewer.player.play()
    assert viewer.layer == "moment"
    assert np.allclose(viewer.subject.layer("moment").values, impact.stress[1])
    assert "at 500 µs, deformed × 50" in viewer._legend.value
    assert np.allclose(viewer.subject.mesh.vertices, impact.shape(viewer._state.run.surface(12), 1, 50.0).vertices)
    viewer.player.exaggeration = 1.0
    assert np.allclose(viewer.subject.mesh.vertices, impact.shape(viewer._state.run.surface(12), 1, 1.0).vertices)


def test_it_opens_at_the_peak_and_ends_in_the_shape_that_stays(viewer, impact):
    viewer.player.play()
    player, landing = viewer.player, viewer._state.run.simulation(12).landings[0]
    assert (player.frame, player._play.max, player._slider.max) == (1, 2, 2)
    assert player._time.value == "500 µs · peak"
    player.frame = 2
    assert player._time.value == f"{bend(landing.permanent_set)} stays bent"
    assert "in the shape that stays" in viewer._legend.value
    assert np.allclose(viewer.subject.layer("moment").values, impact.stress[2])
    player._peak.click()
    assert player.frame == 1


def test_it_comes_through_the_air_from_the_height_asked_and_all_of_it_is_seen(viewer, impact):
    player = viewer.player
    player.play()
    still = viewer._state.run.surface(12)
    for frame, above in zip(range(-FALLING, 0), heights(still.size, 1500.0), strict=True):
        player.frame = frame
        assert np.allclose(viewer.subject.mesh.vertices, impact.shape(still, 0).vertices + np.array([0.0, 0.0, above]), atol=1e-5)
        assert not viewer.subject.layer(MOMENT).values.any()
        assert np.abs(viewer._orbit.seen.project(viewer.subject.mesh.vertices)[:, :2]).max() < 1.0
    assert player._time.value == "falls from 1.5 m"
    assert f"falls from 1.5 m, {above:.0f} mm above the floor" in viewer._legend.value


def test_any_landing_that_was_tested_can_be_seen(state, viewer):
    player = viewer.player
    landings = state.run.simulation(12).landings
    assert [label for label, _ in player._which.options] == [f"{one.name} · {bend(one.permanent_set)}" for one in landings]
    player.play()
    player.landing = landings[1].name
    assert player.impact.normal == landings[1].normal, "another landing is worked out at once"
    assert f"{landings[1].name}, at" in viewer._legend.value
    within = np.abs(viewer._orbit.seen.project(viewer.subject.mesh.vertices)[:, :2])
    assert within.max() < 1.0, "all of it is in view, where it stands now"


def test_a_landing_that_was_not_tested_there_is_flat_again(state, viewer, monkeypatch):
    known = state.simulation

    def less(store, checkpoint):
        found = known(store, checkpoint)
        return found if checkpoint.iteration == 12 else one_landing(found)

    monkeypatch.setattr(state, "simulation", less)
    viewer.player.landing = state.run.simulation(12).landings[1].name
    state.iteration = 4
    assert viewer.player.landing == "flat"


def test_what_was_not_tested_in_that_landing_stands_beside_it_at_rest(state, viewer, monkeypatch):
    known = state.simulation
    monkeypatch.setattr(state, "simulation", lambda store, at: one_landing(known(store, at)) if at.iteration == 4 else known(store, at))
    viewer.compared = ("main", 4)
    viewer.player.landing = state.run.simulation(12).landings[1].name
    viewer.player.play()
    assert viewer.subject.layer("moment") is not None
    assert viewer.original.layer("moment") is None


def one_landing(found):
    fields = {name: getattr(found, name)[:1] for name in ("landing_stress", "landing_strain", "landing_set")}
    return replace(found, landings=found.landings[:1], **fields)


def test_the_stress_of_the_moment_stands_against_the_yield_strength(viewer, state):
    viewer.player.play()
    assert viewer.subject.layer("moment").threshold == state.run.recipe.test.material.yield_strength


def test_what_was_on_show_before_an_impact_is_on_show_after_it(viewer, state):
    state.layer = "stress"
    for _ in range(2):  # the second falls while the first is on show
        viewer.player.play()
    assert viewer.layer == MOMENT
    viewer.player.put_away()
    assert (viewer.layer, state.layer) == ("stress", "stress")
    viewer.player.play()
    viewer.layer = "demand"
    viewer.player.put_away()
    assert viewer.layer == "demand", "somebody chose it meanwhile"


def test_what_stays_bent_takes_the_place_of_an_impact(viewer, state):
    """The impact stood there in the colours of what stays bent, and back at rest the part was bent by the factor of the impact."""
    viewer.player.play()
    viewer.player.exaggeration = 100.0
    viewer.layer = STAYS_BENT
    assert (viewer.layer, viewer.player.impact) == (STAYS_BENT, None)
    still, factor = state.run.surface(12), exaggeration(viewer.subject.most_bent, state.run.surface(12).size)
    assert np.allclose(viewer.subject.mesh.vertices, still.vertices + factor * viewer.subject.bend)
    assert f"bend drawn × {factor:g}" in viewer._legend.value


def test_after_a_landing_on_its_side_one_looks_at_the_part_that_stands_again(viewer, impact, monkeypatch):
    """Half of the view stayed empty, and the part lay under the legend."""
    before = viewer._orbit.seen.target
    monkeypatch.setattr(impact_player, "impact_of", lambda *_: replace(impact, normal=(1.0, 0.0, 0.0)))
    viewer.player.play()
    assert not np.allclose(viewer._orbit.seen.target, before)
    viewer.player.put_away()
    assert np.allclose(viewer._orbit.seen.target, before)


def test_what_an_impact_is_not_of_stays_at_rest(viewer, cube):
    """An impact of a coarser part came when a finer one was on show: the page got an error of numpy."""
    viewer.player.play()
    other = Subject(cube)
    assert len(cube.vertices) != len(viewer.subject.mesh.vertices)
    assert viewer.player.at_the_moment(other) is other


def test_put_away_the_part_is_at_rest_again(viewer):
    viewer.player.play()
    viewer.player.frame = 2
    viewer.player.put_away()
    assert viewer.subject.layer("moment") is None
    assert np.allclose(viewer.subject.mesh.vertices, viewer._state.run.surface(12).vertices)
    assert viewer.player.children == (viewer.player._start,)


def test_another_iteration_puts_the_impact_away(viewer, state):
    viewer.player.play()
    state.iteration = 4
    assert viewer.player.impact is None
    assert np.allclose(viewer.subject.mesh.vertices, state.run.surface(4).vertices)


def test_a_drop_that_fails_says_so_in_one_sentence(viewer, monkeypatch):
    def fails(*_):
        raise SimulationFailed("the drop test broke down")

    monkeypatch.setattr(impact_player, "impact_of", fails)
    viewer.player.play()
    assert viewer.player.children == (viewer.player._start, viewer.player._said)
    assert viewer.player._said.value == "the drop test broke down"


def test_an_impact_that_cannot_be_shown_says_so(viewer, monkeypatch, caplog):
    def cannot(*_):
        raise ValueError("two parts")

    monkeypatch.setattr(impact_player.ImpactPlayer, "_fall", cannot)
    viewer.player.play(once=True)
    assert "by an unexpected ValueError: two parts" in viewer.player._said.value
    assert viewer.player._button in viewer.player._start.children
    assert viewer.player._start in viewer.player.children, "it can be tried again"
    assert "unexpected" in caplog.text


def test_in_a_notebook_it_is_worked_out_in_a_thread_and_brought_back(viewer, impact):
    async def click() -> None:
        arrived = asyncio.Event()
        viewer.player.observe(lambda _: arrived.set(), "impact")
        viewer.player.play()
        assert viewer.player.impact is None  # the loop has not turned yet
        await asyncio.wait_for(arrived.wait(), 30)

    asyncio.run(click())
    assert viewer.player.impact.stress is impact.stress


def test_what_a_drop_that_was_ended_still_brings_is_not_heard(viewer, later):
    """Late ones took the place of the impact on show, and threw its slider back."""
    player = viewer.player
    player.play()
    later.drops[0]()  # it was over before it was ended, and its answer is under way
    player.put_away()
    player.play()
    later.turn()
    assert (player.impact, player._progress.value, player.children) == (None, 0.0, (player._progress,))
    later.drops[1]()
    later.turn()
    assert player.impact is not None
    later.drops[0]()
    assert len(later.brought) == 1, "the drop that was ended says so, and no more, although another was begun"


def test_an_impact_that_is_worked_out_is_not_worked_out_twice(viewer, later):
    viewer.player.play()
    viewer.player.play()
    assert len(later.drops) == 1


def test_a_drop_that_breaks_off_can_be_tried_again(viewer, later, impact, monkeypatch):
    def breaks_off(*_):
        raise MemoryError

    viewer.player.play()
    with monkeypatch.context() as broken:
        broken.setattr(impact_player, "impact_of", breaks_off)
        later.drops[0]()
    later.turn()
    assert "not enough memory" in viewer.player._said.value
    viewer.player.play()
    later.drops[1]()
    later.turn()
    assert viewer.player.impact.stress is impact.stress


def test_another_landing_ends_the_drop_of_the_one_before(viewer, later):
    player = viewer.player
    player.play()
    player.landing = "tilted 3°"
    for drop in reversed(later.drops):
        drop()
    later.turn()
    assert (len(later.drops), player.impact.normal) == (2, (0.0, 0.6, 0.8))


def test_a_drop_that_fails_after_it_was_ended_says_nothing(viewer, later, monkeypatch):
    def fails(*_):
        raise SimulationFailed("the drop test broke down")

    monkeypatch.setattr(impact_player, "impact_of", fails)
    viewer.player.play()
    viewer.player.put_away()
    later.drops[0]()
    later.turn()
    assert viewer.player.children == (viewer.player._start,)


def test_closing_leaves_nothing_behind(state):
    before = alive()
    viewer = RunViewer(state)
    viewer.close()
    viewer.player.close()
    assert alive() == before
