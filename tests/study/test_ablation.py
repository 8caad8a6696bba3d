"""The same parts and styles with mechanisms taken away: what is asked for, what is counted, and that a second time only reads."""

import json
import os

import pytest

from mechstyle.errors import BadInput
from mechstyle.records.recipe import SETTINGS
from mechstyle.study import ablation as module
from mechstyle.study.ablation import ARMS, Ablation, Cell, Row, ablation, row_of
from support.lanes import lane_on_a_sheet


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


def test_all_arms_get_the_same_part_style_depth_and_settings(monkeypatch, tmp_path):
    asked = []

    def run(_, prompt, **settings):
        asked.append((prompt, settings))
        return lane_on_a_sheet(tmp_path / f"sheet-{len(asked)}")

    monkeypatch.setattr(module, "stylize", run)
    found = ablation(["gallery:wall_hook"], ["fish scales"], tmp_path, amplitudes=[0.5], iterations=9)
    assert [prompt for prompt, _ in asked] == ["fish scales"] * len(ARMS)
    for (_, settings), (name, arm) in zip(asked, ARMS.items(), strict=True):
        assert settings["out"] == tmp_path / "wall_hook-fish-scales-0.5" / name
        assert (settings["amplitude"], settings["iterations"], settings["name"]) == (0.5, 9, "wall_hook")
        assert settings.items() >= arm.settings.items()
    assert [(one.part, one.arm) for one in found.rows] == [("wall_hook", name) for name in ARMS]


def test_unless_told_the_depth_is_the_default_one(monkeypatch, tmp_path):
    asked = []
    monkeypatch.setattr(module, "stylize", lambda *_, **settings: asked.append(settings) or lane_on_a_sheet(tmp_path / "sheet"))
    found = ablation(["gallery:wall_hook"], ["brick"], tmp_path, arms=["static"])
    assert "amplitude" not in asked[0]
    assert asked[0]["out"] == tmp_path / "wall_hook-brick-default" / "static"
    deeper = Ablation([row(amplitude=0.5), *found.rows])
    assert [line[0] for line in deeper.summary()[1:]] == ["default", "0.5"]
    assert "| brick | default | static |" in deeper.table()


def test_a_refused_part_is_a_row_with_its_reason(tmp_path):
    found = ablation([str(tmp_path / "none.stl")], ["brick"], tmp_path / "out", arms=["static"])
    assert "none.stl" in found.rows[0].refused
    assert "refused" in found.table()


def test_an_unknown_arm_is_refused_before_anything_is_run(tmp_path):
    with pytest.raises(BadInput, match="did you mean 'static'"):
        ablation(["gallery:wall_hook"], ["brick"], tmp_path, arms=["statics"])


def test_a_row_has_the_figures_of_its_run(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", gain=90.0)
    found = row_of(run, part="sheet", prompt="bump", amplitude=0.15, arm="full")
    placed = run.verdict.as_placed
    assert (found.verdict, found.kept) == (run.summary.verdict, run.summary.kept)
    assert found.as_placed == placed.value / placed.limit
    assert found.simulations == len(run.summary.simulations)


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


class _Cores(Cell, frozen=True, kw_only=True):
    """A cell that tells where it runs instead of running."""

    def rows(self):
        return [row(part=self.model, kept=float(len(os.sched_getaffinity(0))), simulations=os.getpid())]


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity") or len(os.sched_getaffinity(0)) < 2, reason="needs two cores to share")
def test_processes_side_by_side_share_the_cores_and_every_part_is_told(monkeypatch, tmp_path):
    told = []
    monkeypatch.setattr(module, "Cell", _Cores)
    found = ablation(["a", "b", "c", "d"], ["brick"], tmp_path, jobs=2, tell=told.append)
    assert [one.part for one in found.rows] == ["a", "b", "c", "d"]
    assert os.getpid() not in {one.simulations for one in found.rows}
    assert max(one.kept for one in found.rows) <= (len(os.sched_getaffinity(0)) + 1) // 2
    assert len(told) == 4
