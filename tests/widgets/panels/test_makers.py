"""What makers ask for: a load by a click, undo, the list of runs, what filament costs, one of several bodies."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from mechstyle.records.load_cases import RESTING_FACE
from mechstyle.runs.run import Run
from mechstyle_widgets.settings.part import PartPicker
from mechstyle_widgets.studio import Studio


@pytest.fixture
def studio():
    made = Studio("gallery:wall_hook")
    yield made
    made.close()


def top_of(studio):
    vertices = studio.viewer.undeformed.vertices
    return tuple(vertices[vertices[:, 2].argmax()].tolist())


# --- pull here ----------------------------------------------------------------------------------------------------


def test_a_click_and_an_arrow_make_a_load_that_the_part_must_carry(studio):
    place = top_of(studio)
    studio.viewer._clicks(place)
    assert studio.viewer.arrow[0] == place
    assert studio.viewer.arrow[1][2] < place[2], "the arrow points down"
    studio.pull_here.force, studio.pull_here.towards = 80.0, "against y"
    studio.pull_here.pull()
    (case,) = studio.wanted().recipe.test.loads
    assert case.name.startswith("80 N against y at 0, 9, ")
    assert case.supports[0].at == RESTING_FACE
    assert case.loads[0].force == (0.0, -80.0, 0.0)
    np.testing.assert_allclose(case.loads[0].at.near[:3], place, atol=0.01)
    studio.pull_here.pull()
    assert len(studio.wanted().recipe.test.loads) == 1, "the same again is the same load"
    assert "80 N against y" in studio.pull_here._note.value


def test_the_part_may_be_held_at_a_place_that_was_clicked(studio):
    studio.viewer._clicks(top_of(studio))
    studio.pull_here.hold()
    studio.viewer._clicks((0.0, -50.0, 4.0))
    studio.pull_here.pull()
    (case,) = studio.wanted().recipe.test.loads
    assert case.supports[0].at.near[2] == pytest.approx(top_of(studio)[2])
    studio.viewer._clicks(top_of(studio))
    studio.pull_here.hold()
    assert studio.pull_here.held is None


def test_towards_me_is_where_one_looks_from_and_out_is_the_normal(studio):
    studio.viewer.fit("front")
    studio.viewer._clicks(top_of(studio))
    for towards, axis in (("towards me", (0, -1, 0)), ("out of the surface", (0, 0, 1)), ("into the surface", (0, 0, -1))):
        studio.pull_here.towards = towards
        foot, tip = map(np.asarray, studio.viewer.arrow)
        assert (tip - foot) @ np.asarray(axis) > 0.9 * np.linalg.norm(tip - foot)


# --- undo ---------------------------------------------------------------------------------------------------------


def test_settings_and_part_are_undone_and_redone(studio):
    undo = studio._undo
    assert undo._back.disabled
    studio.prompt_box.prompt = "stone"
    studio.drop_options.height = 800.0
    studio.part_picker._gallery.press("vase")
    undo.undo()
    assert (studio.part_picker.name, studio.drop_options.height) == ("wall_hook", 800.0)
    undo.undo()
    undo.undo()
    assert (studio.prompt_box.prompt, studio.drop_options.height, undo._back.disabled) == ("brick", 1500.0, True)
    undo.redo()
    assert (studio.prompt_box.prompt, studio.drop_options.height) == ("stone", 1500.0)
    studio.prompt_box.prompt = "wood"
    assert undo._again.disabled, "another change begins another way on"


def test_a_slider_that_is_dragged_is_one_step(studio):
    for threshold in (0.9, 0.8, 0.7):
        studio.control_selector.threshold = threshold
    studio.step_back()
    assert studio.control_selector.threshold == 1.0


def test_a_criterion_and_all_that_it_brought_is_one_step(studio):
    before = studio.wanted().recipe
    studio.drop_options.criterion = "paper"
    studio.step_back()
    assert (studio.wanted().recipe, studio._undo._back.disabled) == (before, True)


# --- my runs ------------------------------------------------------------------------------------------------------


@pytest.fixture
def runs(tmp_path, monkeypatch, fake_run):
    """A Studio beside two runs, one of them on show."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("mechstyle_widgets.panels.mask_inspector._freedom", lambda run, _recipe: np.ones_like(run.part.thickness))
    fake_run(tmp_path / "mechstyle-runs" / "one").go()
    fake_run(tmp_path / "two", prompt="stone").go()
    (tmp_path / "other").mkdir()
    studio = Studio("two")
    studio.my_runs.look()
    return studio


def buttons_of(studio, title):
    row = next(row for row in studio.my_runs._rows.children if title in row.children[1].children[0].value)
    return {button.description: button for button in row.children[1].children[1].children}


def test_runs_are_listed_with_their_picture_and_outcome(runs):
    rows = runs.my_runs._rows.children
    assert len(rows) == 2
    assert all(bytes(row.children[0].value).startswith(b"\x89PNG") for row in rows)
    assert all("HOLDS" in row.children[1].children[0].value for row in rows)


def test_a_run_is_opened_and_compared(runs):
    buttons_of(runs, "brick")["compare"].click()
    assert "sheet, stone" in runs.my_runs._beside.value
    assert "sheet, brick" in runs.my_runs._beside.value
    buttons_of(runs, "brick")["open"].click()
    assert (runs.run.recipe.style.prompt, runs.prompt_box.prompt, runs.state.status) == ("brick", "brick", "finished")


def test_a_run_is_deleted_at_the_second_press_and_never_the_one_on_show(runs, tmp_path):
    shown = buttons_of(runs, "stone")["delete"]
    shown.click()
    shown.click()
    assert "on show" in runs.my_runs.trouble
    assert (tmp_path / "two" / "part.json").is_file()
    other = buttons_of(runs, "brick")["delete"]
    other.click()
    assert other.description == "delete for good?"
    assert (tmp_path / "mechstyle-runs" / "one").is_dir()
    other.click()
    assert not (tmp_path / "mechstyle-runs" / "one").exists()
    assert len(runs.my_runs._rows.children) == 1


# --- cost ---------------------------------------------------------------------------------------------------------


def test_the_filament_of_plain_and_styled_part_has_a_price(done, monkeypatch):
    monkeypatch.setattr("mechstyle_widgets.panels.mask_inspector._freedom", lambda run, _recipe: np.ones_like(run.part.thickness))
    monkeypatch.setattr(type(done.part.surface), "volume", property(lambda _mesh: 10_000.0))
    studio = Studio(Run(done.store))
    studio.material_picker.price = 25.0
    assert "12.4 g" in studio._result.value
    assert "0.31 of your currency" in studio._result.value
    studio.material_picker.price = 0.0
    assert "your currency" not in studio._result.value


# --- bodies -------------------------------------------------------------------------------------------------------


def test_of_several_bodies_in_a_file_one_is_chosen(tmp_path):
    box, ball = trimesh.creation.box((20, 20, 20)), trimesh.creation.icosphere(radius=8)
    ball.apply_translation((60, 0, 0))
    trimesh.util.concatenate([box, ball]).export(tmp_path / "two.stl")
    picker = PartPicker("gallery:wall_hook")
    picker._path.value = str(tmp_path / "two.stl")
    assert "two.stl holds several bodies: choose one." in picker.trouble
    assert picker.name == "wall_hook", "what was chosen before stays"
    assert [value for _, value in picker._body.options] == ["", "1", "2"]
    picker._body.value = "2"
    assert (picker.name, picker.body, picker.trouble) == ("two", "2", "")
    assert picker.mesh.extents.max() < 17.0
    picker.choose("gallery:vase")
    assert (picker.body, picker._body.layout.display) == ("", "none")
