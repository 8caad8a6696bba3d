"""Material, prompt, part, regions, drop test: mouse and Python set the same, and what is wrong is said in one sentence."""

from datetime import UTC, datetime

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.geometry.files import save
from mechstyle.records.load_cases import read_loads
from mechstyle.records.material import LIBRARY
from mechstyle.records.regions import Inside, Sphere
from mechstyle.runs.images import digest_of
from mechstyle.runs.recipes import recipe_for
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


def test_a_material_of_the_library():
    picker = MaterialPicker("petg")
    assert picker.material == LIBRARY["PETG"]
    picker._choice.value = "ABS"
    assert picker.material == LIBRARY["ABS"]
    assert picker._figures["yield_strength"].value == 33.0
    assert "Stratasys" in picker._note.value


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


def control(box, description):
    """The control of a section that is described so."""
    return next(one for one in family(box) if getattr(one, "description", "") == description)


OTHERS = [("side", "goes", "outwards"), ("inside", "inside", "styled"), ("feature", "size", 5.0)]


@pytest.mark.parametrize(("trait", "described", "value"), OTHERS)
def test_what_else_the_style_section_sets_reaches_the_recipe(trait, described, value):
    box = PromptBox("brick")
    control(box, described).value = value
    assert box.settings[trait] == value


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


def test_a_file_in_its_unit(tmp_path, cube):
    path = save(cube, tmp_path / "brick.stl")
    picker = PartPicker(str(path))
    assert picker.mesh.size == pytest.approx(cube.size)
    picker._unit.value = 25.4
    assert picker.scale == 25.4
    assert picker._note.value.count("254 × 254 × 254 mm") == 1
    assert "weld" not in picker._note.value


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


def test_regions_are_ticked_and_written():
    picker = RegionsPicker()
    picker._inside.value = True
    picker._lines.value = "sphere 0 0 10 5\n"
    assert picker.protect == (Inside(), Sphere((0.0, 0.0, 10.0), 5.0))
    assert "sphere 0 0 10 5" in picker._note.value


def test_a_region_that_cannot_be_read_is_said_and_the_others_stay():
    picker = RegionsPicker("inside")
    picker._lines.value = "sphere 1 2"
    assert picker.protect == (Inside(),)
    assert "write sphere x y z radius" in picker.trouble


def test_clicks_paint_where_the_switch_is_on():
    picker = RegionsPicker("inside")
    picker.click((1.0, 2.0, 3.0))
    assert picker.protect == (Inside(),)
    picker.paint, picker.radius = True, 2.5
    picker.click((1.0, 2.0, 3.0))
    assert picker.protect == (Inside(), Sphere((1.0, 2.0, 3.0), 2.5))
    assert "sphere 1 2 3 2.5" in picker._lines.value
    assert not picker._clicked.disabled


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
    assert recipe_for("brick", **options.settings).test.height == 40.0, "a small one is not asked about again"
    options.take(recipe(height=760.0))
    assert options._lengths["height"].value == "76 cm"


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
