"""The same parts and styles with mechanisms taken away: what is asked for, what is counted, and that a second time only reads."""

import json

import pytest
from typer.testing import CliRunner

from mechstyle.cli.app import app
from mechstyle.errors import BadInput
from mechstyle.records.recipe import SETTINGS
from mechstyle.study import ablation as module
from mechstyle.study.ablation import Ablation, ablation
from mechstyle.study.cells import Cell, Row
from mechstyle.study.grids import ARMS


def row(**changes):
    known = {"part": "hook", "prompt": "brick", "amplitude": 0.15, "arm": "full", "verdict": "VIABLE", "as_placed": 0.8, "kept": 0.9}
    return Row(**{**known, "simulations": 3, **changes})


def test_every_arm_takes_something_away_from_the_last_but_never_adds_a_setting_no_recipe_has():
    assert list(ARMS)[-2:] == ["full", "finish-first"]
    assert not ARMS["full"].settings
    assert all(name in SETTINGS for arm in ARMS.values() for name in arm.settings)


def test_the_static_twin_differs_from_the_corrected_one_by_the_correction_alone():
    static, corrected = (dict(ARMS[name].settings) for name in ("static", "finish-first"))
    assert static.pop("guarantee") is False
    assert static == corrected


@pytest.fixture
def asked(monkeypatch):
    """The cells that were walked over, without running them."""
    cells = []

    def walk(given, *_, **__):
        cells.extend(given)
        return [cell.row(verdict="VIABLE", kept=0.9) for cell in given]

    monkeypatch.setattr(module, "walk", walk)
    return cells


def test_all_arms_get_the_same_part_style_depth_and_settings(asked, tmp_path):
    found = ablation(["gallery:wall_hook"], ["fish scales"], tmp_path, amplitudes=[0.5], iterations=9)
    for cell, (name, arm) in zip(asked, ARMS.items(), strict=True):
        assert cell.folder == f"wall_hook-fish-scales-0.5/{name}"
        assert (cell.recipe.prompt, cell.recipe.amplitude, cell.recipe.iterations) == ("fish scales", 0.5, 9)
        assert cell.recipe.settings.items() >= arm.settings.items()
    assert [(one.part, one.arm) for one in found.rows] == [("wall_hook", name) for name in ARMS]


def test_unless_told_the_depth_is_the_default_one(asked, tmp_path):
    found = ablation(["gallery:wall_hook"], ["brick"], tmp_path, arms=["static"])
    assert asked[0].recipe.amplitude is None
    assert asked[0].folder == "wall_hook-brick-default/static"
    deeper = Ablation([row(amplitude=0.5), *found.rows])
    assert [line[0] for line in deeper.summary()[1:]] == ["default", "0.5"]
    assert "| brick | default | static |" in deeper.table()


def test_a_part_that_its_run_refuses_is_a_row_with_its_reason(monkeypatch, tmp_path):
    def refuse(self, out):
        raise BadInput("its walls are too thin")

    monkeypatch.setattr(Cell, "run", refuse)
    found = ablation(["gallery:wall_hook"], ["brick"], tmp_path / "out", arms=["static"])
    assert found.rows[0].refused == "its walls are too thin"
    assert "refused" in found.table()


def test_an_unknown_arm_is_refused_before_anything_is_run(tmp_path):
    with pytest.raises(BadInput, match="did you mean 'static'"):
        ablation(["gallery:wall_hook"], ["brick"], tmp_path, arms=["statics"])


def test_counts_are_by_depth_and_arm_and_leave_refused_runs_out():
    rows = [row(), row(part="cup", verdict="FAILS", as_placed=1.2, kept=0.5), row(part="box", refused="no"), row(amplitude=0.5, kept=0.7)]
    headings, shallow, deep = Ablation(rows).summary()
    assert dict(zip(headings, shallow, strict=True)) | {"tilted": "–"} == {
        "depth": "0.15", "arm": "full", "runs": "2", "viable": "50%", "as placed": "50%", "tilted": "–", "all orientations": "–",
        "marginal": "0", "kept": "0.70", "least": "0.50", "simulations": "3.0",
    }  # fmt: skip
    assert deep[:3] == ("0.5", "full", "1")


def test_what_is_saved_is_read_by_people_and_by_programs(tmp_path):
    rows = [row(), row(arm="static", verdict="FAILS", tilted=1.3, all_orientations=1.2, kept=0.97)]
    files = Ablation(rows).save(tmp_path)
    assert json.loads((tmp_path / "ablation.json").read_bytes())[1]["tilted"] == 1.3
    assert "| hook | brick | 0.15 | static | FAILS | 0.80 | 1.30 | 1.20 | 0.97 | 3 |" in (tmp_path / "ablation.md").read_text()
    assert (tmp_path / "ablation.png").read_bytes().startswith(b"\x89PNG")
    assert set(files) == {"table", "rows", "picture"}


def test_what_is_marginal_has_a_mark_and_a_colour_of_its_own_in_the_picture(monkeypatch):
    drawn = {}

    def scatter(_axes, _x, kept, **look):
        drawn[look["label"]] = (*kept, look["facecolor"])

    monkeypatch.setattr("matplotlib.axes.Axes.scatter", scatter)
    monkeypatch.setattr("matplotlib.axes.Axes.legend", lambda *_, **__: None)
    Ablation([row(), row(part="cup", marginal=True, kept=0.7), row(part="box", verdict="FAILS", marginal=True, kept=0.6)]).show()
    assert drawn == {"viable": (0.9, "#0072b2"), "marginal": (0.6, 0.7, "#f5b82e")}


def test_a_model_that_cannot_be_used_is_refused_before_anything_runs(asked, tmp_path):
    """It was a row, remembered for good, and the command ended as if all were well."""
    with pytest.raises(BadInput, match=r"none\.stl does not exist"):
        ablation(["gallery:wall_hook", str(tmp_path / "none.stl")], ["brick"], tmp_path / "out")
    assert not asked
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("refused", "code"), [(("too thin", "too thin"), 2), (("too thin", ""), 0)])
def test_the_command_tells_by_its_exit_code_that_nothing_could_be_used(refused, code, monkeypatch, tmp_path):
    rows = [row(status="refused" if why else "done", refused=why, arm=arm) for why, arm in zip(refused, ("static", "full"), strict=True)]
    monkeypatch.setattr(module, "ablation", lambda *_, **__: Ablation(rows))
    done = CliRunner().invoke(app, ["ablation", "gallery:wall_hook", "--out", str(tmp_path)])
    assert done.exit_code == code, done.output
    assert "too thin" in done.output
