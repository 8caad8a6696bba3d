"""The same parts and styles with mechanisms taken away: what is asked for, what is counted, and that a second time only reads."""

import json

import pytest
from typer.testing import CliRunner

from mechstyle.cli.app import app
from mechstyle.errors import BadInput
from mechstyle.records.recipe import SETTINGS
from mechstyle.runs.recipes import draft
from mechstyle.study import ablation as module
from mechstyle.study.ablation import COUNTED, SINGLE, Ablation, ablation
from mechstyle.study.cells import Cell, Row
from mechstyle.study.grids import ARMS, CONDITIONS


def row(**changes):
    known = {"part": "hook", "prompt": "brick", "arm": "masks", "outcome": "HOLDS", "sure": True, "kept": 0.9, "simulations": 3}
    return Row(**{**known, "flat_stress": 41.5, "flat_height": 1800.0, "plain_flat_height": 2400.0, "seconds": 60.0, **changes})


def test_every_arm_is_a_recipe_of_its_own_whatever_the_defaults_are():
    assert list(ARMS) == ["freestyle", "static", "finish-first", "masks"]
    assert all(name in SETTINGS for arm in ARMS.values() for name in arm.settings)
    recipes = {name: draft("brick", **arm.settings) for name, arm in ARMS.items()}
    assert [name for name, recipe in recipes.items() if recipe.restraint.guarantee] == ["finish-first", "masks"]
    assert {name: recipe.restraint.base for name, recipe in recipes.items() if recipe.restraint.base != "plain"} == {"freestyle": "free"}
    assert [recipes[name].schedule.when for name in ("finish-first", "masks")] == ["never", "stress"]


def test_the_static_twin_differs_from_the_corrected_one_by_the_correction_alone():
    static, corrected = (draft("brick", **ARMS[name].settings) for name in ("static", "finish-first"))
    assert [name for name, *_ in static.differences(corrected)] == ["guarantee"]


@pytest.fixture
def asked(monkeypatch):
    """The cells that were walked over, without running them."""
    cells = []

    def walk(given, *_, **__):
        cells.extend(given)
        return [cell.row(outcome="HOLDS", kept=0.9) for cell in given]

    monkeypatch.setattr(module, "walk", walk)
    return cells


def test_all_arms_get_the_same_part_style_and_settings(asked, tmp_path):
    found = ablation(["gallery:wall_hook", "gallery:wall_hook"], ["fish scales"], tmp_path, iterations=9, height="1 m")
    for cell, (name, arm) in zip(asked, ARMS.items(), strict=True):
        assert cell.arm == name
        common = {"prompt": "fish scales", "amplitude": None, "iterations": 9, "height": 1000.0}
        assert cell.recipe.settings.items() >= common.items()
        assert cell.recipe.settings.items() >= arm.settings.items()
    assert [(one.part, one.condition, one.arm) for one in found.rows] == [("wall_hook", "drop", name) for name in ARMS]


def test_rows_stand_by_condition_then_part_style_and_arm(asked, tmp_path):
    found = ablation(["gallery:wall_hook", "gallery:pill_box"], ["brick"], tmp_path, conditions=["deep", "drop"], arms=["masks", "static"])
    told = [(one.condition, one.part, one.arm) for one in found.rows]
    assert told[:3] == [("deep", "pill_box", "static"), ("deep", "pill_box", "masks"), ("deep", "wall_hook", "static")]
    assert [line[:2] for line in found.summary()[1:]] == [(one, arm) for one in ("deep", "drop") for arm in ("static", "masks")]


def test_a_part_that_its_run_refuses_is_a_row_with_its_reason_and_stops_no_other(monkeypatch, tmp_path):
    def refuse(self, out):
        if self.arm == "static":
            raise BadInput("its walls are too thin")
        raise ZeroDivisionError("nothing left")

    monkeypatch.setattr(Cell, "run", refuse)
    found = ablation(["gallery:wall_hook"], ["brick"], tmp_path / "out", arms=["static", "masks"])
    assert [(one.status, one.refused) for one in found.rows] == [
        ("refused", "its walls are too thin"), ("failed", "ZeroDivisionError: nothing left"),
    ]  # fmt: skip
    assert "| refused: its walls are too thin |" in found.table()
    assert found.summary()[1:] == []


@pytest.mark.parametrize(
    ("changes", "words"), [({"arms": ["statics"]}, "did you mean 'static'"), ({"conditions": ["lead"]}, "did you mean 'load'")]
)
def test_an_unknown_name_is_refused_before_anything_is_run(asked, changes, words, tmp_path):
    with pytest.raises(BadInput, match=words):
        ablation(["gallery:wall_hook"], ["brick"], tmp_path, **changes)
    assert not asked


def test_counts_are_by_condition_and_arm_and_leave_out_what_did_not_run():
    rows = [
        row(), row(part="cup", outcome="FAILS", kept=0.5, seconds=90.0), row(part="pin", outcome="NO WORSE", sure=False),
        row(part="lid", outcome="UNKNOWN", sure=False, kept=0.7), row(part="box", status="refused", refused="no"),
        row(part="jar", status="failed", refused="died"), row(condition="deep", kept=0.6),
    ]  # fmt: skip
    headings, shallow, deep = Ablation(rows).summary()
    assert headings == ("condition", "arm", *COUNTED)
    assert dict(zip(headings, shallow, strict=True)) == {
        "condition": "drop", "arm": "masks", "runs": "4", "passes": "2", "HOLDS": "1", "FAILS": "1", "sure": "2",
        "kept": "0.80", "least": "0.50", "simulations": "3.0", "seconds": "68",
    }  # fmt: skip
    assert deep[:4] == ("deep", "masks", "1", "1")


def test_feedback_is_compared_with_its_twin_of_the_same_part_and_style_only():
    rows = [row(arm="static", outcome="FAILS"), row(), row(arm="static", part="cup"), row(part="cup"), row(part="lid")]
    said = "drop: masks passes in 2 of 2, its static twin in 1 of 2 (+50 points)."
    assert Ablation([*rows, row(arm="freestyle")]).against_the_twin() == [said]


def test_what_is_saved_is_read_by_people_and_by_programs(tmp_path):
    rows = [row(), row(arm="static", outcome="FAILS", nearly_stress=88.0, nearly_height=400.0, load_factor=0.7, sure=False, kept=0.97)]
    files = Ablation(rows).save(tmp_path)
    assert json.loads((tmp_path / "ablation.json").read_bytes())[1]["nearly_height"] == 400.0
    text = (tmp_path / "ablation.md").read_text()
    assert "| hook | brick | drop | static | FAILS | no | 41.5 | 2.4 m | 1.8 m | 88.0 | – | 40 cm | 0.70 | – | 0.97 | 3 | 60 |" in text
    assert f"* **drop**: {CONDITIONS['drop'].about}." in text
    assert f"* **static**: {ARMS['static'].about}." in text
    assert "freestyle" not in text
    assert all(line.count("|") in (len(SINGLE) + 1, len(COUNTED) + 3) for line in text.splitlines() if line.startswith("|"))
    assert (tmp_path / "ablation.png").read_bytes().startswith(b"\x89PNG")
    assert set(files) == {"table", "rows", "picture"}


def test_each_outcome_has_a_mark_of_its_own_that_is_filled_only_where_it_is_sure(monkeypatch):
    drawn = {}

    def scatter(_axes, _x, kept, **look):
        drawn[look["label"]] = (*kept, look["marker"], look["facecolor"])

    monkeypatch.setattr("matplotlib.axes.Axes.scatter", scatter)
    monkeypatch.setattr("matplotlib.axes.Axes.legend", lambda *_, **__: None)
    Ablation([row(), row(part="cup", sure=False, kept=0.7), row(part="box", outcome="FAILS", kept=0.6)]).show()
    assert drawn == {"HOLDS": (0.9, "o", "#0072b2"), "HOLDS, not sure": (0.7, "o", "white"), "FAILS": (0.6, "X", "#d55e00")}


def test_a_model_that_cannot_be_used_is_refused_before_anything_runs(asked, tmp_path):
    """It was a row, remembered for good, and the command ended as if all were well."""
    with pytest.raises(BadInput, match=r"none\.stl does not exist"):
        ablation(["gallery:wall_hook", str(tmp_path / "none.stl")], ["brick"], tmp_path / "out")
    assert not asked
    assert not (tmp_path / "out").exists()


def test_the_command_asks_for_the_cells_it_is_given(asked, tmp_path):
    words = ["gallery:wall_hook", "gallery:coaster", "-p", "brick", "-p", "cactus", "--condition", "drop", "--condition", "load"]
    words += ["--arm", "static", "--height", "1 m", "--vertices", "900", "--out", str(tmp_path), "--json"]
    done = CliRunner().invoke(app, ["ablation", *words])
    assert done.exit_code == 0, done.output
    told = [(cell.part, cell.recipe.style.prompt, cell.condition, cell.vertices, cell.recipe.test.height) for cell in asked]
    assert sorted(told) == sorted(
        (part, style, condition, 900, 1000.0)
        for part, condition in (("wall_hook", "drop"), ("wall_hook", "load"), ("coaster", "drop")) for style in ("brick", "cactus")
    )  # fmt: skip
    assert len(json.loads(done.output)["rows"]) == 6


@pytest.mark.parametrize(("refused", "code"), [(("too thin", "too thin"), 2), (("too thin", ""), 0)])
def test_the_command_tells_by_its_exit_code_that_nothing_could_be_used(refused, code, monkeypatch, tmp_path):
    rows = [row(status="refused" if why else "done", refused=why, arm=arm) for why, arm in zip(refused, ("static", "masks"), strict=True)]
    monkeypatch.setattr(module, "ablation", lambda *_, **__: Ablation(rows))
    done = CliRunner().invoke(app, ["ablation", "gallery:wall_hook", "--out", str(tmp_path)])
    assert done.exit_code == code, done.output
    assert "too thin" in done.output
