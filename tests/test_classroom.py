"""A class: what is prepared is what pupils type, and reports from anybody become one table or one sentence."""

from __future__ import annotations

import csv
import json
import shlex

import msgspec
import pytest
from typer.testing import CliRunner

from mechstyle.classroom import as_file, collect, prepare
from mechstyle.cli.app import app
from mechstyle.errors import BadInput
from mechstyle.runs.report.markup import script_json
from mechstyle.runs.report.page import write_report
from mechstyle.runs.report.result import Result, read_result, result_element
from mechstyle.runs.run import Draft
from support.lanes import lane_on_a_sheet

GOOD = {
    "part": "ring stand", "prompt": "brick", "material": "PLA", "outcome": "HOLDS", "sure": True, "fall": 1500.0,
    "tolerance": 0.2, "permanent_set": 0.063, "worst": "tilted 3° left", "kept": 0.9, "simulations": 3, "vertices": 3000,
    "recipe": "0" * 64,
}  # fmt: skip


def handed_in(folder, who, **changes):
    """A file with a result, as a report holds it."""
    path = folder / f"{who}.html"
    held = changes.pop("raw", None) or script_json(GOOD | changes)
    path.write_text(f'<!doctype html><p>…</p>\n<script type="application/json" id="result">{held}</script>\n', encoding="utf-8")
    return path


def test_a_report_carries_its_result(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", name="sheet </script>", iterations=3)
    result = read_result(write_report(run, tmp_path / "Ada.html"))
    assert (result.part, result.prompt, result.kept, result.recipe) == ("sheet </script>", "brick", run.summary.kept, run.recipe.digest)
    worst = run.verdict.deciding
    assert (result.outcome, result.fall, result.tolerance) == (run.verdict.outcome, 1500.0, 0.2)
    assert (result.permanent_set, result.worst) == (worst.permanent_set, worst.landing)


def test_an_unfinished_run_hands_in_nothing(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", iterations=12)
    later = run.branch(10, lane="later", seed=3)
    assert result_element(later, run.verdict) == ""
    (tmp_path / "later.html").write_text("<!doctype html>", encoding="utf-8")
    with pytest.raises(BadInput, match="no report of a finished run"):
        read_result(tmp_path / "later.html")


def test_who_keeps_most_and_passes_comes_first(tmp_path):
    files = [
        handed_in(tmp_path, "Ada", kept=0.8), handed_in(tmp_path, "Ben", kept=1.0, outcome="FAILS"),
        handed_in(tmp_path, "Cem", kept=0.95, outcome="NO WORSE"), handed_in(tmp_path, "Dea", kept=0.99, fall=750.0),
    ]  # fmt: skip
    lines = collect(files, 1500.0).lines[1:]
    assert [(line[0], line[1]) for line in lines] == [("1", "Cem"), ("2", "Ada"), ("–", "Ben"), ("–", "Dea, of a fall of 75 cm")]
    assert lines[0][4:] == ("NO WORSE", "0.06 mm", "tilted 3° left", "95%", "3")


HOSTILE = {
    "nothing": "{}",
    "cut": '{"part": "a", ',
    "nested": "[" * 9000,
    "more": json.dumps(GOOD | {"grade": 1}),
    "text": json.dumps(GOOD | {"kept": "all"}),
    "beyond": json.dumps(GOOD | {"kept": 99.0}),
    "infinite": json.dumps(GOOD | {"fall": 1e999}),
    "below": json.dumps(GOOD | {"permanent_set": -1.0}),
    "outcome": json.dumps(GOOD | {"outcome": "BEST"}),
    "long": json.dumps(GOOD | {"part": "a" * 9000}),
}


@pytest.mark.parametrize("what", HOSTILE)
def test_a_hostile_file_is_one_sentence_and_the_others_are_collected(what, tmp_path):
    files = [handed_in(tmp_path, "Ada"), handed_in(tmp_path, "Mallory", raw=HOSTILE[what])]
    handed = collect(files, 1500.0)
    assert [who for who, _ in handed.ranked] == ["Ada"]
    (sentence,) = handed.refused
    assert "Mallory.html" in sentence
    assert "mechstyle report" in sentence


def test_what_is_no_report_at_all_is_refused(tmp_path, monkeypatch):
    twice = tmp_path / "twice.html"
    twice.write_text(handed_in(tmp_path, "Ada").read_text(encoding="utf-8") * 2, encoding="utf-8")
    picture = tmp_path / "cat.html"
    picture.write_bytes(bytes(range(256)))
    for path in (twice, picture, tmp_path / "gone.html", tmp_path):
        with pytest.raises(BadInput, match=r"no report|no file"):
            read_result(path)
    monkeypatch.setattr("mechstyle.runs.report.result.MOST_BYTES", 10)
    with pytest.raises(BadInput, match="more than"):
        read_result(picture)
    with pytest.raises(BadInput, match="there is no report to collect"):
        collect([picture, twice], 1500.0)


def test_a_table_for_a_spreadsheet_holds_no_formula_and_one_for_a_page_no_markup(tmp_path):
    handed = collect([handed_in(tmp_path, "=cmd()", part="a|b", prompt="<b>*x*</b>\n# y")], 1500.0)
    with as_file(handed, tmp_path / "table.csv").open(encoding="utf-8-sig", newline="") as file:
        _, line = list(csv.reader(file))
    assert line[1] == "'=cmd()"
    page = as_file(handed, tmp_path / "table.md").read_text(encoding="utf-8").splitlines()
    assert len(page) == 5  # title, blank, headings, rule, one line
    assert "a\\|b" in page[-1]
    assert "<b>" not in page[-1].replace("\\<", "")
    with pytest.raises(BadInput, match=r"\.md or \.csv"):
        as_file(handed, tmp_path / "table.xls")


def test_the_command_line_prints_the_table_and_what_was_refused(tmp_path):
    good, bad = handed_in(tmp_path, "Ada"), handed_in(tmp_path, "Mallory", raw="[1]")
    done = CliRunner().invoke(app, ["class", "collect", str(good), str(bad)], env={"COLUMNS": "160", "NO_COLOR": "1"})
    assert done.exit_code == 0
    assert "Ada" in done.output
    assert "refused:" in done.output
    told = json.loads(CliRunner().invoke(app, ["class", "collect", str(good), str(bad), "--json"]).stdout)
    assert told["rows"][0]["who"] == "Ada"
    assert len(told["refused"]) == 1
    assert CliRunner().invoke(app, ["class", "collect", str(bad)]).exit_code == 2


@pytest.fixture
def prepared(monkeypatch, tmp_path):
    """Notes what would be prepared, and drops nothing."""
    noted = []

    class Begun:
        recipe = "recipe"

        def simulator(self, recipe):
            noted.append(recipe)
            return type("Simulator", (), {"baseline": None})

    monkeypatch.setattr(Draft, "ready", lambda asked, **_: noted.append(asked) or asked)
    monkeypatch.setattr(Draft, "begin", lambda _: Begun())
    tasks = prepare(["gallery:s_hook", "gallery:vase"], ["brick", "fish scales"], {"height": 1000.0}, folder=tmp_path)
    return tasks, noted, tmp_path


def test_pupils_type_what_was_prepared(prepared):
    tasks, noted, folder = prepared
    begun = [one for one in noted if isinstance(one, Draft)]
    assert [(one.name, one.recipe.style.prompt) for one in begun] == [
        ("s_hook", "brick"), ("s_hook", "fish scales"), ("vase", "brick"), ("vase", "fish scales")
    ]  # fmt: skip
    assert noted.count("recipe") == 4  # every plain part was dropped
    page = (folder / "commands.md").read_text(encoding="utf-8")
    for task, one in zip(tasks, begun, strict=True):
        words = shlex.split(task.command)
        assert task.command in page
        assert words[:3] == ["mechstyle", "run", task.model]
        asked = dict(zip(words[3::2], words[4::2], strict=True))
        assert asked["--prompt"] == one.recipe.style.prompt == task.prompt
        assert (asked["--height"], asked["--iterations"]) == ("1 m", str(one.recipe.schedule.iterations))
        assert asked["--vertices"] == str(one.vertices)
    folders = [shlex.split(task.command)[-1] for task in tasks]
    assert len(set(folders)) == len(tasks), "whoever types two of them would find the other's run in the folder"
    assert f"mechstyle report {folders[0]} --out" in page


def test_a_style_that_does_not_exist_is_refused_before_anything_is_meshed(monkeypatch, tmp_path):
    monkeypatch.setattr(Draft, "ready", lambda *_, **__: pytest.fail("it was begun"))
    with pytest.raises(BadInput):
        prepare(["gallery:s_hook"], ["brick", "crocodille"], {"control": "none such"}, folder=tmp_path)
    with pytest.raises(BadInput, match="at least one"):
        prepare([], ["brick"], {}, folder=tmp_path)


def test_a_result_is_of_a_few_hundred_bytes():
    assert len(msgspec.json.encode(msgspec.convert(GOOD, Result))) < 400
