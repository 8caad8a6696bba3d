"""Verdicts on measures whose answers are known, rule by rule, and the words that tell them."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechstyle.errors import BadInput
from mechstyle.fea.verdict import input_warning, judge
from mechstyle.records import LoadResult, Measures, Simulation, Verdict
from mechstyle.records.material import LIBRARY

PLA, PETG = LIBRARY["PLA"], LIBRARY["PETG"]
Y = PLA.yield_strength


def measured(surface=20.0, contact=0.0, p999=20.0, p99=15.0, maximum=30.0):
    peak = max(surface, contact)
    where = (1.0, 2.0, 3.0)
    return Measures(peak=peak, surface=surface, contact=contact, p999=p999, p99=p99, maximum=maximum, where=where, volume=100.0)


def simulation(surface=20.0, contact=0.0, overall=10.0, tilted=None, failure="", **measures):
    """A simulation with the given measures as placed, surface stress tilted and 99th percentile over all (None: not dropped so)."""
    as_placed = measured(surface, contact, **measures)
    one = np.zeros(1)
    return Simulation(
        displacement=one, stress=one, envelope=one, probability=one, contact=one > 0, as_placed=as_placed,
        overall=None if overall is None else msgspec.structs.replace(as_placed, p99=overall),
        tilted=None if tilted is None else measured(tilted),
        backed_off=0.0, deviation=0.0, time_step=1e-4, steps=100, added_mass=0.0, failure=failure,
    )  # fmt: skip


def test_what_fails_clearly_is_not_called_marginal_for_another_rule_that_is_close():
    found = judge(simulation(2.0 * Y, overall=11.0), simulation(overall=10.0), PLA, "robust")
    assert (found.outcome, found.all_orientations.marginal, found.marginal) == ("FAILS", True, False)
    assert found.words.startswith("FAILS: ")
    close = judge(simulation(1.01 * Y, overall=11.0), simulation(overall=10.0), PLA, "robust")
    assert (close.outcome, close.marginal) == ("FAILS", True)


def test_each_stress_is_told_where_it_is_not_where_a_larger_one_of_another_kind_is():
    """A contact bears more than a surface that is judged: the surface's place is the one to look at."""
    both = msgspec.structs.replace(measured(0.95 * Y, 0.99 * Y), surface_where=(9.0, 0.0, 0.0), contact_where=(1.0, 2.0, 3.0))
    nearly = msgspec.structs.replace(measured(90.0, 95.0), surface_where=(8.0, 0.0, 0.0))
    own = simulation(0.5 * Y, 0.99 * Y, overall=None, tilted=10.0)
    part = replace(simulation(overall=None), as_placed=both, tilted=nearly)
    own = replace(own, as_placed=msgspec.structs.replace(own.as_placed, contact=1.2 * Y, peak=1.2 * Y))
    words = judge(part, own, PLA, "robust").words
    assert f"its surface stress is {0.95 * Y:.1f} MPa at (9.0, 0.0, 0.0) mm" in words
    assert "90.0 MPa at (8.0, 0.0, 0.0) mm" in words


# --- as placed --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("surface", "own", "outcome", "marginal"),
    [
        (20.0, 10.0, "VIABLE", False),
        (43.0, 10.0, "VIABLE", False),  # 0.94 of the yield strength
        (44.0, 10.0, "VIABLE", True),
        (Y, 10.0, "VIABLE", True),
        (46.0, 10.0, "FAILS", True),
        (48.5, 10.0, "FAILS", False),  # 1.06 of it
        (60.0, 60.0, "VIABLE", True),  # what the original reaches is the limit
        (61.0, 60.0, "FAILS", True),
        (80.0, 60.0, "FAILS", False),
    ],
)
def test_the_surface_is_compared_with_yield_or_what_the_original_reaches(surface, own, outcome, marginal):
    verdict = judge(simulation(surface, overall=None), simulation(own), PLA, "robust")
    assert (verdict.as_placed.outcome, verdict.as_placed.marginal) == (outcome, marginal)
    assert (verdict.outcome, verdict.marginal) == (outcome, marginal)
    assert verdict.as_placed.limit == max(Y, own)
    assert verdict.as_placed.rule.endswith("≤ yield strength" if own < Y else "≤ the original's own")
    assert verdict.all_orientations is None
    assert ("MARGINAL" in verdict.words) == marginal


def test_a_contact_that_the_original_has_allows_no_more_on_the_surface():
    """One limit for both, the larger, would let a calm wall rise to what the original bears where it touches the floor."""
    original = simulation(20.0, contact=80.0)
    assert judge(simulation(60.0, contact=80.0), original, PLA, "robust").outcome == "FAILS"
    assert judge(simulation(20.0, contact=80.0), original, PLA, "robust").outcome == "VIABLE"
    assert judge(simulation(80.0), simulation(80.0), PLA, "robust").outcome == "VIABLE"
    assert judge(simulation(20.0, contact=60.0), simulation(80.0), PLA, "robust").outcome == "FAILS"


def test_the_average_around_a_contact_depends_more_on_the_mesh():
    assert judge(simulation(0.0, contact=40.0, overall=None), simulation(), PLA, "robust").marginal
    assert not judge(simulation(40.0, overall=None), simulation(), PLA, "robust").marginal


def test_the_edge_of_the_band_belongs_to_it():
    """5 % of a limit whose share is exact."""
    material = msgspec.structs.replace(PLA, yield_strength=100.0)
    for surface, marginal in ((94.9, False), (95.0, True), (105.0, True), (105.1, False)):
        assert judge(simulation(surface, overall=None), simulation(), material, "robust").as_placed.marginal == marginal


# --- tilted -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tilted", "own", "outcome"), [(45.0, 20.0, "VIABLE"), (50.0, 20.0, "FAILS"), (109.0, 100.0, "VIABLE"), (111.0, 100.0, "FAILS")]
)
def test_a_tilted_landing_may_reach_yield_or_a_tenth_more_than_the_original_there(tilted, own, outcome):
    verdict = judge(simulation(tilted=tilted), simulation(tilted=own), PLA, "robust")
    assert verdict.tilted is not None
    assert (verdict.tilted.outcome, verdict.outcome) == (outcome, outcome)


def test_a_part_that_only_holds_when_it_lands_exactly_flat_fails():
    flat = judge(simulation(20.0), simulation(20.0), PLA, "robust")
    tilted = judge(simulation(20.0, tilted=90.0), simulation(20.0, tilted=30.0), PLA, "robust")
    assert (flat.outcome, tilted.outcome) == ("VIABLE", "FAILS")
    assert "tilted by a few degrees 90.0 MPa" in tilted.words


def test_tilted_landings_without_an_original_to_compare_with_are_not_judged():
    assert judge(simulation(tilted=90.0), simulation(), PLA, "robust").tilted is None
    assert judge(simulation(), simulation(tilted=90.0), PLA, "robust").tilted is None


# --- all orientations, paper ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("overall", "outcome", "marginal"),
    [
        (10.0, "VIABLE", False),
        (10.4, "VIABLE", False),
        (10.5, "VIABLE", True),
        (11.0, "VIABLE", True),
        (11.1, "FAILS", True),
        (11.6, "FAILS", False),
    ],
)
def test_all_orientations_compares_with_the_original(overall, outcome, marginal):
    verdict = judge(simulation(overall=overall), simulation(overall=10.0), PLA, "robust")
    spread = verdict.all_orientations
    assert spread is not None
    assert (spread.outcome, spread.marginal, spread.unit) == (outcome, marginal, "x the original")
    assert spread.value == pytest.approx(overall / 10.0)
    assert verdict.outcome == outcome


@pytest.mark.parametrize(
    ("surface", "tilted", "overall", "worst"),
    [(20, 20, 10, "VIABLE"), (60, 20, 10, "FAILS"), (20, 60, 10, "FAILS"), (20, 20, 12, "FAILS"), (60, 60, 12, "FAILS")],
)
def test_robust_is_the_worst_of_all(surface, tilted, overall, worst):
    assert judge(simulation(surface, tilted=tilted, overall=overall), simulation(tilted=20.0), PLA, "robust").outcome == worst


def test_the_safety_factor_is_the_least_of_the_rules_that_count():
    """A part that fails in tilted landings does not show the comfortable factor of the one as placed."""
    verdict = judge(simulation(Y / 2, tilted=2 * Y, overall=10.0), simulation(tilted=20.0), PLA, "robust")
    assert verdict.as_placed.safety_factor == pytest.approx(2.0)
    assert verdict.safety_factor == pytest.approx(0.5)
    paper = judge(simulation(Y / 2, tilted=2 * Y, maximum=Y / 4), simulation(tilted=20.0), PLA, "paper")
    assert paper.safety_factor == pytest.approx(4.0)


def test_paper_is_the_literal_rule_alone():
    base = simulation()
    assert judge(simulation(60.0, maximum=45.0, overall=30.0), base, PLA, "paper").outcome == "VIABLE"
    fails = judge(simulation(20.0, maximum=83.0), base, PLA, "paper")
    assert fails.outcome == "FAILS"
    assert fails.deciding is fails.literal
    assert "largest element stress is 83.0 MPa" in fails.words
    assert judge(simulation(maximum=83.0), base, PLA, "robust").literal.outcome == "FAILS"


values = st.floats(0.1, 500.0)


@given(surface=values, contact=values, p999=values, overall=values, tilted=values)
def test_zero_displacement_is_viable_by_construction(surface, contact, p999, overall, tilted):
    base = simulation(surface, contact, overall, tilted, p999=p999)
    assert judge(base, base, PLA, "robust").outcome == "VIABLE"


# --- what is not known ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("criterion", ["robust", "paper"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("field", ["surface", "contact", "p999", "p99", "maximum", "overall", "tilted"])
def test_what_is_not_a_finite_number_is_unknown_never_viable(field, bad, criterion):
    whole = {"tilted": 20.0}
    for styled, base in (
        (simulation(**{**whole, field: bad}), simulation(**whole)),
        (simulation(**whole), simulation(**{**whole, field: bad})),
    ):
        verdict = judge(styled, base, PLA, criterion)
        assert verdict.outcome == verdict.as_placed.outcome == verdict.literal.outcome == "UNKNOWN"
        assert "not a finite number" in verdict.words
        for judgement in (verdict.as_placed, verdict.tilted, verdict.all_orientations, verdict.literal):
            assert (judgement.value, judgement.marginal) == (0.0, False)  # 0 stands for what is not known
        assert verdict.as_placed.limit == verdict.literal.limit == Y
        # Records travel as JSON, which knows no NaN.
        assert msgspec.json.decode(msgspec.json.encode(verdict), type=Verdict) == verdict


@pytest.mark.parametrize(("surface", "outcome", "marginal"), [(20.0, "VIABLE", True), (60.0, "FAILS", False)])
def test_what_tetrahedra_tell_that_do_not_carry_the_relief_is_not_sure_to_hold(surface, outcome, marginal):
    """The unsafe side: a hook's bricks read 43 MPa where 81 % of them were carried, and 50 where 92 % were."""
    found, baseline = simulation(surface), simulation()
    sure = judge(found, baseline, PLA, "robust")
    assert (sure.outcome, sure.marginal) == (outcome, False)
    for part, where in (({"carried": 0.81}, ""), ({"carried_base": 0.81}, " under the part")):
        verdict = judge(replace(found, **part), baseline, PLA, "robust")
        assert (verdict.outcome, verdict.marginal) == (outcome, marginal)
        assert (f"its tetrahedra carry only 81% of the relief{where}, and may hide stress" in verdict.words) is marginal


@pytest.mark.parametrize(
    "shape",
    [{"volume_error": 0.2}, {"volume_error": -0.04}, {"volume_error": np.nan}, {"carried": np.nan}, {"carried_base": np.nan}],
)
def test_what_tetrahedra_tell_that_have_another_shape_is_not_sure_to_hold(shape):
    verdict = judge(replace(simulation(), **shape), simulation(), PLA, "robust")
    assert (verdict.outcome, verdict.marginal) == ("VIABLE", True)
    assert "its tetrahedra" in verdict.words


@pytest.mark.parametrize("surface", [0.0, 0.90, 0.94])
def test_a_contact_within_its_band_is_doubtful_however_near_the_surface_is_to_its_own(surface):
    """The unsafe side: a surface at 0.94 of the yield strength took away the warning of a contact at 0.93, whose band is wider."""
    verdict = judge(simulation(surface * Y, 0.93 * Y, overall=None), simulation(), PLA, "robust")
    assert (verdict.outcome, verdict.marginal) == ("VIABLE", True)
    assert f"the stress around the contact is {0.93 * Y:.1f} MPa" in verdict.words
    assert verdict.as_placed.value == max(surface, 0.93) * Y, "the safety factor is the least"


def test_a_failed_simulation_is_unknown_with_its_reason():
    reason = "the drop test is unstable in orientation 0 at 0.010 ms"
    verdict = judge(simulation(failure=reason), simulation(), PLA, "robust")
    assert verdict.outcome == "UNKNOWN"
    assert verdict.words == f"UNKNOWN: {reason}."
    verdict = judge(simulation(), simulation(failure=reason), PLA, "robust")
    assert verdict.outcome == "UNKNOWN"
    assert f"the original could not be simulated: {reason}" in verdict.words


def test_orientations_without_a_baseline_to_compare_with_are_unknown():
    assert judge(simulation(), simulation(overall=None), PLA, "robust").outcome == "UNKNOWN"
    assert judge(simulation(), simulation(overall=0.0), PLA, "robust").outcome == "UNKNOWN"


# --- words ------------------------------------------------------------------------------------------------------------


def test_words_hold_figures_place_limit_and_doubt():
    words = judge(simulation(47.0, overall=10.2, tilted=50.0), simulation(tilted=60.0), PLA, "robust").words
    assert words == (
        "FAILS, MARGINAL: dropped as placed its surface stress is 47.0 MPa at (1.0, 2.0, 3.0) mm, above (MARGINAL) the 45.6 MPa at which"
        f" {PLA.label} yields: the surface begins to yield there; tilted by a few degrees 50.0 MPa at (1.0, 2.0, 3.0) mm, within 66.0 MPa,"
        " 1.10 times the original's own 60.0 MPa; in all orientations 1.02 times the original's stress, within the limit of 1.10."
    )
    words = judge(simulation(50.0, overall=None), simulation(80.0), PLA, "robust").words
    assert "within the original's own 80.0 MPa, which itself exceeds the 45.6 MPa" in words


def test_an_original_below_the_yield_strength_is_not_said_to_exceed_it():
    words = judge(simulation(contact=60.0), simulation(contact=43.1), PLA, "robust").words
    assert "above 47.4 MPa, 1.10 times the original's own 43.1 MPa" in words
    assert "itself exceeds" not in words


def test_around_a_contact_the_limit_is_told_that_was_applied():
    """It was told as «48.1 MPa, within the original's own 47.9 MPa», which it is not: there a tenth more is let pass."""
    words = judge(simulation(contact=48.1), simulation(contact=47.9), PLA, "robust").words
    assert "48.1 MPa" in words
    assert "within (MARGINAL) 52.7 MPa, 1.10 times the original's own 47.9 MPa, which itself exceeds the 45.6 MPa" in words


def test_a_wall_is_said_to_yield_through_only_where_the_material_is_ductile():
    brittle, ductile = (judge(simulation(90.0), simulation(), material, "robust").words for material in (PLA, PETG))
    assert "yields through" not in brittle
    assert f"a wall yields through at {1.5 * PETG.yield_strength:.1f} MPa" in ductile
    assert "yields through" not in judge(simulation(0.0, contact=90.0), simulation(), PETG, "robust").words, "no wall bends at a contact"


def test_an_original_that_is_about_to_yield_is_named_once():
    near = judge(simulation(44.5, overall=None), simulation(44.0), PLA, "robust").words
    assert near.startswith("VIABLE, MARGINAL")
    assert "as that of the original, 44.0 MPa" in near
    assert "as that of the original" not in judge(simulation(44.5, overall=None), simulation(20.0), PLA, "robust").words


def test_words_name_the_load_that_governs():
    one = simulation(40.0)
    cases = (("hand", 40.0), ("shelf", 12.0))
    loaded = tuple(LoadResult(name=name, peak=peak, where=(0.0, 0.0, 0.0), deflection=0.1) for name, peak in cases)
    governed = judge(replace(one, loaded=loaded), simulation(), PLA, "robust")
    assert "under the load 'hand' its surface stress is 40.0 MPa at" in governed.words
    dropped = judge(replace(one, loaded=loaded[1:]), simulation(), PLA, "robust")
    assert "dropped as placed, which is worse than any load, its surface stress is 40.0 MPa" in dropped.words
    assert "dropped as placed or under its loads its largest element stress" in judge(replace(one, loaded=loaded), one, PLA, "paper").words
    weak = msgspec.structs.replace(PLA, yield_strength=30.0)
    assert "under the load 'hand', above" in input_warning(replace(one, loaded=loaded), weak)


def test_of_a_part_that_fails_it_is_told_that_its_original_is_in_the_band_itself():
    failing = judge(simulation(46.5, overall=None), simulation(45.0, overall=None), PLA, "robust").words
    assert "above (MARGINAL) the 45.6 MPa at which generic PLA yields, of which the original itself bears 45.0" in failing
    assert "of which the original" not in judge(simulation(46.5, overall=None), simulation(40.0, overall=None), PLA, "robust").words


def test_every_verdict_names_its_material():
    """Where 1.10 times a contact of the original below its strength is the limit, no strength was told and so no material."""
    own, part = (simulation(surface, contact=43.7, overall=None) for surface in (20.0, 21.0))
    for criterion in ("robust", "paper"):
        assert "generic PLA" in judge(part, own, PLA, criterion).words
    assert judge(part, own, PLA, "robust").words.endswith(" (generic PLA yields at 45.6 MPa).")


def loaded(part, **cases):
    """A part with these load cases besides its drop: surface stress and that around supports and loads of each."""
    results = {name: measured(*stress) for name, stress in cases.items()}
    told = tuple(LoadResult(name=name, peak=one.peak, where=one.where, deflection=0.1, measures=one) for name, one in results.items())
    largest = part.as_placed
    for one in results.values():
        largest = largest.or_worse(one)
    return replace(part, as_placed=largest, dropped=part.as_placed, loaded=told)


@pytest.mark.parametrize(("surface", "contact"), [(1.7 * Y, 0.0), (0.0, 1.9 * Y)])
def test_what_the_original_bears_in_the_drop_excuses_nothing_under_a_load(surface, contact):
    """The unsafe side: a part was VIABLE at 77.5 MPa under its load, where its original bore 20 and 91.2 only when it fell."""
    own = loaded(simulation(2.0 * Y, contact=2.0 * Y, overall=None), coat=(20.0, 20.0))
    part = loaded(simulation(20.0, overall=None), coat=(surface, contact))
    found = judge(part, own, PLA, "robust")
    assert (found.outcome, found.marginal, found.as_placed.limit) == ("FAILS", False, Y)
    assert found.words.startswith("FAILS: under the load 'coat' ")
    assert found.as_placed.rule.endswith("under the load 'coat' ≤ yield strength")
    assert judge(loaded(simulation(1.9 * Y, contact=1.9 * Y, overall=None), coat=(20.0, 20.0)), own, PLA, "robust").viable


def test_a_verdict_knows_the_limit_of_each_test_that_counts():
    own = loaded(simulation(2.0 * Y, contact=3.0 * Y, overall=None), coat=(20.0, 20.0))
    found = judge(loaded(simulation(1.9 * Y, contact=2.0 * Y, overall=None), coat=(0.99 * Y, 0.0)), own, PLA, "robust")
    assert found.limits == found.each == (("", 2.0 * Y), ("coat", Y))
    assert (found.as_placed.limit, found.of_the_drop) == (Y, 2.0 * Y)
    alone = judge(simulation(20.0), simulation(), PLA, "robust")
    assert (alone.limits, alone.each, alone.of_the_drop) == ((("", Y),), (), Y)
    paper = judge(loaded(simulation(1.9 * Y), coat=(20.0, 0.0)), own, PLA, "paper")
    assert (paper.each, paper.of_the_drop) == ((), Y)
    assert judge(simulation(failure="it broke down"), own, PLA, "robust").limits == ()


@pytest.mark.parametrize("stress", [(1.7 * Y, 0.0), (0.0, 1.9 * Y)])
def test_what_the_original_bears_under_a_load_excuses_nothing_in_the_drop_nor_under_another(stress):
    own = loaded(simulation(overall=None), coat=(2.0 * Y, 2.0 * Y), hand=(20.0, 20.0))
    dropped = judge(loaded(simulation(*stress, overall=None), coat=(20.0, 20.0), hand=(20.0, 20.0)), own, PLA, "robust")
    assert dropped.words.startswith("FAILS: dropped as placed, which is worse than any load, ")
    pushed = judge(loaded(simulation(overall=None), coat=(20.0, 20.0), hand=stress), own, PLA, "robust")
    assert pushed.words.startswith("FAILS: under the load 'hand' ")


def test_an_original_over_strength_under_a_load_allows_as_much_there_and_it_is_said():
    own = loaded(simulation(overall=None), coat=(2.0 * Y, 0.0))
    found = judge(loaded(simulation(overall=None), coat=(1.7 * Y, 0.0)), own, PLA, "robust")
    assert (found.outcome, found.as_placed.limit) == ("VIABLE", 2.0 * Y)
    assert found.words.startswith("VIABLE: under the load 'coat' ")
    assert f"within the original's own {2.0 * Y:.1f} MPa, which itself exceeds" in found.words
    assert judge(loaded(simulation(overall=None), coat=(2.2 * Y, 0.0)), own, PLA, "robust").outcome == "FAILS"


def test_a_load_that_is_close_around_its_supports_is_marginal_where_the_drop_is_nearest():
    found = judge(loaded(simulation(0.94 * Y, overall=None), coat=(10.0, 0.93 * Y)), loaded(simulation(), coat=(9.0, 9.0)), PLA, "robust")
    assert (found.outcome, found.marginal) == ("VIABLE", True)
    assert "and under the load 'coat' the stress around the contact" in found.words


def test_a_load_of_an_earlier_record_is_judged_by_what_is_known_of_it():
    own = replace(simulation(2.0 * Y, overall=None), loaded=(LoadResult(name="coat", peak=20.0, where=(0.0, 0.0, 0.0), deflection=0.1),))
    peak = LoadResult(name="coat", peak=1.7 * Y, where=(0.0, 0.0, 0.0), deflection=0.1, averaged=1.7 * Y)
    assert judge(replace(simulation(1.7 * Y, overall=None), loaded=(peak,)), own, PLA, "robust").outcome == "FAILS"


def test_a_load_whose_stress_is_no_number_is_unknown():
    part = loaded(simulation(overall=None), coat=(np.nan, 0.0))
    assert judge(part, loaded(simulation(), coat=(1.0, 0.0)), PLA, "robust").outcome == "UNKNOWN"


def test_the_input_is_warned_of_only_when_it_is_about_to_yield_itself():
    assert input_warning(simulation(43.0), PLA) == ""
    assert "about to yield" in input_warning(simulation(44.0), PLA)
    warning = input_warning(simulation(52.0), PLA)
    assert "52.0 MPa at (1.0, 2.0, 3.0) mm" in warning
    assert "45.6 MPa" in warning
    assert "unstable" in input_warning(simulation(failure="the drop test is unstable"), PLA)


def test_an_unknown_criterion_is_refused():
    with pytest.raises(BadInput, match=r"'robst'.*robust"):
        judge(simulation(), simulation(), PLA, "robst")
