"""Mistakes that people made: each gets one sentence that says what is wrong and what to do, before anything slow begins."""

from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

import mechstyle as ms
from mechstyle import gallery
from mechstyle._files import exclusive
from mechstyle.cli import inspect_run
from mechstyle.cli.app import app
from mechstyle.errors import BadInput
from mechstyle.runs import run as runs
from mechstyle.runs.run import Run
from mechstyle.simulation import part_test
from support.lanes import lane_on_a_sheet


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

    monkeypatch.setattr(runs, "made_ready", late)
    monkeypatch.setattr(part_test, "_prepared", late)


MISTAKES = [
    (lambda: ms.stylize(box(), ["brick"]), "a prompt is text, such as 'brick', not a list"),
    (lambda: ms.load(5), "a part is the path of a file or gallery:NAME, not 5"),
    (lambda: ms.LIBRARY["pla"], "unknown material 'pla': did you mean 'PLA'?"),
    (lambda: ms.simulate(box(), load="coat.toml"), "unknown setting 'load': did you mean 'loads'?"),
    (lambda: ms.stylize(box(), "brick", vertcies=2000), "unknown setting 'vertcies': did you mean 'vertices'"),
    (lambda: ms.Support(at=(1, 2)), "a place is ms.Sphere, ms.Box, ms.HalfSpace or 'resting face', not (1, 2)"),
]


@pytest.mark.parametrize(("mistake", "said"), MISTAKES, ids=[said[:30] for _, said in MISTAKES])
def test_a_mistake_in_python_is_said_in_a_sentence(mistake, said):
    with pytest.raises(BadInput) as refusal:
        mistake()
    assert str(refusal.value).startswith(said)


@pytest.mark.parametrize("arguments", [("run", "-p", "brick"), ("simulate",), ("protect", "--protect", "rim")])
def test_a_path_that_is_no_file_is_named_with_the_folder_it_was_looked_for_in(arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "parts").mkdir()
    assert "parts is a folder, not a file; name the mesh file itself" in refused(*arguments, "parts")
    assert f"runs/none does not exist in {tmp_path}; check the path" in " ".join(refused(*arguments, "runs/none").split())


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--vertices", "many"), "give a whole number, such as 40"),
        (("--minimum-wall", "thick"), "give a number, such as 1.5"),
        (("--standard", "mil"), "did you mean 'mil-810h'? known are mil-810h, astm-f963, astm-f963-96,"),
    ],
)
def test_a_word_where_a_number_or_a_name_must_stand(words, said):
    assert said in refused("run", "gallery:pen_holder", "-p", "brick", *words)


@pytest.mark.parametrize(
    "words", [("gallery:pen_hodler",), ("gallery:pen_holder", "--set", "vertcies=3"), ("gallery:cup", "--protect", "rmi")]
)
def test_of_a_long_list_of_names_only_those_that_come_near_are_said(words):
    (line,) = [line for line in refused("run", *words, "-p", "brick").splitlines() if line.startswith("error")]
    assert "did you mean" in line
    assert len(line) < 120


@pytest.fixture
def lane(tmp_path):
    lane_on_a_sheet(tmp_path / "run")
    return Run.open(tmp_path / "run", "cpu")


def test_a_layer_in_the_place_of_an_iteration(lane):
    with pytest.raises(
        BadInput, match=r"'stress' is no iteration, which is a whole number; what is to be shown goes into fields=\['stress'\]"
    ):
        lane.show("stress")


def test_a_run_that_another_process_carries_on_is_refused_before_the_part_is_made_ready(tmp_path):
    lock = tmp_path / "part" / "locks" / "main.lock"
    lock.parent.mkdir(parents=True)
    with exclusive(lock, "lane 'main'"), pytest.raises(BadInput, match="is being carried on by process"):
        ms.stylize(box(), "brick", out=tmp_path / "part")


def test_a_setting_that_does_nothing_is_said_in_python_too(caplog, monkeypatch):
    monkeypatch.setattr(runs, "started", lambda *_args, **_settings: SimpleNamespace(go=lambda _: None))
    ms.stylize(box(), "brick", travel=0.2)
    assert "travel does nothing without the schedule geometry or stress" in caplog.text


def test_a_second_export_says_what_it_replaces(lane, monkeypatch):
    monkeypatch.setattr(Run, "exported", lambda _run, place, *_args, **_settings: place.write_text("solid"))
    monkeypatch.setattr(inspect_run, "report_export", lambda *_: None)
    first, again = (CliRunner().invoke(app, ["export", str(lane.store.root), "-f", "stl"]) for _ in range(2))
    assert (first.exit_code, again.exit_code) == (0, 0)
    assert "replaced" not in first.stderr
    assert "was there and is replaced; --out writes to another file" in " ".join(again.stderr.split())


def test_who_stops_before_anything_was_saved_learns_it(monkeypatch, tmp_path):
    def interrupted(*_args, **_settings):
        raise KeyboardInterrupt

    monkeypatch.setattr(runs, "made_ready", interrupted)
    done = CliRunner().invoke(app, ["run", "gallery:drawer_knob", "-p", "brick", "--out", str(tmp_path / "part")])
    assert done.exit_code == 130
    assert "interrupted; nothing was saved" in done.stderr
