"""Mistakes that people made: each gets one sentence that says what is wrong and what to do, before anything slow begins."""

from pathlib import Path
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

import mechstyle as ms
from mechstyle import gallery
from mechstyle._files import exclusive
from mechstyle.cli import inspect_run
from mechstyle.cli.app import app
from mechstyle.errors import BadInput
from mechstyle.runs.run import Draft, Run
from mechstyle.simulation import part_test
from mechstyle.simulation.part import standardised
from support.lanes import lane_on_a_sheet

OF_A_RUN = ("log", "show", "export", "report", "film", "orient", "rerun", "gc")


def box():
    return gallery.load("gallery:drawer_knob")


def refused(*words):
    done = CliRunner().invoke(app, [str(word) for word in words], env={"COLUMNS": "240", "NO_COLOR": "1"})
    assert done.exit_code == 2
    return done.stderr


@pytest.fixture(autouse=True)
def _nothing_slow(monkeypatch):
    """A mistake that is found only after the part was made ready is found too late."""

    def late(*_args, **_settings):
        pytest.fail("the part was made ready before the mistake was found")

    monkeypatch.setattr(Draft, "_prepared", late)
    monkeypatch.setattr(part_test, "_prepared", late)


@pytest.fixture
def lane(tmp_path, monkeypatch):
    """A finished run in the folder `runs/lane` of where one works."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "parts").mkdir()
    lane_on_a_sheet(tmp_path / "runs" / "lane", iterations=10)
    return Run.open("runs/lane", "cpu")


def carried_on(_):
    """The command that carries on a run which another process is at."""
    with exclusive(Path("runs/lane/locks/main.lock"), "lane 'main'"):
        return refused(*STYLED, "--out", "runs/lane")


STYLED = ("run", "gallery:drawer_knob", "-p", "brick")
FOLDER = "parts is a folder, not a file; name the mesh file itself"
MISTAKES = [
    ("1 a folder as a part", ("run", "parts", "-p", "brick"), FOLDER),
    ("1 a folder to drop", ("simulate", "parts"), FOLDER),
    ("1 a folder to look at", ("protect", "parts", "--protect", "rim"), FOLDER),
    ("1 a folder in the Studio", ("studio", "parts"), "parts is not a run directory: it holds no lanes/*.json; give the folder that"),
    ("1 a run that is not there", ("run", "runs/none", "-p", "brick"), "runs/none does not exist in {here}; check the path"),
    ("1 no run for the Studio", ("studio", "demo-out/mechstyle"), "demo-out/mechstyle does not exist in {here}; check the path"),
    *((f"1 no run to {verb}", (verb, "runs/none"), "runs/none does not exist in {here}; check the path") for verb in OF_A_RUN),
    ("1 no load file", ("simulate", "gallery:drawer_knob", "--load", "coat.toml"), "load file coat.toml does not exist in {here}; check"),
    ("1 no picture", ("run", "gallery:drawer_knob", "--image", "cat.png"), "the picture cat.png does not exist in {here}; check the path"),
    ("2 a list as a prompt", lambda _: ms.stylize(box(), ["brick"]), "a prompt is text, such as 'brick', not a list"),
    ("2 no prompt", ("run", "gallery:drawer_knob", "-p", ""), "the prompt is empty: say in words what the part is to look like"),
    ("3 a number as a part", lambda _: ms.load(5), "a part is the path of a file or gallery:NAME, not 5"),
    ("4 a material in small letters", lambda _: ms.LIBRARY["pla"], "unknown material 'pla': did you mean 'PLA'?"),
    ("5 load in Python", lambda _: ms.simulate(box(), load="coat.toml"), "unknown setting 'load': did you mean 'loads'?"),
    ("5 load as a setting", (*STYLED, "--set", "load=coat.toml"), "unknown setting 'load': did you mean 'loads'?"),
    ("5 --loads", ("simulate", "gallery:drawer_knob", "--loads", "coat.toml"), "No such option: --loads (Possible options: --body, --load"),
    ("6 misspelt in Python", lambda _: ms.stylize(box(), "brick", vertcies=2000), "unknown setting 'vertcies': did you mean 'vertices'"),
    ("6 misspelt", (*STYLED, "--vertcies", "2000"), "No such option: --vertcies (Possible options: --details, --iterations, --vertices)"),
    ("6 an option as a setting", (*STYLED, "--set", "vertcies=2000"), "--set vertcies: no setting of the recipe, but an option"),
    ("7 a word for a number", (*STYLED, "--vertices", "many"), "'--vertices': give a whole number, such as 40"),
    ("7 a word for a length", (*STYLED, "--minimum-wall", "thick"), "'--minimum-wall': give a number, such as 1.5"),
    ("7 too few", (*STYLED, "--vertices", "10"), "vertices is 10, but must be a whole number between"),
    ("7 too many", ("simulate", "gallery:drawer_knob", "--vertices", "999999999"), "vertices is 999999999, but must be a whole"),
    ("7 too many in Python", lambda _: standardised(box(), 10**9), "vertices is 1000000000, but must be a whole number between"),
    ("8 a layer as an iteration", lambda run: run.show("stress"), "'stress' is no iteration, which is a whole number; what is to be"),
    ("8 a layer that is not there", ("show", "runs/lane", "--field", "stres"), "unknown field 'stres': did you mean 'stress'"),
    ("9 numbers as a place", lambda _: ms.Support(at=(1, 2)), "a place is ms.Sphere, ms.Box, ms.HalfSpace or 'resting face', not (1, 2)"),
    ("11 a run that is carried on", carried_on, "is being carried on by process"),
    ("11 other settings", (*STYLED, "--out", "runs/lane"), "runs/lane holds a run with other settings: choose another --out, or branch it"),
    ("11 a folder of something else", (*STYLED, "--out", "."), ". exists and is not a run directory: choose another --out"),
    ("12 a standard", (*STYLED, "--standard", "mil"), "did you mean 'mil-810h'? known are mil-810h, astm-f963, astm-f963-96,"),
    ("13 a model", ("run", "gallery:pen_hodler", "-p", "brick"), "unknown gallery model 'pen_hodler': did you mean 'pen_holder'"),
    ("13 a model like none", ("run", "gallery:cup", "-p", "brick"), "unknown gallery model 'cup': `mechstyle gallery` lists what is known"),
    ("13 a region", (*STYLED, "--protect", "rmi"), "unknown region to protect 'rmi': did you mean 'rim' or 'right'?"),
    ("13 a region like none", (*STYLED, "--protect", "qqq"), "unknown region to protect 'qqq': `mechstyle protect --help` lists"),
    ("13 a setting like none", (*STYLED, "--set", "qqq=1"), "unknown setting 'qqq': docs/settings.md lists what is known"),
]  # fmt: skip
"""Those of a review with its numbers, and more of their kinds: as they are typed, and what is said."""


@pytest.mark.parametrize(("mistake", "said"), [one[1:] for one in MISTAKES], ids=[one[0] for one in MISTAKES])
def test_a_mistake_is_said_in_a_sentence_before_anything_slow(mistake, said, lane, tmp_path):
    said = said.format(here=tmp_path)
    if isinstance(mistake, tuple):
        line = next(line for line in refused(*mistake).splitlines() if said in line)
        assert len(line.strip("│ ")) < 200 + len(str(tmp_path))
        return
    try:
        answer = mistake(lane)
    except BadInput as refusal:
        answer = str(refusal)
    assert said in answer


def test_a_setting_that_does_nothing_is_said_in_python_too(caplog, monkeypatch):
    begun = SimpleNamespace(begin=lambda: SimpleNamespace(go=lambda _: None))
    monkeypatch.setattr(Draft, "ready", lambda *_args, **_settings: begun)
    ms.stylize(box(), "brick", travel=0.2)
    assert "travel does nothing without the schedule geometry or stress" in caplog.text


def test_a_second_export_says_what_it_replaces(lane, monkeypatch):
    monkeypatch.setattr(Run, "exported", lambda _run, place, *_args, **_settings: place.write_text("solid"))
    monkeypatch.setattr(inspect_run, "report_export", lambda *_: None)
    first, again = (CliRunner().invoke(app, ["export", "runs/lane", "-f", "stl"]) for _ in range(2))
    assert (first.exit_code, again.exit_code) == (0, 0)
    assert "replaced" not in first.stderr
    assert "was there and is replaced; --out writes to another file" in " ".join(again.stderr.split())


def test_who_stops_before_anything_was_saved_learns_it(monkeypatch, tmp_path):
    def interrupted(*_args, **_settings):
        raise KeyboardInterrupt

    monkeypatch.setattr(Draft, "_prepared", interrupted)
    done = CliRunner().invoke(app, ["run", "gallery:drawer_knob", "-p", "brick", "--out", str(tmp_path / "part")])
    assert done.exit_code == 130
    assert "interrupted; nothing was saved" in done.stderr
