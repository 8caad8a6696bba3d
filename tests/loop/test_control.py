"""From stress to restraint: demand on hand-computed figures, masks with their exact limits."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mechstyle.errors import BadInput
from mechstyle.loop.control import MASKS, demand, exponential, frozen, headroom, linear, mask, normalised, utilisation
from mechstyle.records import CONTROLS, NORMALISATIONS, Landing, LoadResult, Recipe, Simulation, judge
from mechstyle.records.material import LIBRARY
from mechstyle.records.verdict import NO_WORSE, REPEATABILITY

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


# --- demand ---------------------------------------------------------------------------------------------------------

Y = PLA.yield_strength
FALL = 1500.0


def asked(**settings):
    return Recipe.of(surface="s", tetrahedra="t", prompt="brick", **{"material": PLA, **settings})


def simulated(stress, nearly=(), any_landing=(), loads=None):
    """A simulation with these fields, one for each landing and load; σ_V of each is the largest value of its field."""
    fields = [("flat", "flat", stress), *((f"nearly {n}", "nearly flat", one) for n, one in enumerate(nearly))]
    fields += [(f"any {n}", "any landing", one) for n, one in enumerate(any_landing)]
    landings = tuple(
        Landing(
            name=name, way=way, normal=(0.0, 0.0, 1.0), stress=float(one.max()), maximum=2.0 * float(one.max()), where=(0.0, 0.0, 0.0),
            fall=FALL, critical_height=FALL * (Y / max(float(one.max()), 1e-3)) ** 2,
        )
        for name, way, one in fields
    )  # fmt: skip
    under = tuple(
        LoadResult(name=name, stress=float(one.max()), maximum=2.0 * float(one.max()), where=(0.0, 0.0, 0.0), deflection=0.1)
        for name, one in (loads or {}).items()
    )
    return Simulation(
        displacement=np.zeros(len(stress)), contact=np.zeros(len(stress), bool), landings=landings,
        landing_stress=np.stack([one for *_, one in fields]), loads=under,
        load_stress=np.stack(list(loads.values())) if loads else np.zeros((0, len(stress))),
    )  # fmt: skip


def demanded(stress, original, normalisation):
    """Demand of the flat landing alone."""
    return demand(simulated(stress), simulated(original), asked(normalisation=normalisation))


def judged(styled, original=None, **settings):
    return judge(styled, original, asked(**settings))


def test_headroom_is_the_share_of_the_reserve_used_up():
    original, limit = field(20.0, 20.0, 40.0, 100.0, 100.0), field(45.6, 45.6, 50.0, 125.0, 125.0)
    stress = field(32.8, 45.6, 45.0, 106.25, 150.0)  # reserves of 25.6, 25.6, 10, 25 and 25 MPa
    assert headroom(stress, original, limit) == pytest.approx([0.5, 1.0, 0.5, 0.25, 2.0], rel=1e-6)


@given(baseline=arrays(np.float32, 20, elements=stresses))
def test_headroom_demands_nothing_of_the_unstylized_part(baseline):
    """Not even of a vertex that is above yield without a style: or the style could never start there."""
    original = simulated(baseline, nearly=(2 * baseline,), loads={"hung": 3 * baseline})
    assert not demand(original, original, asked(normalisation="headroom")).any()


figures = st.floats(1.0, 200.0, width=32)


@given(own=figures, now=figures, nearly_own=figures, nearly_now=figures, load_own=figures, load_now=figures)
def test_headroom_is_exhausted_exactly_where_the_verdict_fails(own, now, nearly_own, nearly_now, load_own, load_now):
    """One vertex, whose stress is σ_V in every test: mask and verdict have one limit."""
    original = simulated(field(own), nearly=(field(nearly_own),), loads={"hung": field(load_own)})
    styled = simulated(field(now), nearly=(field(nearly_now),), loads={"hung": field(load_now)})
    tests = ((now, own), (nearly_now, nearly_own), (load_now, load_own))
    for stress, theirs in tests:
        for limit in (Y, theirs / np.sqrt(NO_WORSE), theirs / NO_WORSE):
            if abs(stress / limit - 1.0) < 1e-5:
                return  # within single precision of a limit
    exhausted = demand(styled, original, asked(normalisation="headroom"))[0] > 1.0
    assert exhausted == (judged(styled, original).outcome == "FAILS")


def test_the_test_that_is_nearest_to_its_limit_demands():
    original = simulated(field(10.0, 10.0, 10.0), nearly=(field(60.0, 10.0, 10.0),), loads={"hung": field(5.6, 5.6, 5.6)})
    styled = simulated(field(10.0, 27.8, 10.0), nearly=(field(60.0, 10.0, 38.0),), loads={"hung": field(15.6, 5.6, 5.6)})
    nearly = 60.0 / np.sqrt(NO_WORSE) - 10.0
    assert demand(styled, original, asked(normalisation="headroom")) == pytest.approx([0.25, 0.5, 28.0 / nearly], rel=1e-4)


def test_any_landing_and_a_way_the_original_was_not_dropped_demand_nothing():
    original = simulated(field(10.0), any_landing=(field(20.0),))
    styled = simulated(field(10.0), nearly=(field(500.0),), any_landing=(field(500.0),))
    assert not demand(styled, original, asked(normalisation="headroom")).any()


def test_what_the_original_bears_in_a_landing_excuses_no_load():
    original = simulated(field(2.0 * Y), loads={"hung": field(20.0)})
    styled = simulated(field(2.0 * Y), loads={"hung": field(1.2 * Y)})
    assert demand(styled, original, asked(normalisation="headroom"))[0] > 1.0


# --- utilisation ----------------------------------------------------------------------------------------------------


@given(own=figures, now=figures, nearly_own=figures, nearly_now=st.lists(figures, min_size=1, max_size=3), load_now=figures)
def test_utilisation_reaches_one_somewhere_exactly_where_a_row_does_not_pass_for_sure(own, now, nearly_own, nearly_now, load_now):
    """σ_V is in these fields, so the place that is lowered is the place that is judged."""
    original = simulated(field(own), nearly=[field(nearly_own)] * len(nearly_now), loads={"hung": field(20.0)})
    styled = simulated(field(now), nearly=[field(one) for one in nearly_now], loads={"hung": field(load_now)})
    for row in judged(styled, original).rows:
        if not row.decides or abs(row.stress / row.limit * (1.0 + REPEATABILITY[row.test]) - 1.0) < 1e-5:
            continue
        reached = bool(utilisation(styled, [row]).max() >= 1.0)
        assert reached == (row.outcome == "FAILS" or not row.sure)
        assert reached or row.outcome != "FAILS"


def test_utilisation_is_that_of_the_tests_to_be_met_and_of_no_other():
    styled = simulated(field(1.5 * Y, 10.0, 10.0), nearly=(field(10.0, 80.0, 10.0),), loads={"hung": field(10.0, 10.0, 2.0 * Y)})
    rows = {row.test: row for row in judged(styled, simulated(field(10.0, 1.0, 1.0), nearly=(field(9.0, 1.0, 1.0),))).rows}
    found = {test: utilisation(styled, [rows[test]]) for test in ("flat", "nearly flat", "load")}
    assert [int(used.argmax()) for used in found.values()] == [0, 1, 2]
    assert all(np.sum(used > 1.0) == 1 for used in found.values())
    assert np.array_equal(utilisation(styled, [rows["flat"], rows["load"]]), np.maximum(found["flat"], found["load"]))
    assert not utilisation(styled, []).any()


def test_every_landing_of_a_kind_beyond_its_limit_is_to_be_met_not_the_hardest_alone():
    styled = simulated(field(10.0, 10.0, 10.0), nearly=(field(90.0, 1.0, 1.0), field(1.0, 80.0, 1.0), field(1.0, 1.0, 40.0)))
    row = judged(styled, simulated(field(10.0, 1.0, 1.0), nearly=[field(30.0, 1.0, 1.0)] * 3)).row("nearly flat")
    assert (utilisation(styled, [row]) > 1.0).tolist() == [True, True, False]


def test_the_published_rule_is_met_at_the_surface():
    styled = simulated(field(1.2 * Y, 0.5 * Y))
    row = judged(styled, criterion="paper").row("published rule")
    assert utilisation(styled, [row]) == pytest.approx([1.2, 0.5])


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
    original = simulated(field(10.0), nearly=(field(10.0),))
    styled = simulated(field(10.0), nearly=(field(500.0),))
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
