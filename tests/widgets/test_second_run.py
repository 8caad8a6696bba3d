"""One Studio, one run after another: whatever is shown is that of the run on show, and nothing is said in the log."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.loop.engine import Checkpointed
from mechstyle.pictures.fields import MOMENT
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.run import Run
from mechstyle_widgets.state import controller as controller_module
from mechstyle_widgets.studio import Studio
from mechstyle_widgets.viewer.run_viewer import RunViewer
from mechstyle_widgets.viewer.viewer import PartViewer
from support.sheet_studio import engine_of, sheet_of, without_physics
from support.told import assert_tells_one_truth

PATIENCE = 30.0


@pytest.fixture
def studio(tmp_path, monkeypatch, cube) -> Iterator[Studio]:
    """A Studio whose runs take no time; its `go()` runs what is asked for to the end, heard of before the first iteration if `early`."""
    begun, gate = threading.Event(), threading.Event()

    def events(run, _progress):
        begun.set()
        assert gate.wait(PATIENCE)
        yield from engine_of(run).run()

    monkeypatch.chdir(tmp_path)
    without_physics(monkeypatch)
    monkeypatch.setattr(Run, "events", events)
    made = Studio(cube, prompt="brick", schedule="every", every=4, iterations=12, vertices=64)

    def go(*, early: bool = False) -> None:
        begun.clear()
        gate.clear()
        made.run_controls._buttons["run"].click()
        assert made.state.message == ""
        session = made.state.session
        if early and begun.wait(PATIENCE):
            made.state.pump()
        gate.set()
        session.wait(PATIENCE)
        made.state.pump()
        assert made.state.status == "finished", made.state.message

    made.go = go
    yield made
    made.close()


def assert_shows(studio: Studio, surface: SurfaceMesh, prompt: str) -> None:
    """Picture, stress, inspector, timeline, branches and impact are those of a run of this part and prompt."""
    state, viewer, count = studio.state, studio._viewer, len(surface.vertices)
    assert state.run.recipe.style.prompt == prompt
    assert state.run.part.surface.digest == surface.digest
    newest = state.run.checkpoint()
    assert isinstance(viewer, RunViewer)
    assert studio._middle.children == (viewer,)
    expected = surface.displaced(newest.displacement)
    np.testing.assert_array_equal(viewer.subject.mesh.faces, surface.faces)
    np.testing.assert_allclose(viewer.subject.mesh.vertices, expected.vertices)
    np.testing.assert_allclose(viewer.undeformed.vertices, surface.vertices)
    viewer.layer = "stress"
    np.testing.assert_allclose(viewer.subject.layer("stress").values, newest.stress)
    assert state.layer == "stress"
    assert studio.mask_inspector.would_be.shape == (count,)
    assert studio.mask_inspector.selector.threshold == state.run.recipe.restraint.threshold
    assert [row.digest for row in state.history] == [row.digest for row in state.histories["main"]]
    assert state.history[-1].digest == state.run.store.lane().head
    assert studio._timeline.iteration == state.iteration == 12
    assert [branch.recipe.style.prompt for branch in state.branches] == [prompt]
    viewer.player.play()
    assert viewer.player.impact.stress.shape == (3, count)
    assert viewer.layer == MOMENT
    viewer.player.put_away()


@pytest.mark.parametrize("early", [False, True])
def test_another_prompt_then_another_part_then_another_resolution(studio, cube, caplog, early):
    studio.go()
    assert_shows(studio, sheet_of(cube, 64), "brick")
    first = studio.state.run.store.root
    studio.prompt_box.prompt = "stone"
    studio.go(early=early)
    assert_shows(studio, sheet_of(cube, 64), "stone")
    assert studio.state.run.store.root != first
    half = cube.moved(0.5 * cube.vertices)
    studio.part_picker.show(half, "half")
    studio.drop_options.vertices = 64  # another part is as fine as parts usually are
    studio.go(early=early)
    assert_shows(studio, sheet_of(half, 64), "stone")
    studio.drop_options.vertices = 100
    studio.go(early=early)
    assert_shows(studio, sheet_of(half, 100), "stone")
    assert not caplog.records


def test_a_run_that_was_begun_before_is_found_again(studio, cube, caplog):
    studio.go()
    old = studio.state.run.store.root
    studio.control_selector.threshold = 0.4
    studio.go()
    other = studio.state.run
    studio.state.open(Run.open(old, "cpu"))
    assert_shows(studio, sheet_of(cube, 64), "brick")
    studio.state.open(other)
    assert_shows(studio, sheet_of(cube, 64), "brick")
    assert studio.mask_inspector.selector.threshold == 0.4
    assert not caplog.records


def test_a_layer_only_the_earlier_run_has_gives_way(studio, caplog):
    studio.go()
    studio.mask_inspector._show_layer.value = True
    studio._viewer.player.play()
    studio.prompt_box.prompt = "stone"
    studio.go()
    assert studio._viewer.layer == studio.state.layer
    assert studio._viewer.player.impact is None
    assert not caplog.records


def test_a_part_that_could_not_be_prepared_is_not_taken_for_the_one_before(studio, cube, monkeypatch):
    studio.go()
    half = cube.moved(0.5 * cube.vertices)
    studio.part_picker.show(half, "half")
    studio.drop_options.vertices = 64

    def refused(*_args, **_options):
        raise BadInput("this part cannot be meshed")

    with monkeypatch.context() as failing:
        failing.setattr(controller_module, "prepare_in_worker", refused)
        studio.run_controls._buttons["run"].click()
        studio.state.session.wait(PATIENCE)
        studio.state.pump()
    assert studio.state.message == "this part cannot be meshed"
    studio.go()
    assert_shows(studio, sheet_of(half, 64), "brick")


def test_an_opened_run_at_another_resolution_and_back(studio, cube, tmp_path):
    studio.go()
    again = Studio(studio.state.run)
    again.go = studio.go
    assert again.wanted().part is again.run.part
    again.drop_options.vertices = 100
    assert again.wanted().part is again.part_picker.mesh
    again.state.open(studio.state.run.branch(4, lane="soft", control="linear"))  # of the same folder: the part is at hand
    again.drop_options.vertices = 64
    assert again.wanted().part is again.run.part
    studio.drop_options.vertices = 100
    studio.go()
    again.state.open(studio.state.run)  # of another: it is not
    assert again.wanted().part is again.part_picker.mesh


def test_a_damaged_run_is_said_and_does_not_end_the_news(studio, tmp_path):
    studio.go()
    shown = studio.state.run
    broken = Run.open(shown.store.root, "cpu")
    studio.state.tell(opened=Run(type(broken.store)(tmp_path / "nowhere"), "main"))
    studio.state.pump()
    assert studio.state.message
    assert studio.state.run is shown
    studio.prompt_box.prompt = "wood"
    studio.go()
    assert studio.state.run.recipe.style.prompt == "wood"


def test_a_second_run_in_one_folder_goes_beside_the_first_and_says_so(studio, caplog):
    studio.drop_options.folder = "mine"
    studio.go()
    assert str(studio.state.run.store.root) == "mine"
    studio.prompt_box.prompt = "stone"
    said = []
    studio.state.observe(lambda change: said.append(change["new"]), "message")
    studio.go(early=True)
    assert str(studio.state.run.store.root) == "mine-2"
    assert "mine holds a run with other settings: this one is in mine-2" in said
    assert {record.message for record in caplog.records} == {"mine holds a run with other settings: this one is in mine-2"}


@pytest.mark.parametrize("reopened", [False, True])
def test_choosing_the_part_of_a_run_again_shows_the_run(studio, cube, caplog, reopened):
    """It stayed a preview that was not tested, beside a verdict, and the timeline had nothing to show."""
    studio.go()
    shown = Studio(studio.state.run) if reopened else studio
    part = shown.part_picker.mesh if reopened else cube.moved(cube.vertices)  # a file that is read again is another object
    shown.part_picker.show(cube.moved(0.5 * cube.vertices), "half")
    assert isinstance(shown.viewer, PartViewer)
    shown.part_picker.show(part, "part")
    assert_shows(shown, sheet_of(cube, 64), "brick")
    assert not shown.controller.asks_for_another()
    shown.state.iteration = 4
    assert (shown.viewer.iteration, shown._middle.children) == (4, (shown.viewer,))
    assert not caplog.records


@pytest.fixture
def again(studio, monkeypatch) -> Iterator[Studio]:
    """A run opened in a Studio that is told of every part that is meshed; another style is chosen in it."""
    studio.go()
    prepare = controller_module.prepare_in_worker
    again = Studio(studio.state.run)

    def counted(mesh, **options):
        again.meshed.append(mesh)
        return prepare(mesh, **options)

    monkeypatch.setattr(controller_module, "prepare_in_worker", counted)
    again.meshed = []
    again.prompt_box.prompt = "wood"
    yield again
    again.close()


def settled(studio: Studio, act: Callable[[], None]) -> None:
    """An action of the controller, and all that comes of it."""
    act()
    studio.state.session.wait(PATIENCE)
    studio.state.pump()


def test_another_style_on_the_part_of_an_opened_run_is_run_once(again, cube):
    """The part was meshed again, with another verdict, each time that Run was pressed."""
    settled(again, again.controller.run)
    made = again.run.store.root
    assert_shows(again, sheet_of(cube, 64), "wood")
    settled(again, again.controller.run)
    assert "this lane is finished" in again.state.message
    assert (again.run.store.root, again.controller.asks_for_another()) == (made, False)
    again.prompt_box.prompt = "stone"
    settled(again, again.controller.run)
    assert_shows(again, sheet_of(cube, 64), "stone")
    assert again.meshed == []


def test_another_style_on_the_part_of_an_opened_run_goes_on_after_a_stop(again, cube):
    settled(again, again.controller.step)
    made = again.run.store.root
    settled(again, again.controller.stop)
    assert (again.state.status, again.state.iterations_done) == ("stopped", 0)
    settled(again, again.controller.run)
    assert (again.state.status, again.run.store.root, again.meshed) == ("finished", made, [])
    assert_shows(again, sheet_of(cube, 64), "wood")


def test_freestyle_paused_beside_a_run_goes_on_with_its_own_settings(studio):
    studio.go()
    session = studio.controller._session(then_freely=True)
    settled(studio, lambda: session.run_until(lambda event: isinstance(event, Checkpointed)))
    assert (studio.state.lane, studio.state.status) == ("freestyle", "paused")
    settled(studio, studio.controller.run)
    assert studio.state.session is session
    assert (studio.state.lane, studio.state.status, studio.state.pinned) == ("main", "finished", ("freestyle", 12))


def test_another_style_while_a_run_is_paused_is_begun_in_its_place(studio, cube, caplog):
    studio.go()
    studio.prompt_box.prompt = "wood"
    settled(studio, studio.controller.step)
    left = studio.run
    studio.prompt_box.prompt = "stone"
    settled(studio, studio.controller.run)
    assert_shows(studio, sheet_of(cube, 64), "stone")
    studio.prompt_box.prompt = "wood"
    settled(studio, studio.controller.run)
    assert studio.run.store.root == left.store.root, "its settings find it again"
    assert_shows(studio, sheet_of(cube, 64), "wood")
    assert not caplog.records


def test_a_run_is_followed_wherever_the_notebook_works_meanwhile(studio, cube, tmp_path, monkeypatch):
    """Its folder is relative, as by default: after os.chdir the view stood still, and the run was begun anew when asked for again."""
    studio.go()
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    assert not studio.controller.asks_for_another()
    assert studio.controller.began_with(cube)
    studio.state.iteration = 4
    shown = studio._viewer.subject.mesh.vertices
    np.testing.assert_allclose(shown, studio.run.surface(4).vertices)
    studio.prompt_box.prompt = "wood"
    settled(studio, studio.controller.run)
    assert_shows(studio, sheet_of(cube, 64), "wood")


def test_two_studios_run_at_once_and_each_shows_its_own(tmp_path, monkeypatch, cube, caplog):
    monkeypatch.chdir(tmp_path)
    without_physics(monkeypatch)
    meet = threading.Barrier(2, timeout=PATIENCE)

    def events(run, _progress):
        meet.wait()  # neither goes on before the other has begun
        yield from engine_of(run).run()

    monkeypatch.setattr(Run, "events", events)
    settings = {"schedule": "every", "every": 4, "iterations": 12, "vertices": 64}
    studios = [Studio(cube, prompt=prompt, **settings) for prompt in ("brick", "stone")]
    for studio in studios:
        studio.controller.run()
    for studio, prompt in zip(studios, ("brick", "stone"), strict=True):
        studio.state.session.wait(PATIENCE)
        studio.state.pump()
        assert studio.state.status == "finished", studio.state.message
        assert_shows(studio, sheet_of(cube, 64), prompt)
        assert_tells_one_truth(studio)
    assert studios[0].run.store.place != studios[1].run.store.place
    assert not caplog.records
