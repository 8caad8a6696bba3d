"""Every label of the Studio is in the one table, and a Studio in German is German throughout."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import ipywidgets
import numpy as np
import pytest
import trimesh

from mechstyle.errors import BadInput
from mechstyle.records import Doubt, sentences
from mechstyle.runs.recipes import recipe_for
from mechstyle.runs.run import Run
from mechstyle.runs.stylizers import finished_style
from mechstyle.simulation import foresight
from mechstyle.simulation.part import Shape
from mechstyle_widgets import jupyter
from mechstyle_widgets.jupyter import frame
from mechstyle_widgets.jupyter.language import GERMAN, LANGUAGES, said, speak, word
from mechstyle_widgets.jupyter.looks import family
from mechstyle_widgets.jupyter.terms import terms
from mechstyle_widgets.panels.branches import most_bent, side_by_side
from mechstyle_widgets.panels.result import carried
from mechstyle_widgets.settings.thumbnail_buttons import PictureChoice
from mechstyle_widgets.state.studio_state import FREE
from mechstyle_widgets.studio import Studio
from mechstyle_widgets.timeline.timeline import Curves
from mechstyle_widgets.viewer.badge import in_full
from support import ROOT
from support.german import MARKUP, english_in, plain
from support.records import load_row, published_row, row, verdict


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


ENTRY = re.compile("(?:" + "|".join(re.escape(one).replace(r"\{\}", ".*") for one in GERMAN) + r")(: .*, iteration \d+| · [\d.]+ mm)?")
"""A label of the table, with what it is made for in the place of `{}`; one of a landing is followed by what stays bent."""


def test_every_label_is_in_the_table(done):
    missing = {label for studio in (Studio("gallery:wall_hook"), Studio(done)) for label in labels(studio) if not plain(label)}
    assert {label for label in missing if not ENTRY.fullmatch(label)} == set()


def test_a_german_studio_says_nothing_in_english(done):
    english = {one for one, german in GERMAN.items() if german != one}
    also_german = {*GERMAN.values()}
    shown = labels(Studio("gallery:wall_hook", language="de")) | labels(Studio(done, language="de"))
    assert {label for label in shown if label in english and label not in also_german} == set()
    assert {label: found for label in shown if (found := english_in(label))} == {}
    assert {"Start", "Beide", "Ausprobieren", "Tiefe", "Wandhaken", "Ziegel"} <= shown


UNSEEN = re.compile(r"<style>.*?</style>", re.DOTALL)
TELLING = re.compile(r'\b(?:aria-label|title|alt)="([^"]*)"')
"""What screen readers tell, and what stands under the mouse."""
IN_FIGURES = ("text", "hovertext", "hovertemplate", "name", "ticktext")


def sentences_of(studio: Studio) -> set[str]:
    """All that is written in a Studio besides what its controls are called, drawings and curves among it, and what screen readers tell."""
    shown = {one for root in (studio, studio.viewer) for one in family(root)}
    written = [UNSEEN.sub("", one.value) for one in shown if isinstance(one, ipywidgets.HTML | ipywidgets.Label)]
    written += [text for one in shown if isinstance(one, Curves) for text in in_a_figure([one.data, one.frame])]
    texts = [text for one in written for text in (*TELLING.findall(one), *MARKUP.split(one))]
    return {text.strip() for text in texts if text.strip()}


def in_a_figure(part: object, name: str = "") -> Iterator[str]:
    """Texts of what plotly draws."""
    if isinstance(part, str) and name in IN_FIGURES:
        yield part
    elif isinstance(part, list | tuple):
        for one in part:
            yield from in_a_figure(one, name)
    elif isinstance(part, dict):
        for key, one in part.items():
            yield from in_a_figure(one, key)


def walked(studio: Studio) -> set[str]:
    """What is said in the states that people meet."""
    found = sentences_of(studio)

    def see(*_: object) -> None:
        found.update(sentences_of(studio))

    for prompt in ("Quatsch", "", "brick"):
        studio.prompt_box.prompt = prompt
        see(studio.run_controls._buttons["run"].click() if prompt != "brick" else None)
    for group in studio._groups:
        group.unfolded = True
        see()
        group.unfolded = False
    studio.drop_options.poses, studio.drop_options.orientations, studio.drop_options.strengthen = "box26", 9, 0.4
    studio.viewer._clicks(tuple(studio.viewer.undeformed.vertices[0].tolist()))
    studio.viewer.probed, studio.viewer.tool = 0, "measure"
    see()
    return found


def test_what_a_pattern_is_made_of_has_a_german_word():
    """Of bricks that are drawn larger than asked a German read "Mortar joints werden 1.9 × größer gezeichnet"."""
    source = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "mechstyle" / "styling").rglob("*.py"))
    made_of = set(re.findall(r'canvas\.unit\("([^"]+)"', source))
    assert len(made_of) > 50
    assert {one for one in made_of if f"{one} of {{}}" not in GERMAN} == set()


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
    found |= sentences_of(made) | {said(reason) for reason in REASONS}
    strange = {text: english for text in found if (english := english_in(text))}
    assert strange == {}


REASONS = (
    "every 4 iterations", "quadratic step 3² = 9", "exponential step 2^3 = 8", "late check after 80% of the iterations", "last iteration",
    "the relief has moved 0.31 mm on a wall of 2.4 mm: more than 10.0% of it",
    "correction: relief lowered around 12 places that yield", "correction: cuts filled around 12 places that yield",
    "correction: 50% of the whole relief", "correction: the relief removed", "correction: half of the removed relief put back",
    "correction: all of the held-back relief put back",
)  # fmt: skip
"""Why a part is tested, in all that schedules and corrections say."""


def of_a_box(**changes):
    """The bytes of an STL of a box, changed in some way."""
    mesh = trimesh.creation.box((40.0, 30.0, changes.get("height", 20.0)))
    mesh.update_faces(np.arange(len(mesh.faces)) >= changes.get("missing", 0))
    mesh.apply_scale(changes.get("scale", 1.0))
    return mesh.export(file_type="stl")


FILES = {
    "leer.stl": b"", "wort.stl": b"hello", "wort.txt": b"x", "kaputt.obj": b"v 0 0 0\nf 1 2 9\n",
    "offen.stl": of_a_box(missing=4), "riese.stl": of_a_box(scale=1000.0), "meter.stl": of_a_box(scale=0.001),
    "platte.stl": of_a_box(height=0.05), "punkt.stl": of_a_box(scale=0.0),
}  # fmt: skip
"""Files that nothing can be made of, each for another reason."""
LINES = ("box 1 2", "nonsense 3", "rims", "box 900 900 900 910 910 910", "holes x")
"""Regions that cannot be read, or hold nothing."""


def test_what_is_wrong_with_a_file_or_a_region_of_ones_own_is_said_in_german(monkeypatch, tmp_path):
    """All of it was English, in a Studio that was German otherwise."""
    speak("de")
    (tmp_path / "teile").mkdir()
    monkeypatch.chdir(tmp_path)
    studio, complaints = Studio("gallery:pen_holder"), []
    for name, content in FILES.items():
        Path(name).write_bytes(content)
    for path in (*FILES, "nowhere.stl", "teile", "gallery:nothere"):
        studio.part_picker._path.value = path
        complaints.append(studio.part_picker._trouble.value)
    for line in LINES:
        studio.regions_picker._lines.value = line
        complaints.append(studio.regions_picker._trouble.value)
    assert all(complaints)
    texts = [MARKUP.sub(" ", one).replace(str(tmp_path), "").replace("--unit", "").strip() for one in complaints]
    assert {text: found for text in texts if (found := english_in(text))} == {}


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"quick": True}, "das Studio hat keine Einstellung 'quick': verlange stattdessen weniger Ecken, zum Beispiel vertices=4000"),
        ({"schedule": "sometimes"}, "schedule muss eines von"), ({"relief": -1.0}, "relief ist -1, muss aber zwischen 0 und 20 liegen"),
        ({"part": "nowhere.stl"}, "nowhere.stl gibt es in "), ({"materiel": "PLA"}, "'materiel': meintest du 'material'?"),
    ],
)  # fmt: skip
def test_what_a_studio_cannot_be_asked_for_is_said_in_its_language(wrong, told):
    with pytest.raises(BadInput, match=re.escape(told)):
        Studio(**{"part": "gallery:pen_holder", "language": "de", **wrong})


TESTED = (
    row(0.06), row(0.0, place=""), row(0.61, plastic_strain=0.07, cracks=True),
    row(0.1, plastic_strain=0.07, cracks=True, outcome="FAILS"),
    row(0.33, plain_permanent_set=0.3, allowed=0.35, outcome="NO WORSE"),
    row(0.61, test="nearly flat", landing="tilted 3° onto the right front corner", place="high up on the right"),
    load_row(), load_row(0.61),
    row(0.12, place="low at the front left", plain_permanent_set=None, plain_plastic_strain=None),
    load_row(0.0, outcome="FAILS", collapses=True, carries=0.4, place="halfway up"), published_row(), published_row(30.0),
)  # fmt: skip
"""A row of each kind that a verdict may have."""


def test_every_verdict_is_said_in_german():
    doubts = (
        (Doubt(about="limit", value=0.99, test="flat", landing="flat"), Doubt(about="relief", value=0.4)),
        tuple(Doubt(about="limit", value=0.99, test="nearly flat", landing=f"tilted 3° to the {side}") for side in ("right", "left back")),
        (Doubt(about="limit", value=0.99, test="load", load="coat"), Doubt(about="volume", value=0.05)),
        (Doubt(about="landings", value=6.0, of=9),),
    )
    found = [*map(verdict, TESTED), verdict(row(0.06), load_row()), verdict(measure=0)]
    found += [verdict(row(0.19), doubts=one) for one in doubts]
    told = [verdict.short for verdict in found] + [sentences.least(verdict) for verdict in found]
    told += [line for verdict in found for line in in_full(verdict).split("\n")] + [carried(row) for row in TESTED]
    told += [most_bent("soft", verdict, {"main": "0.06 mm", "soft": "0.12 mm"}) for verdict in found if verdict.rows]
    told += [side_by_side(("Freestyle", "MechStyle"), (one, found[0]), (1.0, kept)) for one in found for kept in (0.5, 0.95)]
    speak("de")
    texts = {said(one).replace("brick", "Ziegel").replace("coat", "Mantel") for one in told}
    assert {text: english for text in texts if (english := english_in(text))} == {}
    assert said(found[0].head) == (
        "HÄLT einen Fall aus 1.5 m: schlimmstenfalls 0.06 mm bleibt verbogen, ganz oben, flach gelandet (glattes Teil 0 mm). Massives PLA."
    )


def test_terms_explain_themselves_in_german():
    """Nothing stood under the mouse: it was looked for by what a term is called in English."""
    spoken = terms()
    speak("de")
    german = terms()
    assert german.keys() >= {"tiefe", "toleranz", "spannung", "schritt", "ausnutzung"}
    texts = {key: f"{name}: {sentence} {MARKUP.sub(' ', picture)}" for key, (name, sentence, picture) in german.items()}
    assert {key: found for key, text in texts.items() if (found := english_in(text))} == {}
    assert len(german) > 0.9 * len(spoken)


def test_what_scripts_of_the_page_say_is_in_the_table():
    """The slider said "12 of 12" in a Studio in German."""
    scripts = [path.read_text(encoding="utf-8") for path in Path(jupyter.__file__).parents[1].rglob("*.js")]
    found = {one for text in scripts for one in re.findall(r'\b(?:say|speaking\(model\))\("([^"]+)"', text)}
    assert found >= {"What the keys do", "slider"}
    assert {one for one in found if one not in GERMAN} == set()


def test_what_the_page_says_by_itself_is_in_the_table():
    script = Path(frame.__file__).with_name("static").joinpath("frame.js").read_text(encoding="utf-8")
    keys = re.search(r"const KEYS = \{.*?\n\};", script, re.DOTALL).group()
    words = {one for one in re.findall(r'"([^"]+)"', keys) if len(one) > 3 or " " in one}
    assert {one for one in words if one not in GERMAN} <= {"C, N", "Z, Y", "X, O, M, A, P", "Enter", "Escape"}
    speak("de")
    assert frame.Frame().said["this list"] == "diese Liste"


def test_what_is_chosen_is_the_same_in_every_language():
    recipes = [Studio("gallery:wall_hook", language=language).wanted().recipe for language in LANGUAGES]
    assert recipes[0] == recipes[1]


def test_there_is_an_entry_for_every_language_and_no_other_language():
    assert all(GERMAN.values())
    assert all(english.count("{}") == len(re.findall(r"\{\d?\}", german)) for english, german in GERMAN.items())
    with pytest.raises(BadInput, match="unknown language 'fr'"):
        speak("fr")
    assert word("nobody's name") == "nobody's name"


def test_what_is_known_of_a_drawing_is_german_too(cube):
    """A note names the finest feature of a style, of which there are as many as styles."""
    shape = Shape(cube, np.full(len(cube.vertices), 1.0, np.float32))
    drawn = [finished_style(shape, recipe_for(prompt, relief=relief)) for prompt in ("tiny brick", "knit") for relief in (None, 4.0)]
    notes = {note for style in drawn for note in style.notes}
    assert len(notes) > 2
    speak("de")
    assert {note: found for note in notes if (found := english_in(said(note)))} == {}


def test_two_studios_of_one_kernel_each_speak_their_own_language(done):
    """All spoke the language of the last: what the first said from then on was of another than its labels."""
    german, english = Studio(done, language="de"), Studio(done, language="en")
    found = {}
    for studio in (german, english):
        studio.prompt_box.prompt = "Quatsch"
        click(studio.run_controls._buttons["run"])
        studio.state.layer, studio.state.iteration, studio.state.pinned = "stays_bent", 4, ("main", 12)
        studio.mask_inspector._slider.value = 0.2
        studio.prompt_box.prompt = "stone"
        studio.drop_options.orientations = 9
        for group in studio._groups:
            group.unfolded = True
        found[studio] = labels(studio) | sentences_of(studio)
    assert {text: wrong for text in found[german] if (wrong := english_in(text))} == {}
    only_german = set(GERMAN.values()) - set(GERMAN)
    assert found[english] & only_german == set()
    assert len(found[german] & only_german) > 50


def test_what_helps_and_what_would_not_is_german(monkeypatch):
    monkeypatch.setattr(foresight, "OUT_OF_REACH", 0.5)  # one of the two is out of reach
    studio = Studio(language="de")
    studio.state.branches, studio.state.lane = [one for one in studio.state.branches if one.lane == FREE], FREE
    words, *buttons, useless = studio.next_steps.children
    assert (len(buttons), len(studio.next_steps.useless)) == (2, 1)
    shown = {words.value, useless.value.removeprefix("<div>").removesuffix("</div>"), *(one.description for one in buttons)}
    assert {text: wrong for text in shown if (wrong := english_in(text))} == {}


def click(button: ipywidgets.Button) -> None:
    """What a page says when a button is pressed."""
    button._handle_msg({"content": {"data": {"method": "custom", "content": {"event": "click"}}}})
