"""Every label of the Studio is in the one table, and a Studio in German is German throughout."""

from __future__ import annotations

import re

import ipywidgets
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.records.landings import STANDARDS
from mechstyle.records.material import LIBRARY
from mechstyle.records.regions import KINDS
from mechstyle_widgets.jupyter.closing import family
from mechstyle_widgets.jupyter.language import GERMAN, LANGUAGES, speak, word
from mechstyle_widgets.settings.thumbnail_buttons import PictureChoice
from mechstyle_widgets.studio import Studio

NAMES = {
    "MechStyle", "Freestyle", "auto", "cpu", "cuda", "x", "y", "z", "standard", "prusa", "bambu", "orca", "mechstyle-runs/…", "\u200b",
    "\n".join(KINDS.values()), *LIBRARY, *(standard.title for standard in STANDARDS.values()),
}  # fmt: skip
"""Names of things, which are the same in every language."""
FIGURES = re.compile(r"[\d.×]+( mm)?|× \d+|(flat|tilted)( .*)?")
MADE = ("Material: ", "When to test: ", "Holding back: ", "Keep plain: ", "Drop test: ", "● ", "○ ")
"""How labels begin that are made of a heading and of what is chosen, or of a mark and a lane."""


@pytest.fixture(autouse=True)
def in_english_again(monkeypatch):
    monkeypatch.setattr("mechstyle_widgets.panels.mask_inspector._freedom", lambda run, _recipe: np.ones_like(run.part.thickness))
    yield
    speak("en")


def labels(studio: Studio) -> set[str]:
    """All that the controls of a Studio are called."""
    viewer = studio.viewer
    player = getattr(viewer, "player", None)
    hidden = () if player is None else (player._start, player._moments, player._progress)
    found: set[str] = set()
    for control in {one for root in (studio, viewer, *hidden) for one in family(root)}:
        for name in ("description", "tooltip", "placeholder"):
            found.add(getattr(control, name, "") or "")
        found |= {*getattr(control, "tooltips", ()), *(getattr(control, "titles", ()) if isinstance(control, ipywidgets.Tab) else ())}
        found |= {*map(str, getattr(control, "_options_labels", ()))}
        if isinstance(control, PictureChoice):
            found |= {*control.groups, *control.words.values(), *(name["title"] for name in control.names.values())}
    return found - {""}


def plain(label: str) -> bool:
    """Whether a label is a name, a figure, or made of others."""
    return label in NAMES or FIGURES.fullmatch(label) is not None or label.startswith(MADE)


def entry(label: str, table: set[str]) -> bool:
    """Whether a label is in a table, with what it is made for in the place of `{}`."""
    return any(re.fullmatch(re.escape(one).replace(r"\{\}", ".*") + "(: .*, iteration \\d+)?", label) for one in table)


def test_every_label_is_in_the_table(done):
    table = {*GERMAN}
    missing = {label for studio in (Studio("gallery:wall_hook"), Studio(done)) for label in labels(studio) if not plain(label)}
    assert {label for label in missing if not entry(label, table)} == set()


def test_a_german_studio_says_nothing_in_english(done):
    english = {one for one, german in GERMAN.items() if german != one}
    also_german = {*GERMAN.values()}
    said = labels(Studio("gallery:wall_hook", language="de")) | labels(Studio(done, language="de"))
    assert {label for label in said if label in english and label not in also_german} == set()
    assert {"Start", "Beide", "Ausprobieren", "Tiefe", "Wandhaken", "Ziegel"} <= said


def test_what_is_chosen_is_the_same_in_every_language():
    recipes = [Studio("gallery:wall_hook", language=language).wanted().recipe for language in LANGUAGES]
    assert recipes[0] == recipes[1]


def test_there_is_an_entry_for_every_language_and_no_other_language():
    assert all(GERMAN.values())
    assert all(english.count("{}") == german.count("{}") for english, german in GERMAN.items())
    with pytest.raises(BadInput, match="unknown language 'fr'"):
        speak("fr")
    assert word("nobody's name") == "nobody's name"
