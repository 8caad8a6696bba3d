"""The result in a report that somebody handed in: what a run came to, or refused in a sentence."""

import msgspec
import pytest

from mechstyle.errors import BadInput
from mechstyle.loop.store import Lane
from mechstyle.runs.report.result import read_result, result_element
from mechstyle.runs.run import Run


def handed_in(folder, *elements):
    path = folder / "Ada.html"
    path.write_text("<!doctype html>\n" + "".join(elements), encoding="utf-8")
    return path


def test_what_is_read_is_what_the_run_came_to(lane, tmp_path):
    found = read_result(handed_in(tmp_path, result_element(lane, lane.verdict)))
    verdict, recipe = lane.verdict, lane.recipe
    assert (found.part, found.prompt, found.material) == (lane.record.name, recipe.style.prompt, recipe.test.material.label)
    assert (found.outcome, found.sure, found.fall, found.recipe) == (verdict.outcome, verdict.sure, recipe.test.height, recipe.digest)
    assert (found.permanent_set, found.tolerance) == (verdict.deciding.permanent_set, verdict.tolerance)
    assert (found.worst, found.kept) == ("flat", lane.summary.kept)
    assert (found.simulations, found.vertices) == (len(lane.summary.simulations), len(lane.part.surface.vertices))


def test_a_lane_that_is_not_finished_has_none(sheet):
    run = sheet(iterations=2)
    run.store.move("empty", Lane(recipe=run.recipe.digest))
    assert result_element(Run(run.store, "empty", "cpu"), run.verdict) == ""


@pytest.mark.parametrize("count", [0, 2])
def test_a_page_with_no_result_or_with_two_is_no_report(lane, tmp_path, count):
    """The unsafe side: of two, one could be of another run."""
    with pytest.raises(BadInput, match="no report of a finished run"):
        read_result(handed_in(tmp_path, *[result_element(lane, lane.verdict)] * count))


@pytest.mark.parametrize(
    "forged",
    [{"outcome": "PASSED"}, {"kept": 2.0}, {"kept": -1.0}, {"fall": 0.0}, {"simulations": 0}, {"vertices": 3}, {"part": "x" * 501}],
)
def test_a_result_that_no_run_comes_to_is_refused(lane, tmp_path, forged):
    result = msgspec.structs.replace(read_result(handed_in(tmp_path, result_element(lane, lane.verdict))), **forged)
    held = msgspec.json.encode(result).decode()
    with pytest.raises(BadInput, match="that no run comes to"):
        read_result(handed_in(tmp_path, f'<script type="application/json" id="result">{held}</script>'))
