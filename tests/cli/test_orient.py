"""The command that ranks ways up to print a part."""

from typer.testing import CliRunner

from mechstyle.cli.app import app
from mechstyle.runs.orient import WaysUp, WayUp


def told(*arguments):
    return CliRunner().invoke(app, ["orient", *map(str, arguments)], env={"COLUMNS": "160", "NO_COLOR": "1"})


def test_a_table_has_a_row_for_each_way_up_and_says_what_is_assumed(sheet, monkeypatch):
    here = {"overhang": 250.0, "height": 20.0, "base": 99.0}
    on_side = WayUp(name="on its -x side", up=(1.0, 0.0, 0.0), permanent_set=0.094, used=0.47, **here)
    ways = (on_side, WayUp(name="flat", up=(0.0, 0.0, 1.0), permanent_set=None, used=None, **here))
    monkeypatch.setattr("mechstyle.runs.orient.ways_up", lambda *_, **__: WaysUp(ways=ways, layers="weaker [a lot]", drops=3))
    outcome = told(sheet().store.root)
    assert outcome.exit_code == 0, outcome.output
    rows = [line.split() for line in outcome.output.splitlines()]
    assert ["on", "its", "-x", "side", "1,", "0,", "0", "0.09", "mm", "47%", "2.5", "20.0", "1.0"] in rows
    assert ["flat", "0,", "0,", "1", "not", "known", "–", "2.5", "20.0", "1.0"] in rows
    assert "weaker [a lot]" in outcome.output
    assert "3 drop tests were run or recalled" in outcome.output


def test_a_model_is_refused_with_what_is_needed(tmp_path):
    (tmp_path / "part.stl").write_bytes(b"solid")
    for model in ("gallery:vase", tmp_path / "part.stl"):
        outcome = told(model)
        assert outcome.exit_code == 2
        assert "ranked by the drop tests of a run" in " ".join(outcome.output.split())
