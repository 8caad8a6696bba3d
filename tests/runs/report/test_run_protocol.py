"""What a report asks of a run: each member is there, and a lane that has not begun is refused in a sentence."""

import pytest

from mechstyle.errors import BadInput
from mechstyle.loop.store import Lane
from mechstyle.runs.report.run_protocol import LaneOfRun, begun
from mechstyle.runs.run import Run


def members(protocol) -> set[str]:
    return {name for name in vars(protocol) if not name.startswith("_")}


def test_a_run_has_whatever_a_report_asks_for(lane):
    assert {"store", "recipe", "summary", "show"} <= members(LaneOfRun)
    assert all(hasattr(lane, name) for name in members(LaneOfRun))


def test_a_lane_without_a_checkpoint_is_refused_and_one_with_some_has_a_row_for_each(sheet):
    run = sheet(iterations=3)
    assert [row.digest for row in begun(run)] == [entry.digest for entry in run.history]
    run.store.move("empty", Lane(recipe=run.recipe.digest))
    with pytest.raises(BadInput, match=r"lane 'empty' of .* has no checkpoint yet"):
        begun(Run(run.store, "empty", "cpu"))
