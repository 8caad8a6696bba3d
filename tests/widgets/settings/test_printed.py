"""The group "How it is printed": three presets, and every figure."""

from mechstyle.records.recipe import DEFAULTS, settings_of
from mechstyle_widgets.settings.printed import OWN, PRESETS, PrintedPicker


def test_it_begins_solid_and_has_every_setting_of_the_chapter():
    picker = PrintedPicker()
    assert picker.settings == {name: DEFAULTS[name] for name in settings_of("printed")}
    assert picker.brief == picker._preset.value == "solid"
    assert picker._figures.layout.display == "none"


def test_a_preset_brings_its_figures_and_they_name_the_preset():
    picker = PrintedPicker()
    for name, figures in PRESETS.items():
        picker._preset.value = name
        assert {field: getattr(picker, field) for field in figures} == dict(figures)
        assert picker._preset.value == picker.chosen == name
    assert picker.brief == "4 walls, 30 % infill"
    assert picker._figures.layout.display is None
    picker.walls = 5
    assert picker._preset.value == OWN
    assert picker.brief == "5 walls, 30 % infill"


def test_a_print_of_ones_own_is_offered_where_it_is_one():
    """Chosen of a preset, it did nothing: the menu went back to the preset."""
    picker = PrintedPicker()
    assert picker._preset.options == tuple((name, name) for name in PRESETS)
    picker.infill = 0.2
    assert picker._preset.options[-1] == (OWN, OWN)
    picker.infill = 1.0
    assert (picker._preset.value, len(picker._preset.options)) == ("solid", len(PRESETS))
