"""From stress to restraint: demand on hand-computed figures, masks with their exact limits."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mechstyle.errors import BadInput
from mechstyle.loop.control import MASKS, YIELDED, demand, exponential, frozen, headroom, linear, mask, normalised, overload, utilisation
from mechstyle.loop.correction import AIM
from mechstyle.records import CONTROLS, NORMALISATIONS, Recipe, Simulation
from mechstyle.records.material import LIBRARY
from support.records import landing, load_result, load_row, published_row, row

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
    assert MASKS["none"](CRITICAL).tolist() == [1.0] * len(CRITICAL)


@pytest.mark.parametrize(("control", "function"), [*zip(CONTROLS, [linear, exponential, frozen, MASKS["none"]], strict=True)])
def test_a_control_is_found_by_its_name(control, function):
    assert np.array_equal(mask(CRITICAL, control), function(CRITICAL))


def test_every_control_a_recipe_may_name_has_a_mask():
    assert set(MASKS) == set(CONTROLS)


def test_an_unknown_control_is_refused_with_the_nearest():
    with pytest.raises(BadInput, match="unknown control 'exponentail': did you mean 'exponential'"):
        mask(CRITICAL, "exponentail")


# --- utilisation ----------------------------------------------------------------------------------------------------

Y, BREAKS = PLA.yield_strength, PLA.elongation


def test_utilisation_is_the_stress_over_the_strength_and_beyond_it_the_strain_over_that_at_break():
    used = utilisation(field(0.5 * Y, Y, 3.0 * Y, Y, Y), field(0.0, 0.0, 0.0, 0.5 * BREAKS, 2.0 * BREAKS), PLA)
    assert used == pytest.approx([0.5, 1.0, 1.0, 1.5, 3.0])


@given(stress=st.floats(0, 100, width=32), strain=st.floats(0, 1, width=32))
def test_it_is_above_one_exactly_where_a_place_has_yielded(stress, strain):
    assert (utilisation(field(stress), field(strain), PLA)[0] > 1.0) == (strain > YIELDED)
    assert YIELDED == 0.002, "R_p0.2"


# --- demand ---------------------------------------------------------------------------------------------------------


def asked(**settings):
    return Recipe.of(surface="s", tetrahedra="t", prompt="brick", **{"material": PLA, **settings})


def simulated(stress, tilted=None, hung=None, strain=None, strain_tilted=None, strain_hung=None):
    """A simulation with these fields of stress [MPa] and plastic strain, flat, tilted and under a load."""
    nothing = np.zeros(len(stress), np.float32)
    landed = [(stress, strain)] + ([] if tilted is None else [(tilted, strain_tilted)])
    loaded = [] if hung is None else [(hung, strain_hung)]
    fields = {
        f"{kind}_{what}": np.stack([nothing if one[number] is None else one[number] for one in found]) if found else ()
        for kind, found in (("landing", landed), ("load", loaded))
        for number, what in enumerate(("stress", "strain"))
    }
    names = (("flat", "flat"), ("tilted", "nearly flat"))[: len(landed)]
    return Simulation(
        displacement=nothing, contact=nothing > 0, landings=tuple(landing(name, way=way) for name, way in names),
        loads=(load_result("hung"),)[: len(loaded)], **fields,
    )  # fmt: skip


def demanded(stress, original, normalisation):
    """Demand of the flat landing alone."""
    return demand(simulated(stress), simulated(original), asked(normalisation=normalisation))


def test_headroom_is_the_share_of_the_reserve_used_up():
    original, limit = field(20.0, 20.0, 40.0, 100.0, 100.0), field(45.6, 45.6, 50.0, 125.0, 125.0)
    stress = field(32.8, 45.6, 45.0, 106.25, 150.0)  # reserves of 25.6, 25.6, 10, 25 and 25 MPa
    assert headroom(stress, original, limit) == pytest.approx([0.5, 1.0, 0.5, 0.25, 2.0], rel=1e-6)


yielding = arrays(np.float32, 20, elements=st.floats(0, 0.125, width=32))


@given(baseline=arrays(np.float32, 20, elements=stresses), strain=yielding)
def test_headroom_demands_nothing_of_the_unstylized_part(baseline, strain):
    """Not even of a vertex that yields without a style: or the style could never start there."""
    original = simulated(baseline, 2 * baseline, 3 * baseline, strain, strain, strain)
    assert not demand(original, original, asked()).any()


@given(strain=yielding, own=yielding, test=st.sampled_from(["strain", "strain_tilted", "strain_hung"]))
def test_whatever_yields_more_than_the_original_does_in_that_test_has_no_reserve_left(strain, own, test):
    calm = np.full(20, 0.5 * Y, np.float32)
    styled, original = (simulated(calm, calm, calm, **{test: one}) for one in (strain, own))
    held = mask(demand(styled, original, asked()), "exponential")
    assert not held[(strain > YIELDED) & (strain > own)].any()
    assert np.all(held[strain <= YIELDED] > 0.0)


def test_the_test_that_is_nearest_to_its_limit_demands():
    original = simulated(field(0.0, 0.5 * Y, 0.0), tilted=field(0.0, 0.0, 0.5 * Y), hung=field(0.5 * Y, 0.0, 0.0))
    styled = simulated(field(0.1 * Y, 0.75 * Y, 0.0), tilted=field(0.2 * Y, 0.1 * Y, 0.9 * Y), hung=field(0.6 * Y, 0.0, 0.0))
    assert demand(styled, original, asked()) == pytest.approx([0.2, 0.5, 0.8], rel=1e-5)


def test_what_the_original_bears_in_a_test_excuses_no_other():
    original = simulated(field(Y), tilted=field(20.0), hung=field(20.0), strain=field(0.02))
    for test in ("strain_tilted", "strain_hung"):
        styled = simulated(field(Y), tilted=field(Y), hung=field(Y), strain=field(0.02), **{test: field(0.01)})
        assert demand(styled, original, asked())[0] > 1.0


def test_a_landing_the_original_was_not_dropped_in_has_all_its_reserve_to_lose():
    assert demand(simulated(field(10.0), tilted=field(0.5 * Y)), simulated(field(10.0)), asked()) == pytest.approx([0.5])


# --- overload -------------------------------------------------------------------------------------------------------

FLAT, TILTED, HUNG = row(0.3), row(0.3, test="nearly flat", landing="tilted"), load_row(0.3, load="hung")


def test_overload_is_of_the_tests_to_be_met_and_of_no_other():
    styled = simulated(*(field(Y, Y, Y),) * 3, field(0.02, 0.0, 0.0), field(0.0, 0.02, 0.0), field(0.0, 0.0, 0.02))
    found = [overload(styled, [one], PLA) for one in (FLAT, TILTED, HUNG)]
    assert [int(used.argmax()) for used in found] == [0, 1, 2]
    assert all(np.sum(used > AIM) == 1 for used in found)
    assert np.array_equal(overload(styled, [FLAT, HUNG], PLA), np.maximum(found[0], found[2]))
    assert not overload(styled, [], PLA).any()


def test_the_hinge_is_lowered_and_not_the_scratch_beside_it():
    styled = simulated(field(Y, Y, Y), strain=field(0.04, 0.004, 0.0))
    hinge, scratch, rest = overload(styled, [row(0.3, allowed=0.2)], PLA)
    assert (hinge, scratch) == (pytest.approx(1.5), pytest.approx(1.05))
    assert rest <= AIM


@pytest.mark.parametrize(("bent", "most"), [(0.2001, 1.1), (0.3, 1.5), (0.6, 2.0)])
def test_the_more_a_test_is_beyond_its_limit_the_more_is_taken_within_bounds(bent, most):
    assert overload(simulated(field(Y), strain=field(0.03)), [row(bent, allowed=0.2)], PLA) == pytest.approx([most])
    gone = load_row(2.0, load="hung", collapses=True, allowed=0.2)
    assert overload(simulated(field(Y), hung=field(Y), strain_hung=field(0.03)), [gone], PLA) == pytest.approx([2.0])


def test_where_nothing_at_the_surface_yields_the_highest_stress_is_the_place():
    used = overload(simulated(field(0.2 * Y, 0.8 * Y)), [FLAT], PLA)
    assert used.argmax() == 1
    assert used.max() <= AIM


def test_the_published_rule_is_met_at_the_surface():
    assert overload(simulated(field(1.2 * Y, 0.5 * Y)), [published_row()], PLA) == pytest.approx([1.2, 0.5])


# --- normalisations -------------------------------------------------------------------------------------------------


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
    assert demand(simulated(field(22.8)), simulated(field(1.0)), asked(material=stricter, normalisation="sigma_c")) == pytest.approx([1.0])


@pytest.mark.parametrize("normalisation", ["own_max", "sigma_c"])
def test_published_normalisations_know_the_flat_landing_alone(normalisation):
    original = simulated(field(10.0), field(10.0))
    styled = simulated(field(10.0), field(500.0))
    found = demand(styled, original, asked(normalisation=normalisation))
    assert np.array_equal(found, demanded(field(10.0), field(10.0), normalisation))


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
