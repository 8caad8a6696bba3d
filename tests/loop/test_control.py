"""From stress to restraint: demand on hand-computed figures, masks with their exact limits."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mechstyle.errors import BadInput
from mechstyle.fea.verdict import judge
from mechstyle.loop.control import MASKS, demand, exponential, frozen, headroom, landed, linear, mask, normalised, unrestrained
from mechstyle.records import CONTROLS, NORMALISATIONS, LoadResult, Measures, Simulation
from mechstyle.records.limits import UNHARMED, Limits
from mechstyle.records.material import LIBRARY

PLA = LIBRARY["PLA"]  # yield strength 45.6 MPa, critical stress 0.2 · 45.6 = 9.12 MPa
RESTRAINING = [linear, exponential, frozen]
restraining = pytest.mark.parametrize("restrain", RESTRAINING, ids=lambda function: function.__name__)


def field(*values):
    return np.array(values, np.float32)


# Float32 neighbours of 1, where exp(-s / (1 - s)) blows up if it is not kept away from its pole.
CRITICAL = field(0.0, 1e-45, 0.5, np.nextafter(np.float32(1), np.float32(0)), 1.0, np.nextafter(np.float32(1), np.float32(2)), 2.0, 3e38)
demands = arrays(np.float32, st.integers(1, 30), elements=st.one_of(st.floats(0, 2, width=32), st.sampled_from(CRITICAL.tolist())))
stresses = st.floats(0, 1e4, width=32)

# --- masks --------------------------------------------------------------------------------------------------------


@restraining
@given(s_norm=demands)
def test_mask_is_exactly_zero_where_no_reserve_is_left(restrain, s_norm):
    assert not restrain(s_norm)[s_norm >= 1.0].any()


@restraining
@given(s_norm=demands)
def test_mask_lies_between_zero_and_one_and_never_rises_with_demand(restrain, s_norm):
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        values = restrain(np.sort(s_norm))
    assert np.all((values >= 0.0) & (values <= 1.0))
    assert np.all(np.diff(values) <= 0.0)


@restraining
def test_mask_is_one_at_rest(restrain):
    assert restrain(field(0.0)).tolist() == [1.0]


@restraining
def test_mask_is_of_four_bytes_and_leaves_the_demand_alone(restrain):
    s_norm = CRITICAL.copy()
    assert restrain(s_norm).dtype == np.float32
    assert np.array_equal(s_norm, CRITICAL)


@restraining
def test_a_demand_that_is_not_a_number_frees_nothing(restrain):
    assert restrain(field(np.nan, 0.0)).tolist() == [0.0, 1.0]


def test_linear_mask_is_what_is_left_of_the_reserve():
    assert linear(field(0.25, 0.75)).tolist() == [0.75, 0.25]


def test_linear_mask_is_clamped_on_both_sides():
    assert linear(field(-0.25, 1.25)).tolist() == [1.0, 0.0]


@given(s_norm=demands)
def test_exponential_mask_follows_its_formula_below_one(s_norm):
    inside = s_norm[s_norm < 1.0].astype(np.float64)
    np.testing.assert_allclose(exponential(s_norm)[s_norm < 1.0], np.exp(-inside / (1.0 - inside)), rtol=1e-6, atol=1e-37)


def test_exponential_mask_has_its_known_values():
    assert exponential(field(0.5, 2 / 3, 0.75)) == pytest.approx(np.exp([-1.0, -2.0, -3.0]), rel=1e-6)


def test_frozen_mask_is_a_switch():
    assert frozen(CRITICAL).tolist() == [1, 1, 1, 1, 0, 0, 0, 0]


@given(s_norm=demands)
def test_exponential_restrains_at_least_as_much_as_linear_and_frozen_least(s_norm):
    """1 − 1/x ≤ ln x with x = 1 − s gives exp(−s / (1 − s)) ≤ 1 − s."""
    assert np.all(exponential(s_norm) <= linear(s_norm) * np.float32(1 + 1e-6))
    assert np.all(linear(s_norm) <= frozen(s_norm))


def test_freestyle_is_restrained_nowhere():
    assert unrestrained(CRITICAL).tolist() == [1.0] * len(CRITICAL)


@pytest.mark.parametrize(("control", "function"), [*zip(CONTROLS, [linear, exponential, frozen, unrestrained], strict=True)])
def test_a_control_is_found_by_its_name(control, function):
    assert np.array_equal(mask(CRITICAL, control), function(CRITICAL))


def test_every_control_a_recipe_may_name_has_a_mask():
    assert set(MASKS) == set(CONTROLS)


def test_an_unknown_control_is_refused_with_the_nearest():
    with pytest.raises(BadInput, match="unknown control 'exponentail': did you mean 'exponential'"):
        mask(CRITICAL, "exponentail")


# --- demand ---------------------------------------------------------------------------------------------------------

Y = PLA.yield_strength


def measured(surface, contact=0.0, p99=0.0):
    peak = max(surface, contact)
    return Measures(peak=peak, surface=surface, contact=contact, p999=peak, p99=p99, maximum=2 * peak, where=(0.0, 0.0, 0.0), volume=1.0)


def simulated(stress, *, tilted=None, envelope=None, p99=15.0, contact=0.0):
    """A simulation with these fields; its measures are their maxima."""
    nothing = np.zeros(len(stress))
    return Simulation(
        displacement=nothing, stress=stress, envelope=nothing if envelope is None else envelope, probability=nothing, contact=nothing > 0,
        as_placed=measured(float(stress.max()), contact),
        overall=None if envelope is None else measured(float(envelope.max()), p99=p99),
        tilted=None if tilted is None else measured(float(tilted.max())), tilted_stress=nothing if tilted is None else tilted,
        backed_off=0.0, deviation=0.0, time_step=1e-4, steps=10, added_mass=0.0,
    )  # fmt: skip


def demanded(stress, original, normalisation):
    """Demand of the part as placed alone."""
    return demand(simulated(stress), simulated(original), PLA, normalisation)


def test_headroom_is_the_share_of_the_reserve_used_up():
    original, limit = field(20.0, 20.0, 40.0, 100.0, 100.0), field(45.6, 45.6, 50.0, 125.0, 125.0)
    stress = field(32.8, 45.6, 45.0, 106.25, 150.0)  # reserves of 25.6, 25.6, 10, 25 and 25 MPa
    assert headroom(stress, original, limit) == pytest.approx([0.5, 1.0, 0.5, 0.25, 2.0], rel=1e-6)


@given(baseline=arrays(np.float32, 20, elements=stresses))
def test_headroom_demands_nothing_of_the_unstylized_part(baseline):
    """Not even of a vertex that is above yield as it came: or the style could never start there."""
    original = simulated(baseline, tilted=2 * baseline, envelope=3 * baseline)
    assert not demand(original, original, PLA, "headroom").any()


@given(own=st.floats(0.5, 200.0, width=32), now=st.floats(0.5, 200.0, width=32))
def test_headroom_and_verdict_agree_whatever_the_original_bears(own, now):
    """A growth of a quarter was allowed to the mask where the verdict forbade it: from 36.5 MPa on."""
    original, styled = simulated(field(own)), simulated(field(now))
    fails = judge(styled, original, PLA, "robust").outcome == "FAILS"
    exhausted = demand(styled, original, PLA, "headroom")[0] > 1.0
    assert exhausted == fails


@given(surface=st.floats(1.0, 100.0), contact=st.floats(1.0, 100.0), now=stresses)
def test_where_the_verdict_fails_the_mask_closes(surface, contact, now):
    """A stress that is allowed at the contact, where the original bears as much, is not allowed where it is calm."""
    original = simulated(field(surface), contact=contact)
    styled = simulated(field(now))
    if judge(styled, original, PLA, "robust").outcome == "FAILS":
        assert demand(styled, original, PLA, "headroom")[0] >= 1.0


def test_the_rule_that_is_nearest_to_its_limit_demands():
    original = simulated(field(10.0, 10.0, 10.0), tilted=field(60.0, 10.0, 10.0), envelope=field(20.0, 20.0, 20.0), p99=20.0)
    styled = simulated(field(10.0, 27.8, 10.0), tilted=field(60.0, 10.0, 38.0), envelope=field(21.0, 20.0, 20.0), p99=20.0)
    nearly = UNHARMED * 60.0 - 10.0
    assert demand(styled, original, PLA, "headroom") == pytest.approx([0.5, 0.5, 28.0 / nearly], rel=1e-4)


def test_a_correction_is_asked_for_where_a_rule_fails_and_not_where_another_is_nearly_used_up():
    original = simulated(field(10.0, 10.0, 10.0), tilted=field(60.0, 10.0, 10.0), envelope=field(20.0, 20.0, 20.0), p99=20.0)
    styled = simulated(field(10.0, 50.0, 10.0), tilted=field(60.0, 10.0, 38.0), envelope=field(21.9, 20.0, 20.0), p99=20.0)
    verdict = judge(styled, original, PLA, "robust")
    assert verdict.as_placed.outcome == "FAILS"
    everything, only_what_fails = (demand(styled, original, PLA, "headroom", failing) for failing in (None, verdict))
    assert only_what_fails[1] == everything[1] > 1.0
    assert np.all(everything[[0, 2]] > 0.4)
    assert not only_what_fails[[0, 2]].any()
    viable = judge(original, original, PLA, "robust")
    assert np.array_equal(demand(styled, original, PLA, "headroom", viable), everything)


@pytest.mark.parametrize(("tilted", "of_the_load", "expected"), [(10.0, 20.0, True), (10.0, 50.0, False), (60.0, 50.0, True)])
def test_a_part_fails_by_a_landing_unless_it_is_by_a_load_alone(tilted, of_the_load, expected):
    original = simulated(field(10.0, 10.0), tilted=field(10.0, 10.0))
    load = LoadResult(name="hung", peak=of_the_load, where=(0.0, 0.0, 0.0), deflection=0.1)
    styled = replace(simulated(field(10.0, 50.0), tilted=field(10.0, tilted)), loaded=(load,))
    assert landed(styled, judge(styled, original, PLA, "robust")) is expected


def under_load(dropped, load):
    """A part with these fields in the drop and under a load."""
    one = measured(float(load.max()), 0.0)
    told = LoadResult(name="hung", peak=one.peak, where=one.where, deflection=0.1, measures=one)
    drop = simulated(dropped)
    return replace(
        drop, stress=np.maximum(dropped, load), as_placed=drop.as_placed.or_worse(one), loaded=(told,),
        dropped=drop.as_placed, dropped_stress=dropped, loaded_stress=load[None],
    )  # fmt: skip


def test_an_overload_under_a_load_alone_is_demanded_of_whatever_the_original_bears_in_the_drop():
    original = under_load(field(2.0 * Y, 10.0), field(20.0, 10.0))
    styled = under_load(field(20.0, 10.0), field(1.7 * Y, 1.2 * Y))
    verdict = judge(styled, original, PLA, "robust")
    assert verdict.outcome == "FAILS"
    assert not landed(styled, verdict)
    for failing in (None, verdict):
        assert np.all(demand(styled, original, PLA, "headroom", failing) > 1.0)
    assert not demand(original, original, PLA, "headroom").any()


def test_a_landing_fails_a_part_whose_larger_stress_under_a_load_is_the_originals_own():
    original, styled = under_load(field(10.0), field(3.0 * Y)), under_load(field(1.5 * Y), field(2.0 * Y))
    verdict = judge(styled, original, PLA, "robust")
    assert (verdict.outcome, styled.governing) == ("FAILS", "hung")
    assert landed(styled, verdict)


def test_an_envelope_of_fewer_orientations_demands_nothing():
    """A part dropped as placed only is not compared with an original dropped in all orientations."""
    original = simulated(field(10.0), envelope=field(20.0))
    assert not demand(simulated(field(10.0)), original, PLA, "headroom").any()


def test_limits_are_the_yield_strength_or_what_the_original_reaches():
    calm, over = Limits.of(simulated(field(10.0)), PLA), Limits.of(simulated(field(60.0), tilted=field(80.0), contact=30.0), PLA)
    assert (*calm.drop, calm.tilted, calm.envelope) == (Y, Y, np.inf, 0.0)
    assert (*over.drop, over.tilted) == pytest.approx((60.0, Y, UNHARMED * 80.0))


def test_own_max_compares_with_the_largest_unstylized_stress_anywhere():
    assert demanded(field(20.0, 50.0), field(10.0, 40.0), "own_max").tolist() == [0.5, 1.25]
    assert demanded(field(0.25), field(0.5), "own_max").tolist() == [0.5]


@given(stress=arrays(np.float32, 20, elements=stresses), baseline=arrays(np.float32, 20, elements=st.floats(2**-10, 1e4, width=32)))
def test_frozen_with_own_max_is_the_published_rule(stress, baseline):
    """Selectively frozen: 0 where s_v ≥ max(s of M_0), else 1 (Faruqi et al. 2025, §4.2)."""
    published = np.where(stress >= baseline.max(), 0.0, 1.0)
    assert np.array_equal(mask(demanded(stress, baseline, "own_max"), "frozen"), published)


def test_own_max_of_an_unloaded_part_is_a_number():
    assert np.isfinite(demanded(field(1.0), field(0.0), "own_max")).all()


def test_sigma_c_compares_with_a_fifth_of_yield():
    assert demanded(field(4.56, 9.12, 45.6), field(1.0, 1.0, 1.0), "sigma_c") == pytest.approx([0.5, 1.0, 5.0])


def test_sigma_c_takes_the_safety_coefficient_of_the_material():
    stricter = msgspec.structs.replace(PLA, safety_coefficient=0.5)
    assert demand(simulated(field(22.8)), simulated(field(1.0)), stricter, "sigma_c") == pytest.approx([1.0])


def test_yield_compares_with_the_yield_strength():
    assert demanded(field(11.4, 45.6, 91.2), field(1.0, 1.0, 1.0), "yield") == pytest.approx([0.25, 1.0, 2.0])


@pytest.mark.parametrize("normalisation", ["own_max", "sigma_c", "yield"])
def test_published_normalisations_know_the_part_as_placed_alone(normalisation):
    original = simulated(field(10.0), tilted=field(10.0), envelope=field(10.0))
    styled = simulated(field(10.0), tilted=field(500.0), envelope=field(500.0))
    assert np.array_equal(demand(styled, original, PLA, normalisation), demanded(field(10.0), field(10.0), normalisation))


@pytest.mark.parametrize("normalisation", NORMALISATIONS)
@given(stress=arrays(np.float32, 20, elements=stresses), baseline=arrays(np.float32, 20, elements=stresses))
def test_demand_is_finite_and_never_negative(normalisation, stress, baseline):
    found = demanded(stress, baseline, normalisation)
    assert found.dtype == np.float32
    assert np.all(np.isfinite(found) & (found >= 0.0))


def test_an_unknown_normalisation_is_refused_with_the_nearest():
    with pytest.raises(BadInput, match="unknown normalisation 'headrom': did you mean 'headroom'"):
        normalised(field(1.0), field(1.0), field(1.0), 1.0, PLA, "headrom")


@pytest.mark.parametrize("control", ["linear", "exponential", "frozen"])
def test_the_threshold_is_the_demand_at_which_movement_ends(control):
    """exp(−½ / (1 − ½)) = exp(−1) halfway there, whatever the threshold."""
    found = mask(field(0.0, 0.2, 0.39, 0.41), control, 0.4)
    assert found[0] == 1.0
    assert found[1] == pytest.approx({"linear": 0.5, "exponential": np.exp(-1.0), "frozen": 1.0}[control])
    assert found[2] > 0.0
    assert found[3] == 0.0


def test_a_threshold_of_one_changes_nothing():
    demands = field(0.0, 0.3, 0.999, 1.0, 2.0)
    assert np.array_equal(mask(demands, "exponential", 1.0), exponential(demands))
