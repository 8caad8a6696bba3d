"""One drop test of a part as it is: what it is held to, and what is refused before anything slow is done."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle import dropped as module
from mechstyle.dropped import judge_alone, simulate
from mechstyle.errors import BadInput
from mechstyle.material import LIBRARY
from mechstyle.records import Measures, Simulation

PLA = LIBRARY["PLA"]


def simulation(peak, maximum=100.0, failure=""):
    measured = Measures(peak=peak, p999=peak, p99=0.5 * peak, maximum=maximum, where=(1.0, 2.0, 3.0), volume=100.0)
    one = np.zeros(1)
    return Simulation(
        displacement=one, stress=one, envelope=one, probability=one, contact=one > 0, as_placed=measured, overall=measured,
        backed_off=0.0, deviation=0.0, time_step=1e-4, steps=100, added_mass=0.0, failure=failure,
    )  # fmt: skip


def test_a_part_above_yield_fails_although_it_is_its_own_original():
    verdict = judge_alone(simulation(1.3 * PLA.yield_strength), PLA, "robust")
    assert verdict.outcome == "FAILS"
    assert verdict.deciding.limit == PLA.yield_strength
    assert "above the yield strength" in verdict.words


def test_a_part_below_yield_is_viable_whatever_its_literal_maximum():
    assert judge_alone(simulation(0.5 * PLA.yield_strength), PLA, "robust").outcome == "VIABLE"
    assert judge_alone(simulation(0.5 * PLA.yield_strength), PLA, "paper").outcome == "FAILS"


def test_there_is_nothing_to_compare_all_orientations_with():
    verdict = judge_alone(simulation(20.0), PLA, "robust")
    assert verdict.all_orientations is None
    assert "orientations" not in verdict.words


@pytest.mark.parametrize("broken", [simulation(0.0, failure="it blew up"), simulation(np.nan)], ids=["failed", "not a number"])
def test_what_was_not_computed_is_unknown(broken):
    assert judge_alone(broken, PLA, "robust").outcome == "UNKNOWN"


def test_the_peak_itself_is_left_as_it_was_measured():
    one = simulation(20.0)
    assert judge_alone(one, PLA, "robust").as_placed.value == 20.0


REFUSED = [({"orientations": 0}, "orientations is 0"), ({"criterion": "robst"}, "did you mean 'robust'")]


@pytest.mark.parametrize(("setting", "said"), REFUSED)
def test_settings_are_refused_before_the_part_is_prepared(monkeypatch, cube, setting, said):
    monkeypatch.setattr(module, "prepare", lambda *_, **__: pytest.fail("the part was prepared first"))
    with pytest.raises(BadInput, match=said):
        simulate(cube, **setting)
