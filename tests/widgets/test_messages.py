"""What is said lives as long as what it is about, beside what it is about; no error of a handler ends in a log only."""

from __future__ import annotations

import asyncio
import errno
import io
import shutil
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from PIL import Image

from mechstyle.errors import DamagedStore
from mechstyle.records import sentences
from mechstyle.runs.run import Draft, Run
from mechstyle_widgets.jupyter import cell_output
from mechstyle_widgets.panels.mask_inspector import LAYER
from mechstyle_widgets.state import controller as controller_module
from mechstyle_widgets.state.time_left import Stopwatch
from mechstyle_widgets.studio import Studio
from mechstyle_widgets.viewer import run_viewer
from mechstyle_widgets.viewer.run_viewer import RunViewer
from mechstyle_widgets.viewer.viewer import PartViewer
from support.sheet_studio import without_physics
from support.told import assert_tells_one_truth

PATIENCE = 30.0


@pytest.fixture
def studio(tmp_path, monkeypatch, cube):
    """A Studio whose runs take no time, with a finished run."""
    monkeypatch.chdir(tmp_path)
    without_physics(monkeypatch)
    made = Studio(cube, prompt="brick", schedule="every", every=4, iterations=12, vertices=64, folder="small")
    go(made)
    yield made
    made.close()


def go(studio):
    studio.run_controls._buttons["run"].click()
    studio.state.session.wait(PATIENCE)
    studio.state.pump()
    assert studio.state.status == "finished", studio.state.message


def test_a_refusal_ends_with_what_was_refused(studio, cube):
    """A box about van gogh stayed over brick, another part and a picture until the next run."""
    for change in (
        lambda: setattr(studio.prompt_box, "prompt", "brick"),
        lambda: studio.part_picker.show(cube.moved(0.5 * cube.vertices), "half"),
        lambda: setattr(studio.prompt_box, "image", np.full((8, 8, 3), 200, np.uint8)),
    ):
        studio.prompt_box.prompt = "my own idea"
        studio.run_controls._buttons["run"].click()
        assert "names no style" in studio.run_controls.trouble
        change()
        assert (studio.state.message, studio.run_controls.trouble) == ("", "")


@pytest.mark.parametrize(("name", "value"), [("iteration", 4), ("lane", "soft")])
def test_what_cannot_be_done_here_is_no_longer_said_elsewhere(studio, name, value):
    studio.run.branch(4, lane="soft", threshold=0.4)
    studio.state.tell(stale=True)
    studio.state.pump()
    studio.state.refuse("here this cannot be done")
    assert studio.state.alarming
    setattr(studio.state, name, value)
    assert (studio.state.message, studio.state.alarming) == ("", False)


def test_a_note_on_a_folder_stays_while_one_looks_through_the_run(studio):
    studio.state.tell(message="small holds a run with other settings: this one is in small-2")
    studio.state.pump()
    studio.state.iteration = 4
    assert "small-2" in studio.run_controls._note.value
    studio.control_selector.threshold = 0.4
    assert studio.state.message == ""


# --- what is taken away is what stands there, or is named ---------------------------------------------------------


def test_once_another_run_is_asked_for_everything_of_the_last_one_is_called_that(studio, cube):
    """After another part was chosen, verdict, report and 3MF of the one before stood there as if they were of it."""
    assert studio.take_away.main.description == "3MF"
    assert "<b>Result: " in told(studio)
    studio.part_picker.show(cube.moved(0.5 * cube.vertices), "half")
    assert studio.take_away.main.description == "3MF of part, brick"
    assert "<b>Last run: part, brick: " in told(studio)
    assert studio.run_controls.words.startswith("ready · We let it fall from 1.5 m, in simulation, about ")
    assert studio.run_controls._bar.value == 0.0
    assert studio.run_controls.title == "half, brick"
    assert isinstance(studio.viewer, PartViewer)
    assert studio.run_controls._back.layout.display is None
    studio.run_controls._back.click()
    assert (studio.state.another, studio.take_away.main.description) == (False, "3MF")
    assert isinstance(studio.viewer, RunViewer)
    assert studio.run_controls._back.layout.display == "none"


@pytest.mark.parametrize("protect", [(), ("below 1",)])
def test_what_stands_in_the_view_is_what_is_taken_away_whatever_is_hatched(studio, tmp_path, protect):
    """A hatching, be it of nothing, put a coarse mesh in the place of the surface that is delivered."""
    studio.regions_picker.protect = protect
    assert isinstance(studio.viewer, RunViewer)
    assert studio.viewer.protected.any() == bool(protect)
    shown = [scene.part for scene in studio.viewer._scenes]
    taken = trimesh.load(studio.run.export(tmp_path / "part.ply"), process=False).vertices
    assert [part.visible for part in shown] == [True]
    np.testing.assert_allclose(shown[0].geometry.attributes["position"].array, taken, atol=1e-4)


def test_another_style_stands_on_the_part_until_the_last_run_is_looked_at(studio):
    """The view stayed with the run before, and nothing named it."""
    studio.prompt_box.prompt = "stone"
    assert isinstance(studio.viewer, PartViewer)
    studio.state.iteration = 8
    assert isinstance(studio.viewer, RunViewer)
    assert "Last run: part, brick" in studio.viewer.badge._words.value
    studio.prompt_box.prompt = "wood"
    assert isinstance(studio.viewer, PartViewer)
    studio.prompt_box.prompt = "brick"
    assert isinstance(studio.viewer, RunViewer)
    assert "Last run" not in studio.viewer.badge._words.value


def test_other_settings_than_the_style_leave_the_run_in_view_under_its_name(studio):
    studio.control_selector.threshold = 0.4
    assert isinstance(studio.viewer, RunViewer)
    assert "Last run: part, brick" in studio.viewer.badge._words.value


def told(studio):
    return studio._result.value


# --- the folder, the disk -----------------------------------------------------------------------------------------


def test_a_run_whose_folder_is_gone_is_said_wherever_one_looks_and_is_made_again(studio, caplog):
    """The badge turned pale, files were not made, and the reasons went to a log."""
    shutil.rmtree(studio.run.store.root)
    studio.state.iteration = 4
    said = "The folder small is gone: put it back, or press Run to make it again."
    assert said in studio.run_controls.trouble
    studio.state.message = ""
    for button in (studio.take_away.main, studio.take_away._code):
        button.click()
        assert said in studio.take_away.trouble
        studio.take_away.complain("")
    studio.run_controls._buttons["run"].click()
    studio.state.session.wait(PATIENCE)
    studio.state.pump()
    assert (studio.state.status, studio.state.message) == ("finished", "")
    assert studio.run.store.root.is_dir()
    assert not caplog.records


@pytest.mark.parametrize("seen", [False, True])
def test_what_cannot_be_drawn_any_more_is_not_gone_to(studio, seen):
    """The timeline named iteration 4, which was in memory, over a picture of the end."""
    if seen:
        studio.state.iteration = 4
        studio.state.iteration = 12
    shutil.rmtree(studio.run.store.root)
    for go_there in (
        lambda: setattr(studio.state, "iteration", 4),
        lambda: setattr(studio._timeline, "iteration", 4),
        lambda: setattr(studio.viewer, "iteration", 4),
        lambda: studio._timeline._curves.set_state({"head": 4}),
    ):
        go_there()
        assert "The folder small is gone" in studio.run_controls.trouble
        assert studio.state.iteration == studio._timeline.iteration == studio._timeline._curves.head == studio.viewer.iteration == 12
        assert (studio.state.checkpoint.iteration, studio.viewer._drawn_place) == (12, ("main", 12))
        studio.state.message = ""


def test_an_iteration_that_is_damaged_is_left_for_the_one_that_is_drawn(studio, monkeypatch):
    whole = run_viewer.subject_of

    def damaged(run, state):
        if state.iteration == 4:
            raise DamagedStore("the simulation of iteration 4 is damaged")
        return whole(run, state)

    async def looks_at_it():
        studio._timeline.iteration = 4
        async with asyncio.timeout(PATIENCE):
            while not studio.run_controls.trouble or studio.viewer._newest._busy or studio.viewer._catch_up._waiting:  # noqa: ASYNC110 — a thread is waited for
                await asyncio.sleep(0.01)

    monkeypatch.setattr(run_viewer, "subject_of", damaged)
    asyncio.run(looks_at_it())
    assert "the simulation of iteration 4 is damaged" in studio.run_controls.trouble
    assert studio.state.iteration == studio._timeline.iteration == studio._timeline._curves.head == studio.viewer.iteration == 12
    assert_tells_one_truth(studio)
    studio._timeline.iteration = 8
    assert (studio.state.iteration, studio.run_controls.trouble) == (8, "")


def test_a_branch_of_a_folder_that_is_gone_is_not_gone_to(studio):
    studio.controller.branch(4, "soft", threshold=0.4)
    studio.state.session.wait(PATIENCE)
    studio.state.pump()
    marks = enumerate(studio._timeline._curves.data)
    trace = next(number for number, mark in marks if ["main"] in mark.get("customdata", ()))
    shutil.rmtree(studio.run.store.root)
    for go_there in (lambda: studio.branches._choice.set_state({"index": 0}), lambda: studio._timeline._clicked(trace, 0)):
        go_there()
        assert "The folder small is gone" in studio.run_controls.trouble
        assert studio.state.lane == studio._timeline.lane == studio.branches.lane == studio.branches._choice.value == "soft"
        studio.state.message = ""
    assert "which cannot be read" in repr(studio)


def test_a_folder_that_goes_in_the_middle_of_a_run_is_what_is_said(studio, monkeypatch):
    def events(run, _progress):
        shutil.rmtree(run.store.root)
        yield run.store.lane()

    monkeypatch.setattr(Run, "events", events)
    studio.control_selector.threshold = 0.4
    studio.run_controls._buttons["run"].click()
    studio.state.session.wait(PATIENCE)
    studio.state.pump()
    assert studio.state.status == "failed"
    assert "The folder small-2 is gone" in studio.run_controls.trouble


def test_a_full_disk_is_said(studio, monkeypatch):
    def full(*_args, **_more):
        raise OSError(errno.ENOSPC, "No space left on device", "x")

    monkeypatch.setattr(Draft, "ready", full)
    studio.control_selector.threshold = 0.4
    studio.run_controls._buttons["run"].click()
    studio.state.session.wait(PATIENCE)
    studio.state.pump()
    assert "The disk is full: make room and try again" in studio.run_controls.trouble
    monkeypatch.setattr(Run, "report", full)
    studio.take_away._buttons["Report"].click()
    assert "The disk is full" in studio.take_away.trouble
    monkeypatch.setattr("mechstyle_widgets.settings.part.write_whole", full)
    studio.part_picker._uploaded({"new": ({"name": "a.stl", "content": b""},)})
    assert "The disk is full" in studio.part_picker.trouble


def test_an_error_nobody_thought_of_is_said_where_the_setting_is(studio, monkeypatch):
    monkeypatch.setattr("mechstyle_widgets.settings.schedule.drawing", lambda *_: 1 / 0)
    studio.schedule_selector.every = 5
    assert "unexpected ZeroDivisionError" in studio.schedule_selector.trouble


# --- what if, at the end ------------------------------------------------------------------------------------------


def test_use_this_at_the_end_goes_on_from_the_first_test_at_which_it_makes_a_difference(studio):
    inspector = studio.mask_inspector
    inspector._use.click()
    assert "Nothing differs from MechStyle" in inspector.trouble
    inspector.selector.control, inspector._slider.value = "linear", 0.1
    assert inspector.trouble == ""
    assert studio.state.layer == LAYER, "the mask grows on the part"
    assert "goes on from iteration 4" in inspector._note.value
    inspector._use.click()
    studio.state.session.wait(PATIENCE)
    studio.state.pump()
    assert (studio.state.status, studio.state.branches[1].forked_at) == ("finished", 4)


def test_a_branch_that_would_be_the_same_or_comes_too_late_is_said_beside_its_button(studio):
    studio.branches._branch.click()
    assert "Nothing differs from MechStyle" in studio.branches.trouble
    studio.control_selector.threshold = 0.4
    assert studio.branches.trouble == ""
    studio.branches._branch.click()
    assert "Iteration 12 is the end: go to an earlier one" in studio.branches.trouble
    studio.state.iteration = 8
    assert (studio.branches.trouble, studio.state.message) == ("", "")


# --- waiting ------------------------------------------------------------------------------------------------------


def test_what_is_left_is_told_while_a_part_is_made_ready(studio, monkeypatch, cube):
    """Preparing said neither how long it takes nor that anything happens."""
    prepare, told = controller_module.prepare_in_worker, []

    def waited(mesh, *, go_on, **rest):
        go_on()
        told.append(studio.state._noted["seconds_left"])
        return prepare(mesh, go_on=go_on, **rest)

    monkeypatch.setattr(controller_module, "prepare_in_worker", waited)
    monkeypatch.setattr(Stopwatch, "total", 0.0)  # however busy the machine is
    studio.part_picker.show(cube.moved(0.5 * cube.vertices), "half")
    expected = studio.state.expected
    assert expected > 0.0
    go(studio)
    assert told == [expected]


# --- no kernel ----------------------------------------------------------------------------------------------------


def test_a_notebook_without_a_kernel_shows_a_picture_under_its_badge(studio):
    """It showed the children of a box as text."""
    picture = Image.open(io.BytesIO(studio.still()()))
    assert picture.format == "PNG"
    assert (np.asarray(picture.convert("L")) < 128).mean() > 0.01, "there is something to see"
    assert studio.viewer.captions[0] == f"part, brick: {sentences.marked(studio.run.verdict.short, sure=studio.run.verdict.sure)}"
    studio.prompt_box.prompt = "stone"
    assert studio.viewer.captions[0] == "part, stone: NOT TESTED"


def test_the_picture_in_a_notebook_is_of_what_has_come_of_it(studio, monkeypatch):
    """Of a Studio that was run after it had been shown the notebook kept the plain part."""
    made = []
    monkeypatch.setattr(cell_output, "in_a_notebook", lambda: True)
    monkeypatch.setattr("IPython.display.display", lambda data, **how: made.append((data, how)) or SimpleNamespace(update=renewed))

    def renewed(data, **_how):
        made.append((data, {}))

    studio._ipython_display_()
    (widget, _), (nothing, how), (picture, _) = made
    assert (list(nothing), list(picture), how["display_id"]) == (["image/png"], ["image/png", "text/plain"], True)
    assert "enable_custom_widget_manager() first" in widget["text/plain"], "what a page without widgets shows says what is missing"
    assert "image/png" not in widget, "which a page without the kernel would show beside the other"
    before = len(made)
    studio.prompt_box.prompt = "stone"
    go(studio)
    assert len(made) > before
    assert made[-1][0]["image/png"] != picture["image/png"]
