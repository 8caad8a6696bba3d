"""The timeline as SVG: each simulation against its own limit, and names where nothing is in their way."""

import itertools
import re

import msgspec
import numpy as np
import pytest

from mechstyle.loop.history import rows, steps
from mechstyle.records import Doubt
from mechstyle.runs.report.markup import RING, SHAPES, cells
from mechstyle.runs.report.page import _row
from mechstyle.runs.report.timeline import ticks, timeline
from support.records import UNKNOWN, published_row, row
from support.records import verdict as judged


def step_of(lane, judged, iteration=0):
    step = steps(lane.store, rows(lane.store))[0]
    return msgspec.structs.replace(step, iteration=iteration, verdict=judged)


def test_an_outcome_that_is_not_sure_has_a_ring_and_says_so(lane):
    doubt = Doubt(about="limit", value=1.01, test="flat", landing="flat")
    unsure = step_of(lane, msgspec.structs.replace(judged(row()), doubts=(doubt,)))
    drawn = str(timeline([unsure], 1))
    assert 'class="mark holds"' in drawn
    assert "HOLDS (not sure), flat: " in drawn
    assert RING in drawn
    assert '<span class="holds">HOLDS</span><span class="unknown"> (not sure)</span>' in cells(_row(unsure))
    sure = step_of(lane, judged(row()))
    assert RING not in str(timeline([sure], 1))
    assert '<span class="holds">HOLDS</span></td>' in cells(_row(sure))


def test_a_test_without_an_answer_is_drawn_as_one(lane):
    drawn = str(timeline([step_of(lane, UNKNOWN)], 1))
    assert SHAPES["UNKNOWN"] in drawn
    assert "UNKNOWN; original part" in drawn
    assert "allowed 0.20 mm" in drawn


def test_by_the_published_rule_it_is_of_stress(lane):
    drawn = str(timeline([step_of(lane, judged(published_row(), criterion="paper"))], 1))
    assert "allowed 45.6 MPa" in drawn
    assert "largest stress in an element [MPa]" in drawn


def test_what_gives_way_is_drawn_at_the_top_and_the_rest_can_still_be_told(lane):
    told = [step_of(lane, judged(row(bend)), iteration) for iteration, bend in enumerate((0.1, 40.0))]
    marks = [float(y) for y in re.findall(r'class="mark [^"]*" transform="translate\([-.\d]+ ([-.\d]+)\)', str(timeline(told, 1)))]
    assert marks[1] > 34.0 - 1e-6
    assert 204.0 - marks[0] > 10.0


@pytest.mark.parametrize(
    "peaks", [(26, 27, 27, 27), (30, 60, 55, 45.4), (20, 44, 45, 45.5), (60, 44, 47, 44), (45, 46, 45, 46, 44, 46, 45, 80)], ids=str
)
def test_the_name_of_the_limit_stands_where_the_curve_is_not(lane, peaks):
    """Far below what is allowed, falling to it, rising to it, across it, and along it, in tenths of a millimetre."""
    told = [step_of(lane, judged(row(float(peak), allowed=45.6)), iteration) for iteration, peak in enumerate(peaks)]
    drawn = str(timeline(told, len(peaks) - 1))
    right, base = (float(re.search(rf'class="limit-name"[^>]* {name}="([-.\d]+)"', drawn)[1]) for name in "xy")
    line = [tuple(map(float, point.split(","))) for point in re.search(r'class="peaks" points="([^"]+)"', drawn)[1].split()]
    curve = np.concatenate([np.linspace(one, other, 200) for one, other in itertools.pairwise(line)])
    for points, room in ((curve, 2.0), (np.array(line), 8.0)):
        beside = np.maximum(right - 95.0 - points[:, 0], points[:, 0] - right)
        over_or_under = np.maximum(base - 11.0 - points[:, 1], points[:, 1] - base - 3.0)
        assert np.maximum(beside, over_or_under).min() >= room


def test_each_simulation_is_drawn_against_its_own_limit(lane):
    """Where a load decides first and a landing at the end, the mark of either stood beside the limit of the last."""
    told = [step_of(lane, judged(row(0.5 * limit, allowed=limit)), iteration) for iteration, limit in enumerate((0.2, 0.4))]
    drawn = str(timeline(told, 1))
    heights = [float(y) for y in re.findall(r"V([-.\d]+)", re.search(r'class="limit" d="([^"]+)"', drawn)[1])]
    marks = [float(y) for y in re.findall(r'class="mark [^"]*" transform="translate\([-.\d]+ ([-.\d]+)\)', drawn)]
    assert [204.0 - y for y in marks] == pytest.approx([0.5 * (204.0 - y) for y in heights], abs=0.1)


@pytest.mark.parametrize(("top", "about", "wanted"), [(60, 6, [0, 10, 20, 30, 40, 50, 60]), (51, 4, [0, 20, 40]), (1, 10, None)])
def test_ticks_are_round_numbers(top, about, wanted):
    found = list(ticks(top, about))
    assert found[0] == 0
    assert found[-1] <= top * (1 + 1e-9)
    assert wanted is None or found == wanted
