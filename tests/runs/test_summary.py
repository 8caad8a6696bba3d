"""What a run came to survives the way to disk and back, known or not."""

from __future__ import annotations

import msgspec
import pytest

from mechstyle.loop.objects import read_record, to_json
from mechstyle.runs.summary import Summary
from support.lanes import lane_on_a_sheet
from support.records import UNKNOWN


def test_a_summary_has_the_verdict_of_what_is_delivered_and_the_tests_behind_it(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", iterations=20)
    summary, verdict = run.summary, run.verdict
    assert (summary.outcome, summary.doubts, summary.rows, summary.words) == (verdict.outcome, verdict.doubts, verdict.rows, verdict.words)
    most = max(row.stress for row in verdict.rows if row.decides)
    assert summary.safety_factor == pytest.approx(run.recipe.test.material.yield_strength / most)
    assert summary.landings == run.simulation().landings
    assert summary.plain.rows[0].stress == pytest.approx(20.0)


@pytest.mark.parametrize(("kept", "guarantee", "said"), [(0.33, True, True), (0.95, True, False), (0.33, False, False)])
def test_a_run_that_keeps_little_says_how_to_keep_more(tmp_path, monkeypatch, kept, guarantee, said):
    monkeypatch.setattr("mechstyle.loop.engine.Engine.kept", lambda _engine, _state: kept)
    run = lane_on_a_sheet(tmp_path / "run", iterations=2, guarantee=guarantee)
    assert any("--side outwards" in note for note in run.summary.notes) == said


def test_an_unknown_verdict_has_no_safety_factor_and_can_be_read_back(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", iterations=2)
    none = msgspec.structs.replace(run.summary, outcome="UNKNOWN", rows=(), safety_factor=UNKNOWN.safety_factor, plain=UNKNOWN)
    assert none.safety_factor is None
    (tmp_path / "summary.json").write_bytes(to_json(none))
    assert read_record(tmp_path / "summary.json", Summary) == none
