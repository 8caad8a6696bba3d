"""The ladder that ends a run: every rung takes relief away, the last leaves the original part, byte for byte."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mechstyle.loop.backoff import CONTACT_RADIUS, LOCAL_RADIUS, LOCAL_ROUNDS, RUNGS, SCALES, nearness, overloaded, step
from mechstyle.records import Measures, Simulation

MEASURES = Measures(peak=20.0, p999=18.0, p99=12.0, maximum=30.0, where=(0.0, 0.0, 1.0), volume=1000.0)
COUNT = 60
LINE = np.zeros((COUNT, 3))
LINE[:, 0] = 3.0 * np.arange(COUNT)  # [mm]: one vertex every 3 mm, so that distances can be read off
LIMIT = np.full(COUNT, 45.6, np.float32)


def at(*places):
    chosen = np.zeros(COUNT, bool)
    chosen[list(places)] = True
    return chosen


def simulation(stress=None, envelope=None, contact=None):
    calm = np.full(COUNT, 20.0, np.float32)
    return Simulation(
        displacement=np.zeros(COUNT), stress=calm if stress is None else stress, envelope=calm if envelope is None else envelope,
        probability=np.zeros(COUNT), contact=at() if contact is None else contact,
        as_placed=MEASURES, overall=MEASURES, backed_off=0.0, deviation=0.0,
        time_step=1e-4, steps=10, added_mass=0.0,
    )  # fmt: skip


def loaded(*places):
    return np.where(at(*places), 60.0, 20.0).astype(np.float32)


def climb(rung, displacement, before_scaling=None, found=None):
    before = displacement if before_scaling is None else before_scaling
    return step(rung, displacement, before, found or simulation(loaded(30), contact=at(10)), LINE, LIMIT, LIMIT)


reliefs = arrays(np.float32, COUNT, elements=st.floats(-4, 4, width=32))

# --- nearness -----------------------------------------------------------------------------------------------------


def test_nearness_is_one_on_what_is_selected_and_falls_as_a_gaussian():
    found = nearness(LINE, at(30), 6.0)
    assert found[30] == 1.0
    assert found[[28, 32]] == pytest.approx(np.exp([-1.0, -1.0]), rel=1e-6)  # 6 mm away
    assert found[34] == pytest.approx(np.exp(-4.0), rel=1e-6)  # 12 mm away
    assert np.all(np.diff(found[:31]) >= 0.0)
    assert np.all(np.diff(found[30:]) <= 0.0)


def test_nearness_counts_from_the_nearest_selected_vertex():
    alone, both = nearness(LINE, at(20), 6.0), nearness(LINE, at(20, 40), 6.0)
    assert np.array_equal(both[:30], alone[:30])
    assert np.array_equal(both, np.maximum(alone, nearness(LINE, at(40), 6.0)))


def test_nothing_is_near_nothing():
    found = nearness(LINE, at(), 6.0)
    assert found.dtype == np.float32
    assert not found.any()


def test_everything_is_near_everything():
    assert np.all(nearness(LINE, np.ones(COUNT, bool), 6.0) == 1.0)


# --- what is overloaded -------------------------------------------------------------------------------------------


def test_overload_as_placed_comes_first():
    assert np.array_equal(overloaded(simulation(loaded(3, 4), loaded(50)), LIMIT, LIMIT), at(3, 4))


def test_overload_in_other_orientations_counts_where_there_is_none_as_placed():
    assert np.array_equal(overloaded(simulation(None, loaded(50)), LIMIT, LIMIT), at(50))


def test_each_stress_has_its_own_limit():
    generous = np.full(COUNT, 100.0, np.float32)
    assert np.array_equal(overloaded(simulation(loaded(3), loaded(50)), generous, LIMIT), at(50))
    assert np.array_equal(overloaded(simulation(loaded(3), loaded(50)), LIMIT, generous), at(3))


def test_stress_at_its_limit_is_no_overload():
    stress = np.where(at(3), LIMIT, 20.0).astype(np.float32)
    assert np.array_equal(overloaded(simulation(stress, loaded(50)), LIMIT, LIMIT), at(50))


def test_without_overload_the_fifty_closest_to_their_limit_are_chosen():
    for seed in range(20):
        order = np.random.default_rng(seed).permutation(COUNT)
        stress = (1.0 + 0.5 * order).astype(np.float32)
        assert np.array_equal(overloaded(simulation(stress), LIMIT, LIMIT), order >= COUNT - 50)


@pytest.mark.parametrize("count", [1, 49, 50])
def test_of_fifty_vertices_or_fewer_all_are_chosen(count):
    stress, limit = np.linspace(1.0, 2.0, count, dtype=np.float32), np.full(count, 45.6, np.float32)
    assert overloaded(SimpleNamespace(stress=stress, envelope=stress), limit, limit).all()


def test_closest_is_relative_to_the_limit_of_each_vertex():
    limit = np.where(at(0), 21.0, 200.0).astype(np.float32)
    assert overloaded(simulation(), limit, limit)[0]


# --- the rungs ----------------------------------------------------------------------------------------------------


@given(relief=reliefs)
def test_no_rung_ever_raises_the_relief_or_turns_it_round(relief):
    """A ladder on which nothing helps, climbed as the loop climbs it: scaling starts from what the first rungs left."""
    now = before_scaling = relief
    for rung in range(RUNGS):
        if rung == LOCAL_ROUNDS + 1:
            before_scaling = now
        smaller, _ = climb(rung, now, before_scaling)
        assert smaller.dtype == np.float32
        assert np.all(np.abs(smaller) <= np.abs(now))
        assert np.all(smaller * relief >= 0.0)
        now = smaller


@given(relief=reliefs)
def test_the_last_rung_is_the_original_part_to_the_byte(relief):
    """Its simulation is then remembered under the same name; a zero of negative sign would be another input."""
    flat, words = climb(RUNGS - 1, relief)
    assert flat.tobytes() == np.zeros(COUNT, np.float32).tobytes()
    assert words == "whole relief scaled to 0%"


@pytest.mark.parametrize(("rung", "left", "radius"), [(0, 0.4, 6.0), (1, 0.3, 9.0)])
def test_local_rounds_reduce_near_the_overload_and_leave_far_vertices_alone(rung, left, radius):
    relief = np.linspace(0.5, 1.5, COUNT, dtype=np.float32)
    smaller, words = climb(rung, relief)
    share = smaller / relief
    assert share[30] == pytest.approx(left, rel=1e-6)
    assert share[33] == pytest.approx(1.0 - (1.0 - left) * np.exp(-((9.0 / radius) ** 2)), rel=1e-6)  # 9 mm away
    far = np.abs(LINE[:, 0] - LINE[30, 0]) > 5.0 * radius  # exp(−25) is below half a unit in the last place of 1
    assert far.sum() >= 20
    assert np.array_equal(smaller[far], relief[far])
    assert words == f"relief reduced within {radius:g} mm of 1 overloaded vertices"


def test_the_second_round_reaches_half_as_far_again():
    assert LOCAL_ROUNDS == 2
    assert f"{1.5 * LOCAL_RADIUS:g} mm" in climb(1, np.ones(COUNT, np.float32))[1]


def test_the_contact_rung_removes_all_relief_at_the_contact_only():
    relief = np.ones(COUNT, np.float32)
    smaller, words = climb(LOCAL_ROUNDS, relief)
    assert smaller[10] == 0.0
    assert smaller[11] == pytest.approx(1.0 - np.exp(-((3.0 / 4.0) ** 2)), rel=1e-6)  # 3 mm away
    assert smaller[30] == 1.0
    assert words == f"relief removed within {CONTACT_RADIUS:g} mm of the contact"


def test_the_contact_rung_leaves_a_part_that_touched_nothing_alone():
    relief = np.linspace(-1.0, 1.0, COUNT, dtype=np.float32)
    assert np.array_equal(climb(LOCAL_ROUNDS, relief, found=simulation())[0], relief)


@pytest.mark.parametrize(("place", "factor"), list(enumerate(SCALES)))
def test_global_rungs_scale_what_was_there_before_scaling_began(place, factor):
    before = np.linspace(-1.0, 1.0, COUNT, dtype=np.float32)
    smaller, words = climb(LOCAL_ROUNDS + 1 + place, np.full(COUNT, 0.01, np.float32), before)
    np.testing.assert_array_equal(smaller, before * np.float32(factor))
    assert words == f"whole relief scaled to {factor:.0%}"


def test_the_whole_relief_is_scaled_to_seven_tenths_a_half_a_quarter_and_nothing():
    words = [climb(rung, np.ones(COUNT, np.float32))[1] for rung in range(LOCAL_ROUNDS + 1, RUNGS)]
    assert words == [f"whole relief scaled to {percent}%" for percent in (70, 50, 25, 0)]


def test_the_ladder_comes_down_steadily_and_ends_at_nothing():
    assert list(SCALES) == sorted(SCALES, reverse=True)
    assert SCALES[0] < 1.0
    assert SCALES[-1] == 0.0


def test_a_rung_does_not_write_into_the_relief_it_was_given():
    relief = np.ones(COUNT, np.float32)
    relief.setflags(write=False)
    for rung in range(RUNGS):
        climb(rung, relief)
    assert np.all(relief == 1.0)
