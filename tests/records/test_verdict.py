"""The verdict, unsafe side first: what may never pass, what may never better an outcome, and where exactly each limit lies."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mechstyle.loop.control import utilisation
from mechstyle.records import Landing, LoadResult, Recipe, Simulation, judge
from mechstyle.records.load_cases import Load, LoadCase, Support
from mechstyle.records.material import LIBRARY
from mechstyle.records.simulation import LEAST_CARRIED, VOLUME_ERROR
from mechstyle.records.verdict import NO_WORSE, REPEATABILITY, drop_limit, load_limit

PLA = LIBRARY["PLA"]
Y = PLA.yield_strength
FALL = 1500.0
HUNG, PUSHED = (
    LoadCase(name=name, supports=(Support(at="resting face"),), loads=(Load(gravity=1.0),)) for name in ("hung", "pushed")
)  # fmt: skip


def asked(**settings):
    return Recipe.of(surface="s", tetrahedra="t", prompt="brick", **{"material": PLA, **settings})


def dropped(stress, way="flat", name="", **changes):
    """A landing from whose σ_V [MPa] all else follows."""
    height = FALL * (Y / stress) ** 2 if stress and math.isfinite(stress) else math.nan
    figures = {"stress": stress, "maximum": 2.0 * stress, "fall": FALL, "critical_height": height}
    return Landing(name=name or way, way=way, normal=(0.0, 0.0, 1.0), where=(0.0, 0.0, 0.0), **{**figures, **changes})


def a_part(flat, nearly=(), directions=(), hung=None, pushed=None, **changes):
    """A test with these σ_V [MPa]; the stress at each of its two vertices is that, and a half."""
    landings = [dropped(flat), *(dropped(one, "nearly flat", f"tilted {n}") for n, one in enumerate(nearly))]
    landings += [dropped(one, "any landing", f"direction {n}") for n, one in enumerate(directions)]
    loads = [
        LoadResult(name=name, stress=stress, maximum=2.0 * stress, where=(0.0, 0.0, 0.0), deflection=0.1)
        for name, stress in (("hung", hung), ("pushed", pushed)) if stress is not None
    ]  # fmt: skip
    shape = np.array([1.0, 0.5])
    fields = {
        "displacement": np.zeros(2), "contact": np.zeros(2, bool), "landings": tuple(landings), "loads": tuple(loads),
        "landing_stress": np.array([one.stress for one in landings])[:, None] * shape,
        "load_stress": np.array([case.stress for case in loads])[:, None] * shape if loads else np.zeros((0, 2)),
    }  # fmt: skip
    return Simulation(**{**fields, **changes})


FAILED = Simulation(displacement=np.zeros(2), contact=np.zeros(2, bool), failure="the integration blew up")
SEVERITY = ("HOLDS", "NO WORSE", "FAILS")

# --- what may never pass ------------------------------------------------------------------------------------------

BROKEN = [math.nan, math.inf, -math.inf, 0.0, -1.0]
FIGURES = ["stress", "maximum", "critical_height"]


def with_landing(simulation, number, **changes):
    landings = list(simulation.landings)
    landings[number] = msgspec.structs.replace(landings[number], **changes)
    return replace(simulation, landings=tuple(landings))


def is_no_answer(verdict):
    return (verdict.outcome, verdict.passes, verdict.sure, verdict.rows, verdict.safety_factor) == ("UNKNOWN", False, False, (), None)


@pytest.mark.parametrize("criterion", ["robust", "paper"])
@pytest.mark.parametrize("broken", BROKEN)
@pytest.mark.parametrize("figure", FIGURES)
@pytest.mark.parametrize("number", [0, 1, 2], ids=["flat", "nearly flat", "any landing"])
def test_a_figure_that_is_not_finite_and_above_zero_is_unknown_in_the_part_and_in_its_original(criterion, broken, figure, number):
    sound = a_part(20.0, nearly=(20.0,), directions=(20.0,))
    wrong = with_landing(sound, number, **{figure: broken})
    for part, original in ((wrong, sound), (sound, wrong), (wrong, None)):
        verdict = judge(part, original, asked(criterion=criterion, orientations=2))
        assert is_no_answer(verdict)
        assert f"the test {sound.landings[number].name!r} is not a finite number above 0" in verdict.failure


@pytest.mark.parametrize("broken", BROKEN)
@pytest.mark.parametrize("figure", ["stress", "maximum"])
def test_so_it_is_under_a_load(broken, figure):
    sound = a_part(20.0, hung=20.0)
    wrong = replace(sound, loads=(msgspec.structs.replace(sound.loads[0], **{figure: broken}),))
    for part, original in ((wrong, sound), (sound, wrong), (wrong, None)):
        assert is_no_answer(judge(part, original, asked(loads=(HUNG,))))


def test_a_test_that_failed_is_unknown_whoever_it_is_of():
    verdict = judge(FAILED, a_part(20.0), asked())
    assert is_no_answer(verdict)
    assert verdict.failure == "the integration blew up"
    verdict = judge(a_part(20.0), FAILED, asked())
    assert is_no_answer(verdict)
    assert verdict.failure == "the original could not be simulated: the integration blew up"
    assert is_no_answer(judge(replace(a_part(20.0), failure="the loads could not be solved"), None, asked()))


NOT_DROPPED = a_part(20.0, landings=(), landing_stress=np.zeros((0, 2)))


@pytest.mark.parametrize(
    "simulation", [NOT_DROPPED, a_part(20.0, landings=(dropped(20.0, "nearly flat"),), landing_stress=np.ones((1, 2)))],
    ids=["no landing", "none that is flat"],
)  # fmt: skip
def test_a_part_that_was_not_dropped_flat_is_unknown(simulation):
    assert judge(simulation, None, asked()).failure == "the part was not dropped"
    assert judge(a_part(20.0), simulation, asked()).failure == "the original was not dropped"
    assert is_no_answer(judge(simulation, None, asked()))


def test_a_load_that_was_asked_for_and_not_tested_is_unknown():
    verdict = judge(a_part(20.0, hung=20.0), a_part(20.0, hung=20.0, pushed=20.0), asked(loads=(HUNG, PUSHED)))
    assert is_no_answer(verdict)
    assert verdict.failure == "the part was not tested under the load 'pushed'"


def test_a_styled_part_that_was_not_tilted_as_its_original_was_is_unknown():
    assert judge(a_part(20.0), a_part(20.0, nearly=(20.0,)), asked()).failure == "the part was not dropped nearly flat"


# --- more stress never betters anything ---------------------------------------------------------------------------

stresses = st.floats(1.0, 300.0)
several = st.lists(stresses, min_size=1, max_size=3)


@st.composite
def pairs(draw):
    """A styled part and its original in the same tests, and a styled part that bears no less stress in any of them."""
    counts = draw(st.tuples(st.integers(0, 3), st.integers(0, 3), st.booleans(), st.booleans()))

    def figures():
        return [draw(stresses) for _ in range(1 + sum(counts))]

    def made(values):
        values = iter(values)
        flat, nearly, directions = next(values), [next(values) for _ in range(counts[0])], [next(values) for _ in range(counts[1])]
        hung, pushed = (next(values) if there else None for there in counts[2:])
        return a_part(flat, nearly, directions, hung, pushed)

    now = figures()
    more = [draw(st.floats(1.0, 3.0)) * value for value in now]
    return made(now), made(more), draw(st.one_of(st.none(), st.just(made(figures()))))


@given(pairs(), st.sampled_from(["robust", "paper"]))
def test_more_stress_never_betters_an_outcome(found, criterion):
    less, more, original = found
    before, after = (judge(one, original, asked(criterion=criterion, orientations=4)) for one in (less, more))
    assert SEVERITY.index(after.outcome) >= SEVERITY.index(before.outcome)
    assert after.safety_factor <= before.safety_factor * (1.0 + 1e-9)
    for one, other in zip(before.rows, after.rows, strict=True):
        assert SEVERITY.index(other.outcome) >= SEVERITY.index(one.outcome)
        assert other.reserve <= one.reserve * (1.0 + 1e-9)
        assert other.limit == one.limit, "limits come from the original alone: a relief raises none"


@given(stresses, stresses, st.floats(10.0, 100.0))
def test_limits_grow_with_the_stress_of_the_original_and_are_never_below_the_strength(one, other, strength):
    low, high = sorted((one, other))
    for limit in (drop_limit, load_limit):
        assert strength <= limit(low, strength) <= limit(high, strength)


@given(pairs(), st.floats(1.0, 2.0))
def test_a_stronger_original_never_betters_an_outcome(found, times):
    styled, _, original = found
    assume(original is not None)
    stronger = replace(
        original,
        landings=tuple(msgspec.structs.replace(one, stress=one.stress / times) for one in original.landings),
        loads=tuple(msgspec.structs.replace(case, stress=case.stress / times) for case in original.loads),
    )
    before, after = (judge(styled, one, asked(orientations=4)) for one in (original, stronger))
    assert SEVERITY.index(after.outcome) >= SEVERITY.index(before.outcome)


# --- where the limits lie -----------------------------------------------------------------------------------------


@given(pairs())
def test_it_holds_exactly_if_no_row_that_decides_exceeds_the_strength_and_passes_exactly_within_the_limits(found):
    styled, _, original = found
    verdict = judge(styled, original, asked(orientations=4))
    deciding = [row for row in verdict.rows if row.decides]
    assert (verdict.outcome == "HOLDS") == all(row.stress <= Y for row in deciding)
    assert verdict.passes == all(row.stress <= row.limit for row in deciding)
    assert (verdict.deciding.reserve >= 1.0) == verdict.passes, "the row that decides says what the verdict says"
    assert verdict.safety_factor == pytest.approx(min(Y / row.stress for row in deciding))


def just(value, side):
    return value * (1.0 + 1e-9 * side)


@pytest.mark.parametrize(("side", "outcome"), [(-1, "NO WORSE"), (1, "FAILS")])
def test_no_worse_is_nine_tenths_of_the_height_of_the_original_by_the_speed_of_a_fall(side, outcome):
    """A height goes with 1/σ²: nine tenths of it are 1.054 times the stress."""
    original = a_part(60.0)
    height = 0.9 * original.flat.critical_height
    verdict = judge(a_part(just(Y * math.sqrt(FALL / height), side)), original, asked())
    assert verdict.outcome == outcome
    assert verdict.row("flat").height / verdict.row("flat").original == pytest.approx(NO_WORSE)


@pytest.mark.parametrize(("side", "outcome"), [(-1, "NO WORSE"), (1, "FAILS")])
def test_no_worse_is_nine_tenths_of_the_factor_of_the_original_under_a_load(side, outcome):
    original = a_part(20.0, hung=60.0)
    verdict = judge(a_part(20.0, hung=just(60.0 / 0.9, side)), original, asked(loads=(HUNG,)))
    assert verdict.outcome == outcome
    assert verdict.row("load", "hung").factor / verdict.row("load", "hung").original == pytest.approx(NO_WORSE)


@pytest.mark.parametrize(("side", "outcome"), [(-1, "HOLDS"), (1, "FAILS")])
@pytest.mark.parametrize("original", [None, a_part(20.0, hung=20.0)], ids=["alone", "beside a strong original"])
def test_without_an_excuse_the_strength_is_the_limit(side, outcome, original):
    assert judge(a_part(just(Y, side), hung=20.0), original, asked(loads=(HUNG,))).outcome == outcome
    assert judge(a_part(20.0, hung=just(Y, side)), original, asked(loads=(HUNG,))).outcome == outcome


def test_a_critical_height_far_from_the_fall_decides_nothing():
    """It follows from another exponent where contact grows with the blow; the fall asked for was dropped."""
    original, styled = a_part(20.0, nearly=(100.0,)), a_part(20.0, nearly=(104.0,))
    styled = with_landing(styled, 1, critical_height=0.5 * original.landings[1].critical_height, exponent=0.2)
    row = judge(styled, original, asked()).row("nearly flat")
    assert row.outcome == "NO WORSE"
    assert row.height == styled.landings[1].critical_height


# --- what excuses what --------------------------------------------------------------------------------------------


def test_a_load_is_not_excused_by_the_drop_nor_the_drop_by_a_load_nor_one_load_by_another():
    recipe = asked(loads=(HUNG, PUSHED))
    high, low = 2.0 * Y, 20.0
    tests = {"flat": 0, "hung": 1, "pushed": 2}
    for weak, number in tests.items():
        figures = [low, low, low]
        figures[number] = high
        original = a_part(figures[0], hung=figures[1], pushed=figures[2])
        for over, there in tests.items():
            figures = [low, low, low]
            figures[there] = 1.5 * Y
            verdict = judge(a_part(figures[0], hung=figures[1], pushed=figures[2]), original, recipe)
            assert verdict.outcome == ("NO WORSE" if weak == over else "FAILS")


def test_a_landing_that_is_nearly_flat_does_not_excuse_the_flat_one():
    original = a_part(20.0, nearly=(90.0,))
    assert judge(a_part(90.0, nearly=(90.0,)), original, asked()).outcome == "FAILS"
    assert judge(a_part(20.0, nearly=(90.0,)), original, asked()).outcome == "NO WORSE"


def test_nearly_flat_and_any_landing_decide_beside_an_original_alone():
    """Most plastic parts yield at an edge: alone that says nothing of a style."""
    styled = a_part(20.0, nearly=(90.0,), directions=(200.0,))
    alone = judge(styled, None, asked(orientations=2))
    assert alone.outcome == "HOLDS"
    assert {row.test: row.decides for row in alone.rows} == {
        "flat": True, "nearly flat": False, "any landing": False, "published rule": False,
    }  # fmt: skip
    beside = judge(styled, a_part(20.0, nearly=(30.0,), directions=(200.0,)), asked(orientations=2))
    assert beside.outcome == "FAILS"
    assert [row.test for row in beside.rows if row.decides] == ["flat", "nearly flat", "any landing"]
    fewer = judge(styled, a_part(20.0, nearly=(90.0,)), asked(orientations=2))
    assert not fewer.row("any landing").decides, "the original was not dropped so"


def test_of_the_nearly_flat_landings_the_hardest_of_each_part_is_compared():
    """A corner may change places: a part is turned by its relief, its edges are not."""
    verdict = judge(a_part(20.0, nearly=(50.0, 90.0)), a_part(20.0, nearly=(88.0, 40.0)), asked())
    assert (verdict.outcome, verdict.row("nearly flat").landing) == ("NO WORSE", "tilted 1")


def test_other_landings_are_judged_by_their_geometric_mean_and_named_by_the_hardest():
    verdict = judge(a_part(20.0, directions=(50.0, 200.0)), a_part(20.0, directions=(100.0, 100.0)), asked(orientations=3))
    row = verdict.row("any landing")
    assert (row.stress, row.landing, row.outcome) == (pytest.approx(100.0), "direction 1", "NO WORSE")
    assert row.height == pytest.approx(FALL * (Y / 100.0) ** 2)


def test_the_published_rule_decides_by_the_literal_maximum_alone():
    calm, peaked = (with_landing(a_part(20.0, nearly=(500.0,), hung=20.0), 0, maximum=maximum) for maximum in (0.9 * Y, 1.1 * Y))
    recipe = asked(criterion="paper", loads=(HUNG,))
    for simulation, outcome in ((calm, "HOLDS"), (peaked, "FAILS")):
        verdict = judge(simulation, peaked, recipe)
        assert verdict.outcome == outcome, "not even an original that is above it excuses it"
        assert [row.test for row in verdict.rows if row.decides] == ["published rule"]
        assert verdict.published is verdict.deciding
        assert verdict.safety_factor == pytest.approx(Y / simulation.maximum)
    of_load = replace(calm, loads=(msgspec.structs.replace(calm.loads[0], maximum=1.1 * Y),))
    assert judge(of_load, None, recipe).outcome == "FAILS"
    robust = judge(peaked, None, asked(loads=(HUNG,)))
    assert (robust.outcome, robust.published.outcome, robust.published.decides) == ("HOLDS", "FAILS", False)


# --- doubts -------------------------------------------------------------------------------------------------------

BAND = 1.0 + REPEATABILITY["flat"]


@pytest.mark.parametrize("stress", [Y / (0.999 * BAND), 0.999 * Y * BAND])
def test_a_test_closer_to_its_limit_than_it_repeats_is_a_doubt(stress):
    (doubt,) = judge(a_part(stress), None, asked()).doubts
    assert (doubt.about, doubt.test, doubt.landing) == ("limit", "flat", "flat")
    assert doubt.value == pytest.approx((Y / stress) ** 2)


@pytest.mark.parametrize("stress", [Y / (1.001 * BAND), 1.001 * Y * BAND])
def test_beyond_that_it_is_sure(stress):
    assert judge(a_part(stress), None, asked()).sure


def test_one_sure_failure_settles_it_and_of_failures_in_doubt_only_they_are_named():
    original = a_part(20.0, nearly=(20.0,), hung=20.0)
    recipe = asked(loads=(HUNG,))
    settled = judge(a_part(2.0 * Y, nearly=(1.001 * Y,), hung=0.999 * Y, carried=0.1), original, recipe)
    assert (settled.outcome, settled.doubts) == ("FAILS", ())
    unsettled = judge(a_part(0.999 * Y, nearly=(1.001 * Y,), hung=20.0, carried=0.1), original, recipe)
    assert [(doubt.about, doubt.test) for doubt in unsettled.doubts] == [("limit", "nearly flat")]


@pytest.mark.parametrize(
    ("changes", "about"),
    [
        ({"carried": 0.99 * LEAST_CARRIED}, "relief"),
        ({"carried": math.nan}, "relief"),
        ({"carried_base": 0.99 * LEAST_CARRIED}, "relief"),
        ({"carried_base": math.nan}, "relief"),
        ({"volume_error": 1.01 * VOLUME_ERROR}, "volume"),
        ({"volume_error": -1.01 * VOLUME_ERROR}, "volume"),
        ({"volume_error": math.nan}, "volume"),
    ],
)
def test_a_mesh_that_misses_relief_or_volume_leaves_a_doubt_on_what_passes(changes, about):
    for stress, original in ((20.0, None), (20.0, a_part(20.0)), (80.0, a_part(80.0))):
        verdict = judge(a_part(stress, **changes), original, asked())
        assert verdict.passes
        assert [doubt.about for doubt in verdict.doubts] == [about]


def test_a_mesh_just_good_enough_leaves_none():
    assert judge(a_part(20.0, carried=LEAST_CARRIED, carried_base=LEAST_CARRIED, volume_error=-VOLUME_ERROR), None, asked()).sure


def test_what_does_not_decide_leaves_no_doubt():
    assert judge(a_part(20.0, nearly=(0.999 * Y,)), None, asked()).sure


# --- what steers ----------------------------------------------------------------------------------------------------


@given(pairs())
def test_where_a_row_fails_the_surface_is_used_up_somewhere_and_where_it_surely_passes_nowhere(found):
    styled, _, original = found
    for row in judge(styled, original, asked(orientations=4)).rows:
        if row.decides:
            used = float(utilisation(styled, [row]).max())
            if row.outcome == "FAILS":
                assert used >= 1.0
            elif row.sure and row.test != "any landing":  # the hardest of those may be above their mean
                assert used < 1.0 + 1e-6


def test_a_safety_factor_is_yield_strength_over_stress_and_may_be_below_one():
    assert judge(a_part(20.0, hung=30.0), None, asked(loads=(HUNG,))).safety_factor == pytest.approx(Y / 30.0)
    no_worse = judge(a_part(62.0), a_part(60.0), asked())
    assert (no_worse.outcome, no_worse.safety_factor) == ("NO WORSE", pytest.approx(Y / 62.0))
