"""Words of the Studio that the page explains."""

import ipywidgets

from mechstyle.records.words import WORDS
from mechstyle_widgets.jupyter.terms import ALSO, PICTURES, terms
from mechstyle_widgets.settings.control import ControlSelector
from mechstyle_widgets.settings.prompt import PromptBox
from mechstyle_widgets.settings.schedule import ScheduleSelector

PLAIN = {"", "style", "is", "gives", "lies", "λ (σ_c / yield)", "iterations", "k", "share of wall"}
"""Labels that say it all, or are told by a note of their own."""


def labels(widget):
    """Descriptions of a control and those in it that stand in front of something to choose."""
    if isinstance(widget, ipywidgets.Dropdown | ipywidgets.FloatLogSlider | ipywidgets.BoundedIntText | ipywidgets.Checkbox):
        yield widget.description
    for child in getattr(widget, "children", ()):
        yield from labels(child)


def test_what_has_a_picture_or_another_name_is_in_the_glossary():
    assert {*PICTURES, *ALSO.values()} <= WORDS.keys()


def test_the_terms_that_need_a_picture_have_one():
    told = terms()
    for word in ("demand", "held back", "restraint", "headroom", "threshold", "schedule", "nearly flat"):
        assert told[word][2].startswith("<svg"), word


def test_what_is_chosen_of_style_restraint_and_schedule_is_explained():
    told = terms()
    for section in (PromptBox(), ControlSelector(), ScheduleSelector()):
        asked = {label.lower().split(":")[0].split("[")[0].strip() for label in labels(section)} - PLAIN
        assert asked <= told.keys()
