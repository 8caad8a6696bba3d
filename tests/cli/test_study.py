"""The study commands: lists take the words that follow, bad ones are refused at once, and what came out is told."""

import json

import pytest
from typer.testing import CliRunner

from mechstyle.cli.app import app
from mechstyle.study import walk as walking


@pytest.fixture
def asked(monkeypatch, tmp_path):
    """A command line that walks over cells without running them, and what it was asked for."""
    monkeypatch.chdir(tmp_path)
    seen = []

    def walk(cells, folder, *, jobs, scheduler, tell):
        seen.append((cells, str(folder), jobs, scheduler))
        return [cell.row(outcome="HOLDS", sure=True, kept=0.9, tetrahedra=9) for cell in cells]

    monkeypatch.setattr(walking, "walk", walk)

    def line(*words, code=0):
        done = CliRunner().invoke(app, ["study", *words])
        assert done.exit_code == code, done.output
        return done

    return line, seen


def test_lists_take_all_the_words_that_follow(asked):
    line, seen = asked
    line(
        "formative", "--models", "pen_holder", "phone_stand", "wall_hook", "--styles", "brick", "green", "--vertices", "6000",
        "--iterations", "60", "--seeds", "1", "2", "--jobs", "2", "--out", "here", "--set", "nearly_flat=False",
    )  # fmt: skip
    ((cells, folder, jobs, scheduler),) = seen
    assert (len(cells), folder, jobs, scheduler) == (12, "here", 2, "")
    assert {cell.part for cell in cells} == {"pen_holder", "phone_stand", "wall_hook"}
    assert {(cell.recipe.schedule.iterations, cell.recipe.test.nearly_flat, cell.vertices) for cell in cells} == {(60, 0, 6000)}
    assert {cell.recipe.style.seed for cell in cells} == {1, 2}


def test_what_is_asked_for_reaches_every_study(asked):
    line, seen = asked
    line("evaluation", "--models", "vase", "--styles", "brick", "--controls", "frozen", "--schedules", "stress", "--scheduler", "tcp://h:1")
    line("ablation", "--models", "vase", "--styles", "fish scales", "--arms", "masks", "strengthened", "--conditions", "deep", "load")
    assert [cell.arm for cell in seen[0][0]] == ["freestyle", "stress × frozen"]
    assert seen[0][3] == "tcp://h:1"
    cells = seen[1][0]
    told = [(one.arm, one.condition, one.recipe.style.amplitude, one.load_share, one.recipe.delivery.strengthen) for one in cells]
    assert told == [
        ("masks", "deep", 0.25, 0.0, 0.0), ("masks", "load", None, 0.85, 0.0),
        ("strengthened", "deep", 0.25, 0.0, 2.0), ("strengthened", "load", None, 0.85, 2.0),
    ]  # fmt: skip


def test_one_object_of_json_is_all_that_is_printed(asked):
    line, _ = asked
    told = json.loads(line("formative", "--models", "vase", "--styles", "brick", "--json").output)
    assert [(row["outcome"], row["sure"]) for row in told["rows"]] == [("HOLDS", True)]
    assert set(told["files"]) == {"rows", "table"}


def test_a_model_that_is_not_there_is_refused_before_anything_runs(asked):
    line, seen = asked
    assert "did you mean 'vase'" in json.loads(line("formative", "--models", "vaze", "--json", code=2).output)["error"]
    assert "did you mean 'frozen'" in json.loads(line("evaluation", "--controls", "frosen", "--json", code=2).output)["error"]
    assert not seen


def test_a_file_that_cannot_be_used_is_refused_before_anything_runs(asked, tmp_path):
    """Hours after the first of them had run it was a row that nobody had asked for."""
    line, seen = asked
    (tmp_path / "open.stl").write_text("solid nothing\nendsolid\n")
    for model in ("none.stl", "open.stl"):
        told = json.loads(line("formative", "--models", "vase", model, "--styles", "brick", "--json", code=2).output)
        assert model in told["error"]
    assert not seen
    assert not list(tmp_path.glob("study-*"))


def test_a_page_is_made_of_a_folder_and_says_where_it_is(asked, tmp_path):
    line, _ = asked
    line("formative", "--models", "vase", "--styles", "brick", "--out", "here", "--json")
    table = next((tmp_path / "here").glob("table.*"))
    files = json.loads(line("page", str(table), "--out", "page.md", "--note", "a try", "--json").output)["files"]
    assert "a try" in (tmp_path / "page.md").read_text()
    assert {"page", "table", "freestyle"} <= set(files)


def test_a_study_of_which_all_was_refused_ends_with_the_exit_code_of_bad_input(asked, monkeypatch):
    line, _ = asked
    monkeypatch.setattr(walking, "walk", lambda cells, *_, **__: [cell.row(status="refused", refused="too thin") for cell in cells])
    assert "too thin" in line("formative", "--models", "vase", "--styles", "brick", code=2).output


def test_the_fall_that_is_asked_for_reaches_every_recipe(asked):
    line, seen = asked
    line("formative", "--models", "vase", "--styles", "brick", "--height", "80 cm")
    assert [cell.recipe.test.height for cell in seen[0][0]] == [800.0]


def test_what_passes_is_counted_by_condition_and_arm_with_how_many_are_sure(asked, monkeypatch):
    line, _ = asked
    rows = [("HOLDS", True), ("NO WORSE", False), ("FAILS", True)]
    monkeypatch.setattr(walking, "walk", lambda cells, *_, **__: [cells[0].row(outcome=one, sure=sure, kept=0.5) for one, sure in rows])
    told = [words.split() for words in line("formative", "--models", "vase", "--styles", "brick").output.splitlines()]
    assert any(words[:4] == ["drop", "freestyle", "3", "2"] and words[-3:] == ["2", "0.50", "0"] for words in told)
