"""Every label of the Studio is in the one table, and a Studio in German is German throughout."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import ipywidgets
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.records.landings import STANDARDS
from mechstyle.records.material import LIBRARY
from mechstyle.records.regions import KINDS
from mechstyle.runs.run import Run
from mechstyle_widgets.jupyter import frame
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


ENGLISH = re.compile(r"(?i)\b(the|of|and|is|are|with|what|where|from|this|that|which|your|not|or|by|how|has|have|may|it|to|flat|plain)\b")
"""Words that no German sentence has."""
UNSPOKEN = re.compile(r"<style>.*?</style>|<svg.*?</svg>|<[^>]*>|&[a-z]+;", re.DOTALL)


def sentences_of(studio: Studio) -> set[str]:
    """All that is written in a Studio besides what its controls are called."""
    shown = {one for root in (studio, studio.viewer) for one in family(root) if isinstance(one, ipywidgets.HTML)}
    texts = [text for one in shown for text in UNSPOKEN.split(one.value)]
    texts += [one["text"] for one in studio._timeline._curves.frame.get("annotations", [])]
    return {text.strip() for text in texts if text.strip()}


def walked(studio: Studio) -> set[str]:
    """What is said in the states that people meet."""
    found = sentences_of(studio)

    def see(*_: object) -> None:
        found.update(sentences_of(studio))

    for prompt in ("crocodile skin", "", "brick"):
        studio.prompt_box.prompt = prompt
        see(studio.run_controls._buttons["run"].click() if prompt != "brick" else None)
    for group in studio._groups:
        group.unfolded = True
        see()
        group.unfolded = False
    studio.drop_options.poses, studio.drop_options.orientations, studio.drop_options.strengthen = "box26", 9, 0.4
    studio.viewer._clicks(tuple(studio.viewer.at_rest.vertices[0].tolist()))
    studio.viewer.probed, studio.viewer.tool = 0, "measure"
    see()
    return found


def test_what_is_said_is_in_the_table(done, tmp_path):
    """Sentences of the core and of the Studio: a teacher in Germany read half of each."""
    done = Run.open(shutil.copytree(done.store.root, tmp_path / "copy"))  # a branch is made, and other tests count those of the first
    first, made = Studio("gallery:wall_hook", language="de"), Studio(done, language="de")
    found = walked(first) | walked(made)
    for layer in made.viewer.subject.layers:
        made.state.layer = layer.name
        made.state.iteration = 12
        found |= sentences_of(made)
    made.state.pinned = ("main", 4)
    made.mask_inspector._slider.value = 0.2
    made.mask_inspector.use()
    made.branches.branch()
    found |= sentences_of(made)
    strange = {text for text in found if ENGLISH.search(text) and text not in NAMES and not plain(text) and "import mechstyle" not in text}
    assert {text for text in strange if not text.startswith("/")} == set()


def test_what_the_page_says_by_itself_is_in_the_table():
    script = Path(frame.__file__).with_name("static").joinpath("frame.js").read_text(encoding="utf-8")
    keys = re.search(r"const KEYS = \{.*?\n\};", script, re.DOTALL).group()
    words = {one for one in re.findall(r'"([^"]+)"', keys) if len(one) > 3 or " " in one}
    assert {one for one in words if one not in GERMAN} <= {"C, N", "Z, Y", "X, O, M, A, P", "Enter", "Escape"}
    speak("de")
    assert frame.Frame().words["this list"] == "diese Liste"


def test_what_is_chosen_is_the_same_in_every_language():
    recipes = [Studio("gallery:wall_hook", language=language).wanted().recipe for language in LANGUAGES]
    assert recipes[0] == recipes[1]


def test_there_is_an_entry_for_every_language_and_no_other_language():
    assert all(GERMAN.values())
    assert all(english.count("{}") == len(re.findall(r"\{\d?\}", german)) for english, german in GERMAN.items())
    with pytest.raises(BadInput, match="unknown language 'fr'"):
        speak("fr")
    assert word("nobody's name") == "nobody's name"
