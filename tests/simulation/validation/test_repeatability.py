"""What counts as a verdict that changes without a warning."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from mechstyle.fea.drop import DropTest
from mechstyle.geometry.remesh import standardise
from mechstyle.geometry.tetrahedra import tetrahedralise
from mechstyle.records import Measures, Simulation
from mechstyle.simulation.validation.bodies import styled_cup
from mechstyle.simulation.validation.meshes import bracket
from mechstyle.simulation.validation.repeatability import STRENGTHS, Pair, _changed, _period, flips, landed, spread


def simulation(surface, p99=20.0):
    measures = Measures(peak=surface, surface=surface, contact=5.0, p999=p99, p99=p99, maximum=surface, where=(0.0, 0.0, 0.0), volume=1.0)
    nothing = np.zeros(0, np.float32)
    return Simulation(
        displacement=nothing, stress=nothing, envelope=nothing, probability=nothing, contact=np.zeros(0, bool), as_placed=measures,
        tilted=measures, overall=measures, backed_off=0.0, deviation=0.0, time_step=1e-4, steps=10, added_mass=0.0,
    )  # fmt: skip


def pairs(*stresses):
    """Parts of the given stress, their original at a tenth of it."""
    original = simulation(1.0)
    return [Pair(simulation(stress), original) for stress in stresses]


def test_verdicts_of_equal_stress_never_change():
    assert flips("a", pairs(30.0, 30.0, 30.0)).measured == 0.0


def test_a_change_within_the_band_is_announced():
    found = flips("a", pairs(30.0, 30.6))
    assert found.passed
    assert "; 0 change" not in found.note, "the strengths that are tried must lie between the two"


@pytest.mark.parametrize("other", [33.5, 60.0])
def test_a_change_that_was_not_announced_is_counted(other):
    found = flips("a", pairs(30.0, other))
    assert found.passed is False
    assert 0 < found.measured <= len(STRENGTHS)


def test_the_envelope_counts_as_well():
    calm, wild = pairs(30.0, 30.0)
    wild = msgspec.structs.replace(wild, styled=simulation(30.0, p99=30.0))
    assert flips("a", [calm, wild]).passed is False


def test_spread_is_half_the_range_over_the_mean():
    found = {result.case: result for result in spread("a", [simulation(29.0), simulation(31.0)])}
    assert found["a, σ_2 as placed"].error == pytest.approx(1.0 / 30.0)
    assert found["a, σ_2 as placed"].passed is False
    assert found["a, p99 of the envelope"].error == 0.0


# --- what `mechstyle validate` holds on finer bodies, in seconds ------------------------------------------------------


def failing(results):
    return [f"{one.case}: {one.error:.3g} of {one.limit:g}, {one.note}" for one in results if not one.passed]


def test_five_triangulations_of_a_cup_read_the_same_and_turn_no_verdict_without_saying_so():
    cup = styled_cup()
    period = _period(cup.unstyled)
    filled = [tetrahedralise(standardise(cup.smooth, vertices), 2500) for vertices in (800, 900, 1000, 1100, 1200)]
    found = [landed(tets, period) for tets in filled]
    assert len({tets.digest for tets in filled}) == 5
    assert failing([*spread("cup", found), flips("cup", [Pair(one, found[0]) for one in found])]) == []


@pytest.mark.parametrize(("longer", "step"), [(2.0, 1.0), (1.0, 0.5)])
def test_neither_twice_the_time_nor_half_the_step_turns_a_verdict_of_a_bracket(longer, step):
    tets, test = bracket(40.0, 16.0, 4.0, 4.0), DropTest()
    period = _period(tets)
    usual, other = landed(tets, period), landed(tets, longer * period, replace(test, safety=step * test.safety))
    assert failing([*_changed("bracket", other, usual), flips("bracket", [Pair(usual, usual), Pair(other, usual)])]) == []
