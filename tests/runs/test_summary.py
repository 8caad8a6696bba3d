"""What a run came to survives the way to disk and back, known or not."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from mechstyle.loop.objects import read_record, to_json
from mechstyle.runs.summary import Summary, little_left
from support.lanes import lane_on_a_sheet
from support.records import UNKNOWN


def test_a_summary_has_the_verdict_of_what_is_delivered_and_the_tests_behind_it(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", iterations=20)
    summary, verdict = run.summary, run.verdict
    assert (summary.outcome, summary.doubts, summary.rows, summary.words) == (verdict.outcome, verdict.doubts, verdict.rows, verdict.words)
    assert summary.tolerance == verdict.tolerance == 0.2
    assert summary.landings == run.simulation().landings
    assert summary.plain.rows[0].permanent_set == pytest.approx(0.2 * (20.0 / 45.6) ** 4)
    assert {"rows", "outcome", "tolerance", "kept"} <= set(msgspec.json.decode(to_json(summary))), "what programs read"


@pytest.mark.parametrize(
    ("kept", "cuts", "guarantee", "said"),
    [(0.33, 0.4, True, True), (0.95, 0.4, True, False), (0.33, 0.4, False, False), (0.33, 0.02, True, False)],
)
def test_a_run_that_keeps_little_says_how_to_keep_more_where_that_would(tmp_path, monkeypatch, kept, cuts, guarantee, said):
    """A box whose relief only stood out on 98 % of it was advised to let it go outwards."""
    monkeypatch.setattr("mechstyle.loop.engine.Engine.kept", lambda _engine, _state: kept)
    monkeypatch.setattr("mechstyle.loop.engine.Engine.cuts", lambda _engine: cuts)
    run = lane_on_a_sheet(tmp_path / "run", iterations=2, guarantee=guarantee)
    assert any("--side outwards" in note for note in run.summary.notes) == said


def test_an_unknown_verdict_can_be_read_back(tmp_path):
    run = lane_on_a_sheet(tmp_path / "run", iterations=2)
    none = msgspec.structs.replace(run.summary, outcome="UNKNOWN", rows=(), plain=UNKNOWN)
    (tmp_path / "summary.json").write_bytes(to_json(none))
    assert read_record(tmp_path / "summary.json", Summary) == none


def test_where_little_of_the_style_is_left_it_is_said_how_to_keep_more():
    said = little_left(0.33, 0.5)
    assert said.startswith("only 33% of the style is left")
    assert "--side outwards" in said
    assert little_left(0.33, 0.02) == little_left(0.95, 0.5) == "", "the advice would change nothing"


@pytest.mark.parametrize(("deep", "share"), [(-0.5, 1.0), (0.5, 0.0)])
def test_the_share_that_cuts_is_read_from_the_target(tmp_path, monkeypatch, deep, share):
    found = []
    monkeypatch.setattr("mechstyle.loop.engine.Engine._target", lambda engine: np.full(len(engine.surface.vertices), deep, np.float32))
    monkeypatch.setattr("mechstyle.runs.summary.little_left", lambda _kept, cuts: found.append(cuts) or "")
    lane_on_a_sheet(tmp_path / "run", iterations=2)
    assert found == [share]
