"""What counts as a verdict that changes without a warning."""

import msgspec
import numpy as np
import pytest

from mechstyle.records import Measures, Simulation
from mechstyle.simulation.validation.repeatability import STRENGTHS, Pair, flips, spread


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
