"""Material, prompt, part, regions, drop test: mouse and Python set the same, and what is wrong is said in one sentence."""

from datetime import UTC, datetime

import msgspec
import numpy as np
import pytest

from mechstyle import gallery
from mechstyle.errors import BadInput
from mechstyle.geometry.files import save
from mechstyle.records.load_cases import read_loads
from mechstyle.records.material import LIBRARY
from mechstyle.records.recipe import BASES
from mechstyle.records.regions import Inside, Sphere
from mechstyle.runs.images import digest_of
from mechstyle.runs.recipes import draft
from mechstyle.styling.drawing.raster import png_of
from mechstyle.styling.library import names
from mechstyle_widgets.jupyter.looks import family
from mechstyle_widgets.settings.drop import ONCE, DropOptions
from mechstyle_widgets.settings.material import MaterialPicker
from mechstyle_widgets.settings.part import PartPicker
from mechstyle_widgets.settings.prompt import PromptBox
from mechstyle_widgets.settings.regions import RegionsPicker
from mechstyle_widgets.settings.section import AUTO
from support.records import recipe

# --- material -----------------------------------------------------------------------------------------------------


def test_a_material_of_the_library():
    picker = MaterialPicker("petg")
    assert picker.material == LIBRARY["PETG"]
    picker._choice.value = "ABS"
    assert picker.material == LIBRARY["ABS"]
    assert picker._figures["yield_strength"].value == 33.0
    assert "Stratasys" in picker._note.value


def test_figures_may_be_edited_in_units_people_know():
    picker = MaterialPicker("PLA")
    picker._figures["density"].value = 1.3
    assert picker.material.density == pytest.approx(1.3e-3)
    assert picker._choice.label == "PLA (edited)"
    assert "edited by hand" in picker._note.value


def test_another_material_can_be_chosen_after_figures_were_edited():
    picker = MaterialPicker("PLA")
    picker._figures["density"].value = 1.3
    picker._choice.set_state({"index": 1})  # as a browser sends it
    assert picker.material == LIBRARY["PETG"]
    assert picker._choice.label == "PETG"


def test_a_figure_no_solid_has_is_refused_and_the_last_one_stays():
    picker = MaterialPicker("PLA")
    picker._figures["poisson_ratio"].value = 0.7
    assert picker.material == LIBRARY["PLA"]
    assert "poisson_ratio is 0.7, but must lie in" in picker.trouble


def test_python_may_set_any_material():
    picker = MaterialPicker()
    own = msgspec.structs.replace(LIBRARY["PLA"], name="mine", yield_strength=40.0)
    picker.material = own
    assert picker._figures["yield_strength"].value == 40.0
    assert picker._choice.label == "mine (edited)"


# --- prompt -------------------------------------------------------------------------------------------------------


def test_a_prompt_is_read_aloud():
    box = PromptBox("small blue stones")
    assert box.reading.wishes[0].style == "stone"
    assert box._chips.value == "stone"
    assert "features × 0.7" in box._note.value


def test_the_relief_is_chosen_in_millimetres_or_left_to_the_part():
    box = PromptBox("brick")
    assert (box.relief, box._relief.label) == (None, "auto")
    box._relief.value = 0.6
    assert box.settings["relief"] == 0.6
    box.relief = 0.65
    assert (box._relief.value, box._relief.label) == (0.65, "0.65 mm"), "what Python sets need not be on the slider beforehand"
    box._relief.value = AUTO
    assert box.relief is None
    assert PromptBox("brick", feature=4.4)._feature.label == "4.4 mm"


def test_a_share_of_the_wall_is_shown_where_a_run_has_one():
    box = PromptBox("brick")
    box.take(recipe(amplitude=0.15))
    assert (box._relief.label, box.settings["amplitude"], box.relief) == ("0.15 of wall", 0.15, None)
    box.take(recipe(relief=0.8))
    assert (box._relief.label, box.settings["amplitude"], box.relief) == ("0.8 mm", None, 0.8)
    box.take(recipe())
    assert (box._relief.label, box.relief) == ("auto", None)


def control(box, description):
    """The control of a section that is described so."""
    return next(one for one in family(box) if getattr(one, "description", "") == description)


OTHERS = [("side", "goes", "outwards"), ("inside", "inside", "styled"), ("feature", "size", 5.0)]


@pytest.mark.parametrize(("trait", "described", "value"), OTHERS)
def test_what_else_the_style_section_sets_reaches_the_recipe(trait, described, value):
    box = PromptBox("brick")
    control(box, described).value = value
    assert box.settings[trait] == value


def test_a_style_for_each_place_is_read_aloud_and_a_picture_takes_the_place_of_the_first():
    box = PromptBox("outside: brick; rim: gold studs")
    assert "read as outside: brick; rim: studs, in #c99a2e" in box._note.value
    assert box._chips.value == "brick"
    box._chips.press("wood")
    assert box.prompt == "outside: wood; rim: gold studs"


def test_an_unknown_place_and_a_prompt_without_end_are_complaints():
    assert "is no place that is known on every part" in PromptBox("handle: wood").trouble
    assert "may have 500" in PromptBox("brick " * 100).trouble


def test_what_was_not_understood_is_said():
    assert "left out: &#x27;wobbly&#x27;" in PromptBox("wobbly brick")._note.value


def test_a_prompt_without_a_style_names_the_nearest_and_leaves_no_reading():
    box = PromptBox("brick")
    box._text.value = "bricc-a-brac"
    box._text.value = "marbel"
    assert box.reading.wishes[0].style == "marble"
    box._text.value = "nonsense"
    assert box.reading is None
    assert "names no style" in box.trouble
    assert box._chips.value == ""


def test_an_empty_box_waits_and_complains_of_nothing():
    """After «Make yours» an error greeted people who had done nothing yet."""
    box = PromptBox("brick")
    box._text.value = ""
    assert (box.trouble, box.reading) == ("", None)
    assert "Write what it should look like" in box._note.value


def test_clip_takes_any_prompt():
    box = PromptBox("nonsense")
    assert "names no style" in box.trouble
    control(box, "style from").value = "clip"
    assert box.settings["guidance"] == "clip"
    assert box.trouble == ""


def test_a_picture_takes_the_place_of_the_style_and_leaves_the_rest():
    box = PromptBox("small brick")
    box._chips.press("dragon_scales")
    assert box.prompt == "small dragon scales"
    assert box.reading.wishes[0].style == "dragon_scales"
    box._chips.press("wood")
    assert box.prompt == "small wood"


@pytest.mark.parametrize("name", names())
def test_every_picture_asks_for_its_style(name):
    box = PromptBox("brick")
    box._chips.press(name)
    assert box.reading.wishes[0].style == name


# --- picture ------------------------------------------------------------------------------------------------------

SHADES = np.add.outer(np.arange(0, 128, 8), np.arange(0, 128, 8)).astype(np.uint8)


def chosen(content: bytes) -> tuple[dict[str, object], ...]:
    """What a browser sends when a file is chosen."""
    when = datetime(2026, 1, 1, tzinfo=UTC)
    return ({"name": "mine.png", "type": "image/png", "size": len(content), "content": memoryview(content), "last_modified": when},)


def test_a_picture_that_is_chosen_becomes_the_style_and_is_shown():
    box = PromptBox("brick")
    assert box._image._details.layout.display == "none"
    box._image._upload.value = chosen(png_of(SHADES[..., None]))
    assert box.settings["image"] == digest_of(SHADES)
    assert (box.prompt, box.reading.words, box.trouble) == ("picture", "picture", "")
    assert bytes(box._image._shown.value).startswith(b"\x89PNG")
    box._image._way.value, box._image._size.length = "around", 25.0
    assert (box.settings["projection"], box.settings["image_size"]) == ("around", 25.0)
    box._image._remove.click()
    assert (box.settings["image"], box.prompt) == ("", "brick")


def test_a_file_that_is_no_picture_is_said_with_its_name_and_the_one_before_stays():
    box = PromptBox("outside: picture; rim: brick", image=SHADES)
    assert box.prompt == "outside: picture; rim: brick"
    box._image._upload.value = chosen(b"nothing")
    assert "mine.png is no picture that can be read" in box.trouble
    assert box.image == digest_of(SHADES)


def test_a_box_takes_the_picture_of_a_recipe_and_lets_it_go():
    box = PromptBox("brick")
    box.take(recipe(prompt="gold", image=digest_of(SHADES), image_as="height"))
    assert (box.image, box.image_as, box.trouble) == (digest_of(SHADES), "height", "")
    box.take(recipe(prompt="stone"))
    assert (box.image, box.prompt, box.trouble) == ("", "stone", "")


# --- part ---------------------------------------------------------------------------------------------------------


def test_a_gallery_model_shows_its_size():
    picker = PartPicker("gallery:pen_holder")
    assert "pen holder: 80 × 80 × 100 mm" in picker._note.value
    picker._gallery.press("wall_hook")
    assert (picker.model, picker.name) == ("gallery:wall_hook", "wall_hook")
    assert picker._unit.disabled


def test_a_file_in_its_unit(tmp_path, cube):
    path = save(cube, tmp_path / "brick.stl")
    picker = PartPicker(str(path))
    assert picker.mesh.size == pytest.approx(cube.size)
    picker._unit.value = 25.4
    assert picker.scale == 25.4
    assert picker._note.value.count("254 × 254 × 254 mm") == 1
    assert "weld" not in picker._note.value


def test_the_unit_of_the_file_itself_is_named_and_can_be_chosen_again(tmp_path, cube):
    """A menu of ipywidgets takes None for no choice at all, and is empty."""
    picker = PartPicker(str(save(cube, tmp_path / "brick.stl")))
    assert picker._unit.label == "as the file says"
    for index in (2, 0):  # as a browser sends it
        picker._unit.set_state({"index": index})
    assert (picker._unit.label, picker.scale) == ("as the file says", None)
    assert picker.mesh.size == pytest.approx(cube.size)


@pytest.mark.parametrize(("scale", "unit"), [(2.5, None), (25.4, 25.4)])
def test_a_scale_given_by_name_is_kept(tmp_path, cube, scale, unit):
    picker = PartPicker(str(save(cube, tmp_path / "brick.stl")), scale=scale)
    assert (picker.scale, picker._unit.value) == (scale, unit)
    assert np.allclose(picker.mesh.extents, 10.0 * scale)
    picker._path.value = "gallery:wall_hook"
    assert (picker.scale, picker._unit.label, picker.trouble) == (None, "as the file says", "")


def test_a_scale_is_for_files():
    with pytest.raises(BadInput, match="gallery:wall_hook: scale, unit, size, body and an axis for up are for files"):
        PartPicker("gallery:wall_hook", scale=25.4)


def test_a_part_that_cannot_be_used_is_refused_and_the_last_one_stays():
    picker = PartPicker("gallery:pen_holder")
    before = picker.mesh
    picker._path.value = "nowhere.stl"
    assert picker.mesh is before
    assert "nowhere.stl does not exist" in picker.trouble
    with pytest.raises(BadInput, match="does not exist"):
        picker.choose("nowhere.stl")


def test_an_uploaded_file_is_kept_beside_the_runs(tmp_path, monkeypatch, cube):
    monkeypatch.chdir(tmp_path)
    content = save(cube, tmp_path / "mine.stl").read_bytes()
    picker = PartPicker()
    sent = {"name": "../mine.stl", "type": "", "size": len(content), "content": memoryview(content), "last_modified": datetime.now(UTC)}
    picker._upload.value = (sent,)
    assert picker.model == str(tmp_path.joinpath("mechstyle-runs", "uploads", "mine.stl").relative_to(tmp_path))
    assert np.allclose(picker.mesh.extents, 10.0)


def test_a_surface_of_ones_own(sphere):
    picker = PartPicker(sphere, name="ball")
    assert (picker.mesh, picker.model, picker.name) == (sphere, "", "ball")


def test_every_gallery_model_is_offered():
    assert set(PartPicker()._gallery.names) == set(gallery.names())


# --- regions ------------------------------------------------------------------------------------------------------


def test_regions_are_ticked_and_written():
    picker = RegionsPicker()
    picker._inside.value = True
    picker._lines.value = "sphere 0 0 10 5\n"
    assert picker.protect == (Inside(), Sphere((0.0, 0.0, 10.0), 5.0))
    assert "sphere 0 0 10 5" in picker._note.value


def test_regions_set_in_python_are_shown():
    picker = RegionsPicker()
    picker.protect = ["inside", "below 5"]
    assert picker._inside.value
    assert picker._lines.value.startswith("below 5")


def test_a_region_that_cannot_be_read_is_said_and_the_others_stay():
    picker = RegionsPicker("inside")
    picker._lines.value = "sphere 1 2"
    assert picker.protect == (Inside(),)
    assert "write sphere x y z radius" in picker.trouble


def test_a_clicked_piece_is_protected():
    picker = RegionsPicker()
    assert picker._clicked.disabled
    picker.place = (1.0, 2.0, 3.0)
    picker._clicked.click()
    assert picker.protect[0].words == "segment 1 2 3"


def test_clicks_paint_where_the_switch_is_on():
    picker = RegionsPicker("inside")
    picker.click((1.0, 2.0, 3.0))
    assert picker.protect == (Inside(),)
    picker.paint, picker.radius = True, 2.5
    picker.click((1.0, 2.0, 3.0))
    assert picker.protect == (Inside(), Sphere((1.0, 2.0, 3.0), 2.5))
    assert "sphere 1 2 3 2.5" in picker._lines.value
    assert not picker._clicked.disabled


def test_the_folded_regions_say_what_becomes_of_the_underside_or_how_many_there_are():
    briefs = {base: RegionsPicker(base=base).brief for base in BASES}
    assert briefs == {"plain": "underside smooth", "level": "underside level", "free": "underside styled"}
    assert RegionsPicker().brief == "underside smooth"
    assert RegionsPicker(["inside", "below 5"]).brief == "2 places"


# --- drop test ----------------------------------------------------------------------------------------------------


def test_options_go_both_ways():
    options = DropOptions(vertices=2000)
    options.children[0].value = "750"
    assert (options.height, options.settings["height"], options.children[0].value) == (750.0, "75 cm", "75 cm")
    options.orientations = 3
    assert options._drops.value == 3
    assert options.vertices == 2000


def test_the_fall_is_written_with_its_unit_and_what_is_none_is_said_at_the_control():
    options = DropOptions()
    assert options._lengths["height"].value == "1.5 m"
    options._lengths["height"].value = "1,2 m"
    assert (options.height, options._lengths["height"].value, options.brief) == (1200.0, "1.2 m", "1.2 m, as it stands")
    for wrong, said in (("1.5", "a height of 1.5 would be 1.5 mm"), ("5 ft", "not in &#x27;ft&#x27;"), ("200 m", "between 1 mm and 100 m")):
        options._lengths["height"].value = wrong
        assert said in options.trouble
        assert (options.height, options._lengths["height"].value) == (1200.0, wrong)
    options._lengths["height"].value = "4 cm"
    assert (options.trouble, options.height) == ("", 40.0)
    assert draft("brick", **options.settings).test.height == 40.0, "a small one is not asked about again"
    options.take(recipe(height=760.0))
    assert options._lengths["height"].value == "76 cm"


def test_what_may_stay_bent_is_written_in_millimetres_and_what_is_none_is_said_at_the_control():
    options = DropOptions()
    box = options._lengths["tolerance"]
    assert (box.description, box.value) == ("may be off by", "0.2 mm")
    box.value = "350 µm"
    assert (options.tolerance, box.value, draft("brick", **options.settings).test.tolerance) == (0.35, "0.35 mm", 0.35)
    for wrong, said in (("0.2 m", "a tolerance is in mm or µm"), ("none", "as a tolerance"), ("900", "between 0.01 mm and 100 mm")):
        box.value = wrong
        assert said in options.trouble
        assert (options.tolerance, box.value) == (0.35, wrong)
    box.value = "0.5"
    assert (options.trouble, options.tolerance, box.value) == ("", 0.5, "0.5 mm")
    options.take(recipe(tolerance=0.1))
    assert box.value == "0.1 mm"


def test_python_may_set_the_fall_as_people_write_it():
    options = DropOptions(height="80 cm")
    assert options.height == 800.0
    with pytest.raises(BadInput, match="would be 2 mm"):
        options.height = "2"
    assert options.height == 800.0


def test_nearly_flat_landings_are_ticked_and_said():
    options = DropOptions()
    assert "Nearly flat as well" in options._note.value
    control = next(one for one in options.children if getattr(one, "description", "") == "nearly flat")
    control.value = False
    assert options.settings["nearly_flat"] is False
    assert "early flat" not in options._note.value


def test_a_way_to_land_brings_its_usual_number_of_drops():
    options = DropOptions(poses="box26")
    assert (options._way.label, options._drops.layout.display) == ("as it stands", "none")
    options._way.value = "resting"
    assert (options.poses, options.orientations, options._drops.layout.display) == ("resting", 8, None)
    assert "up to 8 drops" in options._note.value
    options._way.value = "fibonacci"
    assert (options.poses, options.orientations) == ("fibonacci", 5)
    options._way.value = ONCE
    assert (options.poses, options.orientations) == ("fibonacci", 1)
    assert "one drop, as the part stands" in options._note.value
    options.orientations = 3
    assert (options.way, options._way.value) == ("fibonacci", "fibonacci")


def test_a_standard_brings_its_landings_and_says_where_it_is_departed_from():
    options = DropOptions()
    options._standard.value = "mil-810h"
    assert (options.standard, options.poses, options.orientations, options.height) == ("mil-810h", "box26", 27, 1220.0)
    assert options._way.value == "box26"
    assert "Simulated orientations after MIL-STD-810H" in options._note.value
    assert "but" not in options._note.value
    options.height = 800.0
    assert "but 80 cm instead of 1.22 m" in options._note.value
    options._standard.value = ""
    assert (options.standard, options.poses, options.height) == ("", "box26", 800.0)
    assert "after" not in options._note.value


def test_a_part_may_be_thickened_first_and_a_run_brings_what_it_asked_for():
    options = DropOptions()
    assert "thickened" not in options._note.value
    control = next(one for one in options.children if getattr(one, "description", "") == "thicken [mm]")
    control.value = 1.5
    assert options.settings["strengthen"] == 1.5
    assert "thickened by up to 1.5 mm before the style" in options._note.value
    options.take(recipe(strengthen=0.5))
    assert control.value == 0.5


LOADS = """
[[case]]
name = "heavy coat"
supports = [{ at = "resting face" }]
loads = [{ gravity = 1 }]
"""


@pytest.fixture
def load_file(tmp_path):
    path = tmp_path / "coat.toml"
    path.write_text(LOADS, encoding="utf-8")
    return str(path)


def test_a_load_file_is_named_and_taken_away_again(load_file):
    options = DropOptions()
    options._file.value = load_file
    assert options.loads == read_loads(load_file)
    assert "it must carry: heavy coat" in options._note.value
    options._unload.click()
    assert (options.loads, options._file.value, options._unload.layout.display) == ((), "", "none")
    options.loads = load_file
    assert options.settings["loads"] == read_loads(load_file)


def test_a_load_file_that_cannot_be_used_is_said_and_the_loads_stay(load_file):
    options = DropOptions()
    options._file.value = load_file
    options._file.value = "nowhere.toml"
    assert "load file nowhere.toml does not exist" in options.trouble
    assert options.loads == read_loads(load_file)
    options._file.value = load_file
    assert options.trouble == ""


def test_loads_of_another_recipe_are_not_those_of_the_file_named_last(load_file):
    options = DropOptions()
    options._file.value = load_file
    options.loads = ()
    assert options._file.value == ""


# --- an answer where one has asked --------------------------------------------------------------------------------


def test_a_refusal_stands_under_the_prompt_with_the_nearest_styles_to_press():
    """It stood eleven controls further down, with 46 names and an option of the command line."""
    box = PromptBox("my saxophone")
    asked, _, trouble, _, chips, *_ = box.children
    assert (asked, chips) == (box._text, box._chips)
    assert "“my saxophone” names no style. Near it are these" in trouble.value
    assert len(trouble.value) < 250
    assert box._chips.few == box._chips.nearest
    assert len(set(box._chips.few)) == 3
    assert set(box._chips.few) <= set(names())
    box._chips.press(box._chips.few[0])
    assert (box.prompt, box.trouble) == (box._chips.value.replace("_", " "), "")
    assert box._chips.nearest == []


def test_a_depth_that_is_written_is_what_the_slider_says():
    box = PromptBox("hexagons, 3 mm deep")
    assert box._relief.label == "3 mm, as written"
    box.prompt = "brick"
    assert box._relief.label == "auto"


@pytest.mark.parametrize("make", [PromptBox, PartPicker])
def test_everything_to_choose_from_is_in_one_group_and_can_be_found(make):
    box = make()
    picker = box._chips if make is PromptBox else box._gallery
    members = [name for group in picker.groups.values() for name in group]
    assert sorted(members) == sorted(picker.names)
    assert "others" not in picker.groups
    assert all(name.replace("_", " ") in picker.found_by[name] for name in picker.names)
