"""The Studio put together: settings in, a run out, everything that follows it follows."""

from dataclasses import replace

import numpy as np
import pytest

from mechstyle import teaching
from mechstyle.errors import BadInput
from mechstyle.geometry.files import save
from mechstyle.records.load_cases import Load, LoadCase, Support
from mechstyle.records.recipe import DEFAULTS
from mechstyle.records.regions import regions
from mechstyle.runs.recipes import recipe_for
from mechstyle.runs.run import Run
from mechstyle.runs.stylizers import FinishedStyle
from mechstyle.simulation.part import Shape
from mechstyle_widgets.jupyter.cell_output import OncePerCell
from mechstyle_widgets.jupyter.language import speak
from mechstyle_widgets.settings.drop import SIZES
from mechstyle_widgets.state.preview import Enlarged, Preview, Previewer
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.studio import OF_A_PART, Studio
from mechstyle_widgets.viewer.run_viewer import RunViewer
from support.models import alive


@pytest.fixture
def unprotected(monkeypatch):
    monkeypatch.setattr("mechstyle_widgets.panels.mask_inspector._freedom", lambda run, _recipe: np.ones_like(run.part.thickness))


def test_settings_given_by_name_reach_the_recipe():
    studio = Studio("gallery:wall_hook", prompt="small wood", material="PETG", control="linear", every=7, schedule="every", vertices=900,
                    threshold=0.5, protect=["inside"], height=800)  # fmt: skip
    wanted = studio.wanted()
    recipe = wanted.recipe
    assert recipe.settings.items() >= {"prompt": "small wood", "control": "linear", "every": 7, "threshold": 0.5, "height": 800.0}.items()
    assert (recipe.test.material.name, recipe.restraint.protect[0].words) == ("PETG", "inside")
    assert (wanted.vertices, wanted.name) == (900, "wall_hook")
    assert wanted.part is studio.part_picker.mesh


def test_the_first_part_is_that_of_demo_and_lessons_in_their_style():
    studio = Studio(material="PETG")
    wanted = studio.wanted()
    assert wanted.part is teaching.trophy()
    assert (wanted.vertices, wanted.name) == (len(teaching.trophy().vertices), "trophy")
    lesson = teaching.settled(material="PETG", window=None)
    assert wanted.recipe.settings == lesson.settings


CASE = LoadCase(name="heavy coat", supports=(Support(at="resting face"),), loads=(Load(gravity=1.0),))


@pytest.mark.usefixtures("unprotected")
def test_poses_and_loads_go_into_the_recipe_and_out_of_it_again(tmp_path, fake_run):
    given = {"poses": "resting", "loads": [CASE], "schedule": "every", "every": 4, "iterations": 12}
    assert Studio("gallery:wall_hook", orientations=3, **given).wanted().recipe.test.orientations == 3
    recipe = Studio("gallery:wall_hook", **given).wanted().recipe
    assert (recipe.test.poses, recipe.test.orientations, recipe.test.loads) == ("resting", 8, (CASE,))
    made = fake_run(tmp_path / "loaded", poses="resting", orientations=8, loads=(CASE,))
    made.go()
    studio = Studio(made.run)
    assert (studio.drop_options.way, studio.drop_options.orientations, studio.drop_options.loads) == ("resting", 8, (CASE,))
    assert studio.controller.differs() == {}


@pytest.mark.usefixtures("unprotected")
def test_settings_without_a_control_may_be_given_and_stay(tmp_path, fake_run):
    assert Studio("gallery:wall_hook", window=2.0, element="tet4").wanted().recipe.test.window == 2.0
    made = fake_run(tmp_path / "other", window=2.0, friction=0.3)
    made.go()
    studio = Studio(made.run)
    assert (studio.wanted().recipe.test.window, studio.controller.differs()) == (2.0, {})


def test_a_criterion_brings_its_method_as_on_the_command_line_and_back():
    """It brought elements and transfer, which are not on show, and left base, corrections and masks as they were."""
    studio = Studio("gallery:wall_hook")
    usual = studio.wanted().recipe
    studio.drop_options.criterion = "paper"
    published = recipe_for("brick", criterion="paper")
    assert studio.wanted().recipe == Studio("gallery:wall_hook", criterion="paper").wanted().recipe == published
    assert "leaves little of a style" in studio.drop_options.children[-2].value
    assert Studio("gallery:wall_hook", criterion="paper", base="level").wanted().recipe == recipe_for(
        "brick", criterion="paper", base="level"
    )
    studio.drop_options.criterion = "robust"
    assert studio.wanted().recipe == usual


@pytest.mark.usefixtures("unprotected")
def test_a_run_by_the_published_rule_opens_with_its_own_settings(tmp_path, fake_run):
    made = fake_run(tmp_path / "published", criterion="paper", base="plain", nearly_flat=True)
    made.go()
    studio = Studio(made.run)
    assert studio.controller.differs() == {}
    assert studio.regions_picker.base == "plain"


@pytest.mark.usefixtures("unprotected")
def test_part_and_style_stand_over_the_run(tmp_path, fake_run):
    studio = Studio("gallery:wall_hook", prompt="small wood", vertices=900)
    assert studio.run_controls.title == "wall hook, small wood"
    studio.prompt_box.prompt = "<b>stone"
    assert "<b>wall hook, &lt;b&gt;stone</b> · </span><span role=" in studio.run_controls._line.value, "what a name says is no markup"
    made = fake_run(tmp_path / "titled")
    made.go()
    assert Studio(made.run).run_controls.title == "sheet, brick"


def test_freestyle_brings_its_preset():
    recipe = Studio("gallery:wall_hook", freestyle=True, iterations=50).wanted().recipe
    assert recipe.settings.items() >= {"control": "none", "schedule": "never", "guarantee": False, "iterations": 50}.items()


@pytest.mark.parametrize(
    ("name", "cure"), [("quick", "ask for fewer vertices instead"), ("treshold", "did you mean 'threshold'"), ("xyz", "help(Studio)")],
)  # fmt: skip
def test_an_unknown_setting_is_refused_in_one_line_with_what_to_do(name, cure):
    with pytest.raises(BadInput, match=f"the Studio has no setting {name!r}") as refused:
        Studio("gallery:wall_hook", **{name: True})
    (line,) = refused.value._render_traceback_()
    assert cure in line
    assert len(line) < 140
    assert "\n" not in line


@pytest.mark.parametrize(
    ("given", "line"),
    [
        ({"threshold": "x"}, "threshold is 'x', but must be a number"),
        ({"threshold": 0}, "threshold is 0, but must lie between 0.01 and 100"),
        ({"relief": float("nan")}, "relief is nan, but must lie between 0 and 20"),
        ({"window": 0}, "window is 0, but must lie between 0.05 and 50"),
        ({"crops": 0}, "crops is 0, but must lie between 1 and 16"),
        ({"price": float("nan")}, "price must be a number, not nan"),
        *(
            ({"vertices": wrong}, f"vertices is {wrong!r}, but must be a whole number between 500 and 400000")
            for wrong in (-1, 10, 10**9, 4000.5, "many", True)
        ),
        ({"theme": "blue"}, "theme must be one of ['auto', 'light', 'dark'], not 'blue'"),
        ({"filled": "yes"}, "filled must be True or False, not 'yes'"),
        ({"prompt": 5}, "prompt must be text, not 5"),
        ({"language": 5}, "unknown language '5': known are de, en"),
        ({"scale": "big"}, "scale is 'big', but must be a positive number, such as 25.4 for inches"),
    ],
)
def test_a_value_of_the_wrong_kind_is_refused_in_one_line(tmp_path, cube, given, line):
    """It ended in 25 lines and the names of widgets inside."""
    with pytest.raises(BadInput) as refused:
        Studio(save(cube, tmp_path / "cup.stl"), **given)
    assert str(refused.value) == line


def test_a_second_studio_speaks_the_language_of_the_first():
    """Beside an English one, the view, the badge and the timeline of the German one were English."""
    try:
        Studio("gallery:wall_hook", language="de")
        assert Studio("gallery:wall_hook").run_controls._buttons["run"].description == "Start"
    finally:
        speak("en")


def test_a_file_dropped_on_the_view_is_the_part(tmp_path, monkeypatch, cube):
    monkeypatch.chdir(tmp_path)
    studio = Studio("gallery:wall_hook")
    save(cube, tmp_path / "cube.stl")
    file = memoryview((tmp_path / "cube.stl").read_bytes())
    studio.frame._handle_custom_msg({"kind": "dropped", "name": "../mine.stl"}, [file])
    assert (studio.part_picker.name, studio.part_picker.trouble) == ("mine", "")
    assert studio.part_picker.mesh.extents.tolist() == pytest.approx([10.0] * 3)
    before = studio.part_picker.mesh
    studio.frame._handle_custom_msg({"kind": "dropped", "name": "notes.txt"}, [memoryview(b"no part")])
    assert studio.part_picker.mesh is before
    assert "notes.txt" in studio.part_picker.trouble


def test_the_browser_is_given_a_word_when_a_run_has_ended(monkeypatch, fake):
    studio, told = Studio("gallery:wall_hook"), []
    monkeypatch.setattr(studio.frame, "tell", told.append)
    studio.state.watch(fake.session(), 12).run()
    studio.state.session.wait(30)
    studio.state.pump()
    assert told == [f"The run of {studio.state.title} is finished."]


def test_a_part_that_is_not_there_is_refused():
    with pytest.raises(BadInput, match="does not exist"):
        Studio("nowhere.stl")


def test_lambda_and_relief_are_known_wherever_they_count():
    studio = Studio("gallery:wall_hook")
    studio.control_selector._lambda.value = 0.5
    assert studio.material_picker.material.safety_coefficient == 0.5
    assert studio.wanted().recipe.test.material.safety_coefficient == 0.5
    studio.prompt_box.relief = 0.9
    assert studio.schedule_selector.relief == studio.wanted().recipe.style.relief == 0.9


def test_what_is_asked_for_is_in_the_state():
    studio = Studio("gallery:wall_hook")
    studio.schedule_selector.schedule = "quadratic"
    assert studio.state.settings["schedule"] == "quadratic"


def test_another_part_is_shown_at_once():
    studio = Studio("gallery:wall_hook")
    before = studio._viewer
    studio.part_picker._gallery.press("vase")
    assert studio._viewer is not before
    assert np.allclose(studio._viewer.subject.mesh.extents, studio.part_picker.mesh.extents)


def test_the_recipe_is_worked_out_once_for_each_change(cube):
    studio = Studio(cube, build_direction=np.array([0.0, 0.0, 1.0]))
    before = studio.wanted().recipe
    assert studio.wanted().recipe is before
    studio.control_selector.threshold = 0.7
    assert studio.wanted().recipe == before.with_settings(threshold=0.7)
    studio._unseen = {**studio._unseen, "build_direction": (1.0, 0.0, 0.0)}
    assert studio.wanted().recipe.test != before.test
    studio.control_selector.freestyle = True
    assert studio.wanted().recipe.restraint.control == "none"


def test_another_part_has_defaults_of_its_own_and_one_undo_brings_all_back(cube):
    """The first click on another part smeared one brick over a cup: it had the sizes and the vertices of the trophy."""
    given = {"relief": 3.0, "side": "inwards", "feature": 9.0, "protect": ["sphere 0 0 0 2"], "vertices": 1382, "strengthen": 1.0}
    studio = Studio(cube, prompt="stone", height="2 m", **given)
    before = studio._all_settings()
    studio.part_picker.choose("gallery:wall_hook")
    wanted = studio.wanted()
    assert all(wanted.recipe.settings[name] == DEFAULTS[name] for name in OF_A_PART)
    assert (wanted.vertices, studio.drop_options.sizes.value) == (SIZES["Try it"], SIZES["Try it"])
    assert studio.part_picker._gallery.value == "wall_hook"
    assert (wanted.recipe.style.prompt, wanted.recipe.test.height) == ("stone", 2000.0), "what is asked of any part stays"
    studio.step_back()
    assert studio._all_settings() == before
    studio.step_back(forward=True)
    assert studio.wanted().vertices == SIZES["Try it"]


@pytest.mark.parametrize(("count", "marked"), [(3988, 4000), (4000, 4000), (3500, None), (99_120, 100_000)])
def test_how_fine_it_is_is_marked_where_remeshing_gave_a_few_vertices_more_or_less(cube, count, marked):
    studio = Studio(cube, vertices=count)
    assert studio.drop_options.sizes.value == marked
    assert studio.wanted().vertices == count


def test_what_is_painted_is_hatched_at_once_and_reaches_the_recipe():
    studio = Studio("gallery:wall_hook")
    viewer, top = studio._viewer, studio._viewer.subject.mesh.vertices[:, 2].argmax()
    place = tuple(viewer.subject.mesh.vertices[top].tolist())
    studio.regions_picker.radius = 4.0
    viewer._clicks(place)
    assert studio.regions_picker.place == place
    assert not viewer.protected.any()  # the switch is off
    studio.regions_picker.paint = True
    viewer._clicks(place)
    near = np.linalg.norm(viewer.subject.mesh.vertices - place, axis=1)
    assert viewer.protected[near < 3.9].all()
    assert not viewer.protected[near > 4.1].any()
    assert studio.wanted().recipe.restraint.protect[0].radius == 4.0
    viewer._clicks(place)
    assert studio.wanted().recipe.restraint.protect == ()
    assert not viewer.protected.any()


def test_a_click_that_paints_asks_nothing_of_the_place_and_an_arrow_is_there_while_one_asks():
    studio = Studio("gallery:wall_hook")
    viewer, tab = studio._viewer, studio._tabs.selected_index
    place = tuple(viewer.subject.mesh.vertices[0].tolist())
    studio.regions_picker.paint = True
    viewer._clicks(place)
    assert (studio._tabs.selected_index, viewer.arrow) == (tab, ())
    studio.regions_picker.paint = False
    viewer._clicks(place)
    assert (studio._tabs.selected_index != tab, viewer.arrow != ()) == (True, True)
    studio._tabs.selected_index = tab
    assert viewer.arrow == ()


def test_a_preview_is_shown_on_the_part_with_what_stays_plain_until_it_cannot_be_drawn():
    studio = Studio("gallery:wall_hook")
    surface = studio.part_picker.mesh
    count = len(surface.vertices)
    spared = np.arange(count) < 9
    style = FinishedStyle(np.full(count, 0.5, np.float32), np.full((count, 3), 0.2), spared, ())
    studio._viewer.fit("top")
    studio._arrived(Preview(Shape(surface, np.full(count, 8.0, np.float32)), style, 0.4))
    viewer = studio._viewer
    assert viewer.undeformed is surface
    assert viewer._orbit.seen.elevation == pytest.approx(90.0, abs=0.1)
    np.testing.assert_allclose(viewer.subject.mesh.vertices, surface.displaced(style.relief).vertices)
    np.testing.assert_array_equal(viewer.protected, spared)
    assert "NOT TESTED" in viewer.badge._words.value
    assert "drawn in 0.4 s" in viewer.badge._words.value
    studio._arrived(Preview(Shape(surface, np.full(count, 8.0, np.float32)), style, 0.04))
    assert "drawn at once" in viewer.badge._words.value
    viewer.beside = True
    np.testing.assert_allclose(viewer.original.mesh.vertices, surface.vertices)
    studio.prompt_box.prompt = "nonsense"
    assert viewer.subject.mesh is surface
    assert viewer.badge.layout.display == "none"
    studio._not_drawn("ask for 500 vertices")
    assert "ask for 500 vertices" in viewer.badge._words.value


def test_what_is_hatched_is_what_is_painted_now_and_all_else_that_the_last_preview_knew():
    """A click took the hatching from the underside until the next preview, and the preview of before it brought back what it had taken."""
    studio = Studio("gallery:wall_hook")
    surface = studio.part_picker.mesh
    top, count = surface.vertices[:, 2].argmax(), len(surface.vertices)
    ball = f"sphere {' '.join(map(str, surface.vertices[top]))} 4"
    painted = np.linalg.norm(surface.vertices - surface.vertices[top], axis=1) < 4.0
    base = surface.vertices[:, 2] < 1.0
    assert painted.any()
    assert base.any()

    def preview(spared, *protect):
        style = FinishedStyle(np.zeros(count, np.float32), np.full((count, 3), 0.2), spared, ())
        return Preview(Shape(surface, np.full(count, 8.0, np.float32)), style, 0.4, regions(list(protect)))

    studio._arrived(preview(base))
    studio.regions_picker.protect = [ball]
    np.testing.assert_array_equal(studio._viewer.protected, base | painted)
    studio._arrived(preview(base | painted, ball))
    np.testing.assert_array_equal(studio._viewer.protected, base | painted)
    studio.regions_picker.protect = []
    np.testing.assert_array_equal(studio._viewer.protected, base)
    studio._arrived(preview(base | painted, ball))  # asked for before that
    np.testing.assert_array_equal(studio._viewer.protected, base)


@pytest.mark.parametrize("how", ["drawn", "only running tells", "refused"])
def test_the_plain_part_is_pictured_only_where_no_style_is_to_come(monkeypatch, how):
    """Its picture took a second of what the style needs, to be taken away by that of the style."""
    pictured = []
    monkeypatch.setattr(OncePerCell, "renew_still", lambda studio: pictured.append(studio._viewer.original is not None))
    studio = Studio("gallery:wall_hook")
    surface = studio.part_picker.mesh
    count = len(surface.vertices)
    studio.renew_still()
    assert pictured.pop() is False, "without an event loop nothing is to come"
    studio.previewer._wish = "a style"
    studio.renew_still()
    assert pictured == []
    style = FinishedStyle(np.zeros(count, np.float32), np.full((count, 3), 0.2), np.zeros(count, bool), ()) if how == "drawn" else None
    for _ in range(2):
        if how == "refused":
            studio._not_drawn("ask for 500 vertices")
        else:
            studio._arrived(Preview(Shape(surface, np.full(count, 8.0, np.float32)), style, 0.4))
    assert pictured == [how == "drawn"], "the first alone"
    studio.renew_still()
    assert len(pictured) == 2


def test_a_preview_that_cannot_be_shown_is_said():
    """The event loop kept the error to its log."""
    studio = Studio("gallery:wall_hook")
    surface = studio.part_picker.mesh
    style = FinishedStyle(np.zeros(3, np.float32), np.zeros((3, 3)), np.zeros(len(surface.vertices), bool), ())
    studio.previewer._arrived(Preview(Shape(surface, np.full(len(surface.vertices), 8.0, np.float32)), style, 0.1))  # of another part
    assert "This did not work, by an unexpected" in studio.state.message
    assert studio.state.alarming


def test_a_part_that_is_ready_is_shown_by_the_view_in_which_its_style_will_stand(monkeypatch, cube):
    """A page made two views of every part that is opened, one to be thrown away, which is most of its work."""
    monkeypatch.setattr(Previewer, "ready", lambda *_: cube)
    studio = Studio("gallery:wall_hook")
    first, again, count = studio.viewer, cube.moved(cube.vertices), len(cube.vertices)
    assert first.undeformed is cube
    style = FinishedStyle(np.full(count, 0.5, np.float32), np.full((count, 3), 0.2), np.arange(count) < 3, ())
    studio._arrived(Preview(Shape(again, np.full(count, 8.0, np.float32)), style, 0.4))
    assert studio.viewer is first
    assert first.protected.sum() == 3


def test_a_part_whose_style_is_on_its_way_says_so(monkeypatch):
    """It stood there plain for fifteen seconds without any sign."""
    monkeypatch.setattr(Previewer, "ask", lambda *_: True)
    studio = Studio("gallery:wall_hook")
    assert "The style is being drawn on the part" in studio.viewer.badge._words.value
    studio.part_picker._gallery.press("vase")
    assert "The style is being drawn on the part" in studio.viewer.badge._words.value


def test_walls_too_thin_are_said_with_the_part_as_soon_as_a_preview_has_measured_them():
    studio = Studio("gallery:wall_hook")
    surface = studio.part_picker.mesh
    preview = Preview(Shape(surface, np.full(len(surface.vertices), 0.4, np.float32)), None, 0.1)
    for minimum, told in ((0.8, True), (0.3, False)):
        studio.drop_options.minimum_wall = minimum
        studio._arrived(preview)
        said = studio.part_picker._note.value
        assert ("a wall of 0.40 mm" in said) is told
        assert ("mechstyle-warning" in said) is told, "among grey notes on the file nobody sees it"
        assert "wall hook: " in said


def test_a_place_off_the_part_is_said():
    studio = Studio("gallery:wall_hook")
    studio.regions_picker.protect = ["sphere 900 0 0 1"]
    assert "holds nothing of this part" in studio.regions_picker.trouble
    assert studio._viewer.protected is None


def test_an_empty_prompt_is_said_and_nothing_begins():
    studio = Studio("gallery:wall_hook")
    studio.prompt_box.prompt = "nonsense"
    studio.run_controls._buttons["run"].click()
    assert "names no style" in studio.state.message
    assert "names no style" in studio.run_controls.trouble
    assert studio.state.session is None


def test_view_and_timeline_take_the_room_that_the_page_has_and_keep_it():
    studio = Studio("gallery:wall_hook")
    studio.frame.size = [1100, 560]
    assert [(view.width, view.height) for view in studio._viewer._views] == [(1100, 560)]
    assert studio._timeline._curves.frame["width"] == 1100
    studio.part_picker._gallery.press("vase")
    assert [(view.width, view.height) for view in studio._viewer._views] == [(1100, 560)]


def test_the_theme_is_the_notebooks_unless_it_is_told():
    studio = Studio("gallery:wall_hook")
    assert (studio._viewer.theme, studio._timeline.theme) == ("light", "light")
    studio.frame.dark = True
    assert (studio._viewer.theme, studio._timeline.theme) == ("dark", "dark")
    studio.theme = "light"
    assert (studio._viewer.theme, studio._timeline.theme) == ("light", "light")


def test_groups_of_settings_tell_what_is_chosen_while_they_are_folded():
    studio = Studio("gallery:wall_hook")
    group = studio._groups[2]
    studio.material_picker._choice.value = "PETG"
    assert group._head.description == f"Material: PETG, {studio.material_picker.material.yield_strength:g} MPa"
    group._head.click()
    assert (group._head.description, group.unfolded, studio.material_picker.layout.display) == ("Material", True, None)


# --- a run on disk ------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("unprotected")
def test_a_run_opens_with_its_settings_and_its_newest_iteration(done):
    studio = Studio(done.store.root)
    assert (studio.state.iteration, studio.state.lane) == (12, "main")
    assert studio.prompt_box.prompt == "brick"
    assert studio.schedule_selector.every == 4
    assert studio.controller.differs() == {}
    assert isinstance(studio._viewer, RunViewer)
    assert studio.part_picker.name == "sheet"
    assert studio.wanted().part is studio.run.part  # the part of the run is at hand
    studio.drop_options.vertices = 700
    assert studio.wanted().part is studio.part_picker.mesh


@pytest.mark.usefixtures("unprotected")
def test_one_button_is_filled_and_it_leads_on(done):
    def filled(studio):
        return studio.run_controls._buttons["run"].button_style, studio.take_away.main.button_style

    assert filled(Studio("gallery:wall_hook")) == ("primary", "")
    studio = Studio(done)
    assert filled(studio) == ("", "primary")
    studio.prompt_box.prompt = "stone"
    assert filled(studio) == ("primary", "")
    studio.prompt_box.prompt = "brick"
    assert filled(studio) == ("", "primary")


@pytest.mark.usefixtures("unprotected")
def test_taking_it_away_leads_on_once_a_correction_has_mended_it(done):
    """What is offered for a part that fails went, and no button was filled any more."""
    studio = Studio(done)
    studio.next_steps.steps = [object()]  # as long as its last iteration failed
    studio._emphasise()
    assert studio.take_away.main.button_style == ""
    studio.state.checkpoint = replace(studio.state.checkpoint, keyframe=None, parent="another")
    assert (studio.next_steps.steps, studio.take_away.main.button_style) == ([], "primary")


@pytest.mark.usefixtures("unprotected")
def test_what_is_said_of_the_pattern_of_one_style_goes_with_it(done, monkeypatch):
    """Mortar joints were too large for the mesh, and moss was asked for."""
    studio = Studio(done)
    studio._enlarged = studio.prompt_box.prompt
    studio.prompt_box.enlarge(Enlarged("mortar joints", 3.0, 20_000))
    monkeypatch.setattr(StudioState, "busy", True)  # paused
    studio.control_selector.threshold = 0.4
    assert studio.prompt_box._cure.layout.display != "none"
    studio.prompt_box.prompt = "moss"
    assert studio.prompt_box._cure.layout.display == "none"


@pytest.mark.usefixtures("unprotected")
def test_what_is_told_of_a_place_does_not_push_the_timeline_down(done):
    studio = Studio(done)
    studio.viewer.probed = 3
    _pull, told = studio._asked.children
    assert "place" in told.value
    assert "mm" in studio.viewer._said.value
    assert told not in studio.viewer._foot.children


@pytest.mark.usefixtures("unprotected")
def test_a_lane_of_it_can_be_named(done):
    studio = Studio(f"{done.store.root}@soft")
    assert studio.run.recipe.restraint.control == "linear"
    assert studio.control_selector.control == "linear"


@pytest.mark.usefixtures("unprotected")
def test_choosing_a_lane_shows_its_settings_and_starts_nothing(done):
    studio = Studio(done)
    studio.branches._choice.value = "soft"
    assert (studio.control_selector.control, studio.schedule_selector.every) == ("linear", 3)
    assert (studio.state.settings["control"], studio.controller.differs()) == ("linear", {})
    studio._timeline.lane = "main"
    assert (studio.control_selector.control, studio.schedule_selector.every) == ("exponential", 4)
    assert (studio.controller.differs(), studio.state.session) == ({}, None)


@pytest.mark.usefixtures("unprotected")
def test_settings_without_a_control_are_those_of_the_lane_on_show(tmp_path, fake_run):
    made = fake_run(tmp_path / "other")
    made.go().branch(6, lane="long", window=2.0)
    studio = Studio(made.run)
    studio.state.lane = "long"
    assert (studio.wanted().recipe.test.window, studio.controller.differs()) == (2.0, {})


def test_what_freestyle_leaves_out_is_left_out_of_what_is_asked_for():
    studio = Studio("gallery:wall_hook", freestyle=True, iterations=50)
    assert studio.state.settings["schedule"] == "never"
    assert studio._timeline._curves.data[-1]["x"] == [0, 50]
    studio.control_selector.freestyle = False
    assert len(studio._timeline._curves.data[-1]["x"]) > 2


@pytest.mark.usefixtures("unprotected")
def test_one_iteration_is_on_show_everywhere(done):
    studio = Studio(done)
    studio._timeline.iteration = 5
    assert (studio.state.iteration, studio._viewer.iteration) == (5, 5)
    assert studio.branches._branch.description == "branch from iteration 5"
    studio._viewer.layer = "stress"
    assert studio.state.layer == "stress"
    studio.branches._choice.value = "soft"
    assert (studio._timeline.lane, studio._viewer.lane) == ("soft", "soft")


@pytest.mark.usefixtures("unprotected")
def test_a_pinned_iteration_stands_beside_the_one_on_show(done):
    studio = Studio(done)
    studio.state.iteration = 4
    studio.branches._pin.click()
    studio.state.lane, studio.state.iteration = "soft", 9
    viewer = studio._viewer
    assert viewer.beside
    assert viewer.names == ("soft, iteration 9", "MechStyle, iteration 4")
    studio.state.iteration = 8
    assert viewer.names == ("soft, iteration 8", "MechStyle, iteration 4")
    assert np.allclose(viewer.original.mesh.vertices, done.surface(4).vertices)
    assert not np.allclose(viewer.subject.mesh.vertices, viewer.original.mesh.vertices)
    studio.state.lane, studio.state.iteration = "main", 4
    studio.branches._pin.click()
    assert (studio.branches.pinned, viewer.beside, viewer.names) == (None, False, ("styled", "plain"))
    assert np.allclose(viewer.original.mesh.vertices, done.part.surface.vertices)


@pytest.mark.usefixtures("unprotected")
def test_the_what_if_layer_moves_with_the_threshold(done):
    studio = Studio(done)
    studio.state.iteration, studio.state.layer = 8, "what_if"
    before = studio._viewer.subject.layer("what_if").values
    assert ("what if", "what_if") in studio._viewer._toolbar.choice.options
    studio.mask_inspector.selector.threshold = 0.05
    assert studio._viewer.subject.layer("what_if").values.sum() > before.sum()


@pytest.mark.usefixtures("unprotected")
def test_an_interrupted_run_is_reopened_and_goes_on(fake, monkeypatch, caplog):
    session = fake.session()
    session.run_until(lambda event: getattr(getattr(event, "checkpoint", None), "iteration", 0) == 5)
    session.wait(30.0)
    session.stop()
    session.wait(30.0)
    monkeypatch.setattr(Run, "events", lambda run, _progress: fake.bench.engine(run.recipe, run.lane).run())
    studio = Studio(fake.run.store.root)
    assert (studio.state.iteration, studio.state.status) == (5, "stopped")
    assert (caplog.records, studio.run_controls._buttons["run"].description) == ([], "Go on")
    assert studio.state.fraction == pytest.approx(5 / 12)
    studio.run_controls._buttons["run"].click()
    studio.state.session.wait(30.0)
    studio.state.pump()
    assert (studio.state.status, studio.state.iteration, len(studio.state.branches)) == ("finished", 12, 1)
    assert studio._timeline.iteration == 12


@pytest.mark.usefixtures("unprotected")
def test_closing_leaves_nothing_behind(done):

    Studio(done).close()
    before = alive()
    Studio(done).close()
    assert alive() == before
