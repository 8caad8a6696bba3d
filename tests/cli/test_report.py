"""`mechstyle report` writes where it is told, else into the run directory, and says where."""

import json

from typer.testing import CliRunner

from mechstyle.cli.app import app

RUNNER = CliRunner()


def test_it_writes_into_the_run_directory_and_says_so(sheet):
    run = sheet(iterations=3)
    done = RUNNER.invoke(app, ["report", str(run.store.root), "--json"])
    assert done.exit_code == 0
    path = run.store.root / "sheet-main.html"
    assert json.loads(done.stdout) == {"lane": "main", "files": {"report": str(path)}}
    assert "<!doctype html>" in path.read_text(encoding="utf-8")


def test_it_reports_the_lane_asked_for(sheet, tmp_path):
    run = sheet(iterations=12)
    run.branch(10, lane="later", seed=3)
    out = tmp_path / "later.html"
    assert RUNNER.invoke(app, ["report", f"{run.store.root}@later", "--out", str(out)]).exit_code == 0
    assert "lane later, stands at iteration 10" in out.read_text(encoding="utf-8")


def test_an_iteration_is_refused_in_one_sentence(sheet):
    run = sheet(iterations=3)
    done = RUNNER.invoke(app, ["report", f"{run.store.root}@2"])
    assert done.exit_code == 2
    assert "names an iteration" in done.output
