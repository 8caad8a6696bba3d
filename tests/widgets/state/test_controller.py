"""What the buttons do, on a run without physics."""

import shlex
import threading
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import pytest

from mechstyle.errors import BadInput
from mechstyle.geometry.files import save
from mechstyle.loop.engine import SimulationStarted
from mechstyle.runs.report.reproduce import command_for
from mechstyle.runs.run import Draft, Run
from mechstyle.simulation.estimate import duration
from mechstyle.simulation.part import Origin
from mechstyle_widgets.panels.run_controls import RunControls
from mechstyle_widgets.settings.part import PartPicker
from mechstyle_widgets.state import controller as module


def test_running_goes_to_the_end(controller, settle):
    controller.run()
    settle(controller)
    assert controller.state.status == "finished"
    assert controller.state.iterations_done == 12
    assert not controller.busy


def test_a_step_is_an_iteration(controller, settle):
    for expected in (0, 1, 2):
        controller.step()
        settle(controller)
        assert (controller.state.status, controller.state.iterations_done) == ("paused", expected)


def test_stepping_to_a_simulation_shows_it(controller, settle):
    controller.step_to_simulation()
    settle(controller)
    assert controller.state.iteration == 4
    assert controller.state.row().reason == "every 4 iterations"


def test_stop_keeps_what_was_made_and_run_goes_on_from_there(controller, settle):
    controller.step_to_simulation()
    settle(controller)
    controller.stop()
    settle(controller)
    assert (controller.state.status, controller.state.iterations_done) == ("stopped", 4)
    controller.run()
    settle(controller)
    assert (controller.state.status, controller.state.iterations_done) == ("finished", 12)


@pytest.mark.parametrize("pumped", [True, False])
def test_what_is_paused_goes_on_if_the_settings_are_still_its_own(controller, settle, pumped):
    controller.step()
    session = controller.state.session
    session.wait(30.0)
    if pumped:
        controller.state.pump()
    controller.run()
    assert controller.state.session is session
    settle(controller)
    assert controller.state.status == "finished"


def test_other_settings_while_it_is_paused_begin_another_run_and_say_so(controller, settle, monkeypatch, tmp_path):
    """The old settings were carried on without a word."""
    monkeypatch.setattr("mechstyle.runs.run.refilled", lambda given, *_: given)  # the sheet has no inside
    controller.step()
    settle(controller)
    paused, session = controller.state.run, controller.state.session
    other = paused.recipe.with_settings(threshold=0.5)
    controller.wanted = lambda: Draft(other, controller.state.run.part, 500, "sheet", str(tmp_path / "other"))
    controller.step()
    assert session.state == "stopped"
    assert f"the run that was paused is kept in {paused.store.root}" in controller.state.message
    settle(controller)
    assert (controller.state.status, controller.state.run.store.root) == ("paused", tmp_path / "other")
    assert controller.state.run.recipe.restraint.threshold == 0.5


def test_settings_that_cannot_be_used_leave_what_is_paused_as_it_is(controller, settle):
    def refuse():
        raise BadInput("the prompt is empty: write something")

    controller.step()
    settle(controller)
    controller.wanted, session = refuse, controller.state.session
    controller.run()
    assert (controller.state.message, session.state) == ("the prompt is empty: write something", "paused")


def test_a_finished_lane_says_what_to_do_next(controller, settle):
    controller.run()
    settle(controller)
    controller.run()
    assert "change a setting to begin another run" in controller.state.message


def test_settings_that_cannot_be_used_are_said(controller):
    def refuse():
        raise BadInput("the prompt is empty: write something")

    controller.wanted = refuse
    controller.run()
    assert controller.state.message == "the prompt is empty: write something"
    assert controller.state.session is None


def test_a_branch_has_its_settings_and_is_carried_on(controller, settle):
    controller.run()
    settle(controller)
    controller.branch(6, "soft", control="linear")
    settle(controller)
    state = controller.state
    assert (state.lane, state.status, state.iterations_done) == ("soft", "finished", 12)
    assert state.run.recipe.restraint.control == "linear"
    assert state.branches[1].forked_at == 6


def test_branching_needs_a_run_that_is_at_rest(controller, settle):
    controller.step()
    settle(controller)
    controller.branch(0, control="linear")
    assert "stop it before you branch" in controller.state.message
    controller.state.run = None
    controller.branch(0, control="linear")
    assert "no run to branch from" in controller.state.message


def test_a_branch_that_cannot_be_is_said(controller, settle):
    controller.run()
    settle(controller)
    controller.branch(12, control="linear")
    assert "must go beyond it" in controller.state.message


def test_other_settings_begin_another_run_with_the_part_at_hand(controller, settle, monkeypatch, tmp_path):
    other = controller.state.run.recipe.with_settings(threshold=0.5)
    controller.wanted = lambda: Draft(other, controller.state.run.part, 500, "sheet", str(tmp_path / "other"))
    assert controller.differs() == {"threshold": 0.5}
    part = controller.state.run.part
    monkeypatch.setattr(module, "prepare_in_worker", lambda *_, **__: pytest.fail("it is prepared already"))
    monkeypatch.setattr("mechstyle.runs.run.refilled", lambda given, *_: given)  # the sheet has no inside
    controller.step()
    settle(controller)
    assert controller.state.run.part.surface.digest == part.surface.digest
    assert controller.state.run.store.root == tmp_path / "other"
    assert controller.state.run.recipe.restraint.threshold == 0.5
    assert controller.state.run.record.origin == Origin(model="sheet.stl", vertices=500)


def test_another_thickening_begins_with_the_part_as_it_came(controller, settle, monkeypatch, tmp_path, sphere):
    """The part of the run before may be thickened already."""
    part, meshes = controller.state.run.part, []

    def prepared(mesh, **_):
        meshes.append(mesh)
        return part

    monkeypatch.setattr(module, "prepare_in_worker", prepared)
    unchanged = SimpleNamespace(result=sphere, noted=lambda prepared: prepared)
    monkeypatch.setattr("mechstyle.runs.run.strengthened", lambda *_, **__: unchanged)
    for budget in (0.0, 1.0, 2.0):
        wanted = controller.state.run.recipe.with_settings(strengthen=budget)
        controller.wanted = lambda wanted=wanted: Draft(wanted, sphere, 500, "sheet", str(tmp_path / "begun"))
        controller.step()
        settle(controller)
        controller.stop()
        settle(controller)
    assert [mesh is sphere for mesh in meshes] == [True] * 3


def test_a_thickened_part_without_the_one_it_was_is_not_thickened_otherwise(controller, tmp_path):
    run = controller.state.run
    run.__dict__["part"] = replace(run.part, mass_gained=3.0)  # a cached property
    other = run.recipe.with_settings(strengthen=2.0)
    controller.wanted = lambda: Draft(other, controller.state.run.part, 500, "sheet", str(tmp_path / "other"))
    controller.step()
    assert "was thickened already" in controller.state.message
    assert not (tmp_path / "other").exists()


@pytest.mark.parametrize(("model", "scale"), [("gallery:wall_hook", None), ("cup.stl", 2.5)])
def test_a_run_begun_here_can_be_made_again_from_its_report(controller, settle, monkeypatch, tmp_path, cube, model, scale):
    monkeypatch.chdir(tmp_path)
    save(cube, "cup.stl")
    picker, part = PartPicker(model, scale=scale), controller.state.run.part

    def prepared(_mesh, vertices, stage, go_on, relief):
        stage(f"standardising to {vertices}")
        go_on()
        return part

    monkeypatch.setattr(module, "prepare_in_worker", prepared)
    recipe = controller.state.run.recipe.with_settings(threshold=0.5)
    controller.wanted = lambda: Draft(recipe, picker.mesh, 900, picker.name, "begun")
    controller.run()
    settle(controller)
    run = controller.state.run
    assert (run.store.root.name, run.record.origin) == ("begun", Origin(model=model, vertices=900, scale=scale))
    assert list(run.clock.seconds()) == ["standardising to 900"]
    words = shlex.split(command_for(run, run.history))
    given = {option: value for option, value in pairwise(words) if option.startswith("--")}
    again = PartPicker(words[2], scale=float(given["--scale"]) if "--scale" in given else None)
    assert (again.mesh.digest, given["--vertices"], given["--threshold"]) == (picker.mesh.digest, "900", "0.5")


# --- the buttons themselves ---------------------------------------------------------------------------------------


def test_buttons_can_be_pressed_when_they_do_something(controller, settle):
    controls = RunControls(controller)

    def able():
        return {name for name, button in controls._buttons.items() if not button.disabled}

    assert able() == {"run", "both", "step", "step_to_simulation"}
    controls._buttons["step"].click()
    settle(controller)
    assert able() == {"run", "step", "step_to_simulation", "stop"}
    controls._buttons["run"].click()
    settle(controller)
    assert able() == {"run", "both"}
    assert "finished, iteration 12 of 12" in controls.words
    assert controls._bar.value == 1.0
    assert controls._note.value == controls.trouble == "", "the verdict is said by the badge and the result"


def test_the_button_reads_what_pressing_it_does(controller, settle, tmp_path):
    """It read «Go on» where it began another run."""
    controls, own = RunControls(controller), controller.wanted
    other = controller.state.run.recipe.with_settings(threshold=0.5)

    def chosen(recipe):
        controller.wanted = (lambda: Draft(recipe, controller.state.run.part, 500, "sheet", str(tmp_path / "other"))) if recipe else own
        controller.state.settings = {"threshold": 0.5} if recipe else {}
        return controls._buttons["run"].description

    assert chosen(None) == "Run"
    controller.step()
    settle(controller)
    for _ in ("paused", "stopped"):
        assert (chosen(None), chosen(other), chosen(None)) == ("Go on", "Run", "Go on")
        controller.stop()
        settle(controller)
    assert controller.state.status == "stopped"
    controller.wanted = lambda: pytest.fail("a run that goes on is asked several times a second")
    controller.state.tell(status="running", step=0.5)
    controller.state.pump()


def test_a_pause_that_waits_for_what_is_in_hand_says_so(controller, settle, fake, monkeypatch):
    controls, go_on, under_way = RunControls(controller), threading.Event(), threading.Event()

    def slow(run, _progress):
        for event in fake.bench.engine(run.recipe, run.lane).run():
            yield event
            if isinstance(event, SimulationStarted) and event.iteration > 0:
                under_way.set()
                go_on.wait(30)

    monkeypatch.setattr(Run, "events", slow)
    controls._buttons["run"].click()
    assert under_way.wait(30)
    controller.state.pump()
    controls._buttons["pause"].click()
    assert "pausing … when this drop test has ended" in controls.words
    assert controls._buttons["pause"].disabled
    go_on.set()
    settle(controller)
    assert controller.state.status == "paused"
    assert "pausing" not in controls.words


def test_what_is_being_done_is_told(controller):
    controls = RunControls(controller)
    controller.state.tell(status="running", stage="drop test: every 4 iterations", step=0.42, seconds_left=130.0)
    controller.state.pump()
    assert controls.words.endswith("drop test, 42% · about 2 min left")
    assert 'title="drop test: every 4 iterations"' in controls._line.value


def test_trouble_is_set_apart_from_good_news(controller):
    controls = RunControls(controller)
    controller.state.tell(status="failed", message="the disk is full: free some space", alarming=True)
    controller.state.pump()
    assert 'role="alert"' in controls.trouble
    assert "the disk is full" in controls.trouble


@pytest.mark.parametrize(("seconds", "words"), [(0.2, "1 s"), (41.0, "41 s"), (170.0, "3 min"), (7300.0, "2.0 h")])
def test_durations_for_people(seconds, words):
    assert duration(seconds) == words


@pytest.mark.parametrize("act", ["run", "step", "step_to_simulation", "both"])
def test_what_is_asked_before_a_stop_is_heard_is_answered_in_a_sentence(controller, settle, monkeypatch, act):
    inside, go = threading.Event(), threading.Event()

    def deaf(_run, _progress):
        inside.set()
        assert go.wait(30.0)
        yield

    monkeypatch.setattr(Run, "events", deaf)
    controller.run()
    assert inside.wait(30.0)
    controller.stop()
    getattr(controller, act)()
    assert controller.state.message == "the run is being stopped: go on with it when what is in hand has ended"
    go.set()
    settle(controller)
    assert controller.state.status == "stopped"


def test_a_run_that_ends_just_when_it_is_told_to_go_on_has_ended(controller, settle, monkeypatch):
    controller.run()
    settle(controller)
    monkeypatch.setattr(type(controller), "busy", True)  # as it was when it was looked at
    controller.run()
    assert controller.state.message == "the run has just ended: see what came of it before you go on"


def test_filling_the_part_at_hand_for_another_style_can_be_stopped(controller, settle, monkeypatch, tmp_path):
    """It takes minutes for a thin part, and Stop was heard only after them."""
    inside, go = threading.Event(), threading.Event()

    def filling(_part, _relief, _stage, go_on):
        inside.set()
        assert go.wait(30.0)
        go_on()
        pytest.fail("it went on although it was told to stop")

    other = controller.state.run.recipe.with_settings(threshold=0.5)
    controller.wanted = lambda: Draft(other, controller.state.run.part, 500, "sheet", str(tmp_path / "other"))
    monkeypatch.setattr("mechstyle.runs.run.refilled", filling)
    controller.run()
    assert inside.wait(30.0)
    controller.stop()
    go.set()
    settle(controller)
    assert controller.state.session.state == "stopped"
    assert not (tmp_path / "other").exists()
