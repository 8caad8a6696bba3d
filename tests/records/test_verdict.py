"""The verdict, unsafe side first: what may never pass, what may never better an outcome, and where exactly each limit lies."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechstyle.records import Doubt, Simulation, Verdict, judge
from mechstyle.records.load_cases import Load, LoadCase, Support
from mechstyle.records.material import LIBRARY
from mechstyle.records.simulation import LEAST_GROUNDED, LIKE_ASKED, THICKER, VOLUME_ERROR
from mechstyle.records.verdict import LITERAL_REPEATS, MEASURE, MORE_THAN_PLAIN, OLDER, REPEATS, REPEATS_SHARE, SMEARED
from support.records import STRENGTH, TOLERANCE, landing, load_result, load_row, recipe, row, verdict

BREAKS = LIBRARY["PLA"].elongation
COAT = LoadCase(name="coat", supports=(Support(at="resting face"),), loads=(Load(gravity=1.0),))
SEVERITY = ("HOLDS", "NO WORSE", "FAILS")
TESTS = ("flat", "tilted left", "tilted right", "direction 1", "coat", "push")
LOADS = TESTS[4:]
WAYS = {"flat": "flat", "tilted left": "nearly flat", "tilted right": "nearly flat"}


def asked(*loads, **settings):
    return recipe(loads=tuple(msgspec.structs.replace(COAT, name=name) for name in loads), **settings)


def a_part(tests, **changes):
    """A part by its tests: what stays bent [mm], or that, the plastic strain and whether it gives way."""
    landings, loads = [], []
    for name, figures in tests.items():
        bent, strain, collapses = (*figures, *(0.0, False)[len(figures) - 1 :]) if isinstance(figures, tuple) else (figures, 0.0, False)
        found = {"permanent_set": bent, "plastic_strain": strain}
        if name in LOADS:
            loads.append(load_result(name, collapses=collapses, **found))
        else:
            landings.append(landing(name, way=WAYS.get(name, "any landing"), **found))
    fields = {"displacement": np.zeros(2), "contact": np.zeros(2, bool), "landings": tuple(landings), "loads": tuple(loads)}
    return Simulation(**{**fields, **changes})


def without(simulation, *names):
    kept = {kind: tuple(one for one in getattr(simulation, kind) if one.name not in names) for kind in ("landings", "loads")}
    return Simulation(displacement=simulation.displacement, contact=simulation.contact, **kept)


def outcome(styled, plain=None, *loads, **settings):
    return judge(a_part(styled), None if plain is None else a_part(plain), asked(*loads, **settings)).outcome


# --- what may never pass ------------------------------------------------------------------------------------------

BROKEN = (math.nan, math.inf, -math.inf, -1e-9)
SOUND = a_part(dict.fromkeys(TESTS, 0.01))
FAILED = Simulation(displacement=np.zeros(2), contact=np.zeros(2, bool), failure="the integration blew up")


def is_no_answer(found, words):
    assert (found.outcome, found.passes, found.sure, found.rows, found.deciding) == ("UNKNOWN", False, False, (), None)
    assert found.failure == words
    return True


@pytest.mark.parametrize("criterion", ["robust", "paper"])
@pytest.mark.parametrize("broken", BROKEN)
@pytest.mark.parametrize("figure", ["permanent_set", "plastic_strain", "maximum"])
@pytest.mark.parametrize("name", TESTS)
def test_a_figure_that_is_not_finite_is_unknown_in_the_part_and_in_its_original(criterion, broken, figure, name):
    def spoilt(one):
        return msgspec.structs.replace(one, **{figure: broken}) if one.name == name else one

    wrong = replace(SOUND, landings=tuple(map(spoilt, SOUND.landings)), loads=tuple(map(spoilt, SOUND.loads)))
    for part, original, whose in ((wrong, SOUND, "part"), (SOUND, wrong, "original"), (wrong, None, "part")):
        found = judge(part, original, asked("coat", "push", criterion=criterion))
        assert is_no_answer(found, f"what stays bent of the {whose} in the test {name!r} is not a finite number")


def test_a_test_that_failed_is_unknown_whoever_it_is_of():
    assert is_no_answer(judge(FAILED, SOUND, asked()), "the integration blew up")
    assert is_no_answer(judge(SOUND, FAILED, asked()), "the original could not be simulated: the integration blew up")
    assert is_no_answer(judge(replace(SOUND, failure="it gave way"), None, asked()), "it gave way")


def test_what_was_asked_for_and_not_tested_is_unknown():
    assert is_no_answer(judge(without(SOUND, *TESTS[:4]), None, asked()), "the part was not dropped")
    assert is_no_answer(judge(without(SOUND, "flat"), SOUND, asked()), "the part was not dropped")
    assert is_no_answer(judge(SOUND, without(SOUND, "flat"), asked()), "the original was not dropped")
    assert is_no_answer(judge(without(SOUND, "tilted left", "tilted right"), SOUND, asked()), "the part was not dropped nearly flat")
    assert is_no_answer(judge(without(SOUND, "push"), SOUND, asked("coat", "push")), "the part was not tested under the load 'push'")


# --- nothing worse betters anything -------------------------------------------------------------------------------

bends = st.one_of(st.sampled_from([0.0, TOLERANCE, 0.22, TOLERANCE + MORE_THAN_PLAIN]), st.floats(0.0, 1.0))
strains = st.one_of(st.sampled_from([0.0, BREAKS, 1.5 * BREAKS]), st.floats(0.0, 3.0 * BREAKS))
figures = st.tuples(bends, strains, st.sampled_from([False, False, True]))


@st.composite
def parts(draw):
    """A part, the same with no less in any test, and an original or none, in the same tests."""
    names = ["flat", *draw(st.lists(st.sampled_from(TESTS[1:]), unique=True, max_size=2))]
    now, plain = ({name: draw(figures) for name in names} for _ in range(2))
    more = {}
    for name, (bent, strain, collapses) in now.items():
        further = draw(figures)
        more[name] = (bent + further[0], strain + further[1], collapses or further[2])
    return a_part(now), a_part(more), draw(st.sampled_from([None, a_part(plain)]))


@given(parts(), st.floats(0.01, 1.0))
def test_it_holds_exactly_if_nothing_asked_for_bends_beyond_the_tolerance_cracks_or_gives_way(found, tolerance):
    part, _, original = found
    judged = judge(part, original, asked(tolerance=tolerance))
    tests = [*part.landings, *part.loads]
    sound = [one.permanent_set <= tolerance and one.plastic_strain <= BREAKS and not getattr(one, "collapses", False) for one in tests]
    assert (judged.outcome == "HOLDS") == all(sound)
    assert [row.outcome == "HOLDS" for row in judged.rows] == sound
    assert [row.outcome == "FAILS" for row in judged.rows] == [row.used > 1.0 for row in judged.rows]
    assert judged.outcome == judged.deciding.outcome == max((row.outcome for row in judged.rows), key=SEVERITY.index)
    if original is None:
        assert judged.outcome != "NO WORSE"


@given(parts())
def test_more_that_stays_more_strain_or_a_collapse_never_betters_an_outcome(found):
    less, more, original = found
    before, after = (judge(one, original, asked()) for one in (less, more))
    assert SEVERITY.index(after.outcome) >= SEVERITY.index(before.outcome)
    for one, other in zip(before.rows, after.rows, strict=True):
        assert SEVERITY.index(other.outcome) >= SEVERITY.index(one.outcome)
        assert other.used >= one.used
        assert other.allowed == one.allowed, "what is allowed comes from the original alone: a relief raises nothing"


@given(parts(), st.data())
def test_a_test_more_never_betters_an_outcome_and_one_less_never_worsens_it(found, data):
    part, _, original = found
    names = [one.name for one in (*part.landings[1:], *part.loads)]
    gone = data.draw(st.sets(st.sampled_from(names))) if names else set()
    every = judge(part, original, asked())
    fewer = judge(without(part, *gone), None if original is None else without(original, *gone), asked())
    assert SEVERITY.index(fewer.outcome) <= SEVERITY.index(every.outcome)
    if original is not None:  # what the original was not tested in excuses nothing
        alone = judge(part, without(original, *gone), asked())
        assert SEVERITY.index(alone.outcome) >= SEVERITY.index(every.outcome)


@given(parts(), st.floats(0.01, 1.0), st.floats(0.01, 1.0))
def test_a_smaller_tolerance_never_betters_an_outcome(found, one, other):
    strict, lax = (judge(found[0], found[2], asked(tolerance=tolerance)).outcome for tolerance in sorted((one, other)))
    assert SEVERITY.index(strict) >= SEVERITY.index(lax)


# --- where the limits lie -----------------------------------------------------------------------------------------

BAD = 0.4


@pytest.mark.parametrize("test", TESTS)
def test_each_limit_is_met_to_the_last_digit(test):
    beyond, calm = math.nextafter, {"flat": 0.0, test: 0.0}
    for limit, plain, passed in ((TOLERANCE, {**calm, test: 0.15}, "HOLDS"), (BAD + MORE_THAN_PLAIN, {**calm, test: BAD}, "NO WORSE")):
        assert outcome({**calm, test: limit}, plain) == passed
    assert outcome({**calm, test: beyond(BAD + MORE_THAN_PLAIN, 1.0)}, {**calm, test: BAD}) == "FAILS"
    assert outcome({**calm, test: beyond(TOLERANCE, 1.0)}, {**calm, test: 0.1}) == "FAILS"
    assert outcome({**calm, test: beyond(TOLERANCE, 1.0)}) == "FAILS", "by itself nothing excuses it"
    assert outcome({**calm, test: (0.0, BREAKS)}) == "HOLDS"
    assert outcome({**calm, test: (0.0, beyond(BREAKS, 1.0))}, {**calm, test: (0.0, BREAKS)}) == "FAILS"
    assert outcome({**calm, test: (0.0, beyond(BREAKS, 1.0))}, {**calm, test: (0.0, beyond(BREAKS, 1.0))}) == "NO WORSE"


def test_one_corner_among_thirty_landings_that_hold_decides():
    judged = judge(a_part({"flat": 0.0, **{f"corner {n}": 0.0 for n in range(29)}, "edge": 0.21}), None, asked())
    assert (judged.outcome, judged.deciding.landing, len(judged.rows)) == ("FAILS", "edge", 31)


@pytest.mark.parametrize("weak", TESTS)
@pytest.mark.parametrize("over", TESTS)
def test_no_test_of_the_original_excuses_another(weak, over):
    calm = dict.fromkeys(TESTS, 0.0)
    assert outcome({**calm, over: BAD}, {**calm, weak: BAD}) == ("NO WORSE" if weak == over else "FAILS")


def test_a_crack_is_excused_by_that_of_the_original_alone_however_long():
    torn = a_part({"flat": (0.3, 9.0 * BREAKS)})
    for share, sure in ((1.2, True), (1.05, False)):
        judged = judge(torn, a_part({"flat": (0.3, share * BREAKS)}), asked())
        assert (judged.outcome, judged.deciding.used, judged.sure) == ("NO WORSE", 0.3 / (0.3 + MORE_THAN_PLAIN), sure)
    assert judge(torn, a_part({"flat": (0.3, BREAKS)}), asked()).outcome == "FAILS"
    for share, sure in ((0.95, False), (0.85, True)):  # of a part that may crack or not, like its original
        assert judge(a_part({"flat": (0.3, share * BREAKS)}), a_part({"flat": (0.3, 1.05 * BREAKS)}), asked()).sure is sure


def test_a_collapse_is_excused_by_that_of_the_original_alone():
    calm, gone = {"flat": 0.0, "coat": 0.0}, {"flat": 0.0, "coat": (0.0, 0.0, True)}
    assert [outcome(gone, plain) for plain in (None, calm, gone)] == ["FAILS", "FAILS", "NO WORSE"]
    assert outcome({"flat": 0.0, "coat": (1.0, 0.0, True)}, gone) == "FAILS"


def test_what_gives_way_later_uses_less_of_what_is_allowed_but_always_more_than_all():
    """A correction looks at that: if all that gives way were as bad, no lowering would count."""
    used = [load_row(2.0, collapses=True, carries=carries).used for carries in (None, 0.0, 0.1, 0.5, 0.9, 1.5)]
    assert used == sorted(used, reverse=True)
    assert used[2] > used[3] > used[4] > load_row(2.0).used
    assert load_row(0.0, collapses=True, carries=1.0, outcome="FAILS").used > 1.0


def test_a_row_has_the_figures_of_both_parts_and_the_worst_decides():
    judged = judge(a_part({"flat": 0.3, "direction 1": (0.1, 0.03), "coat": 0.5}), a_part({"flat": 0.28, "coat": 0.5}), asked("coat"))
    flat, edge, coat = judged.rows
    assert (flat.test, flat.plain_permanent_set, flat.allowed, flat.outcome) == ("flat", 0.28, 0.28 + MORE_THAN_PLAIN, "NO WORSE")
    assert (edge.landing, edge.plain_permanent_set, edge.allowed, edge.used) == ("direction 1", None, TOLERANCE, 0.03 / BREAKS)
    assert (coat.load, coat.carries, coat.permanent_set) == ("coat", 1.5, 0.5)
    assert judged.deciding is flat is judged.row(landing="flat"), "0.3 of 0.33 mm is more than 0.5 of 0.55"
    assert judged.row(load="coat") is coat
    assert (judged.row(landing="none"), judged.tolerance, judged.measure) == (None, TOLERANCE, MEASURE)


def test_of_what_holds_the_worst_is_what_stays_bent_most():
    """Said was "at worst 0.03 mm" of a table with 0.05 mm, because that row was strained more."""
    judged = judge(a_part({"flat": 0.03, "direction 1": (0.05, 0.0)}), None, asked())
    strained = msgspec.structs.replace(judged.rows[0], plastic_strain=0.9 * BREAKS)
    assert msgspec.structs.replace(judged, rows=(strained, judged.rows[1])).deciding.permanent_set == 0.05


def test_the_published_rule_decides_by_the_largest_stress_alone_in_one_row():
    calm, peaked = (a_part({"flat": 0.0, "direction 1": 9.0, "coat": 9.0}) for _ in range(2))
    calm = replace(calm, loads=(load_result(maximum=STRENGTH),))
    peaked = replace(peaked, loads=(load_result(maximum=math.nextafter(STRENGTH, 99.0)),))
    for part, said in ((calm, "HOLDS"), (peaked, "FAILS")):
        judged = judge(part, peaked, asked("coat", criterion="paper"))
        (only,) = judged.rows
        assert (judged.outcome, only.test, only.stress, only.limit) == (said, "published rule", part.maximum, STRENGTH)
        assert (only.sure, only.landing) == (False, "flat")
    for maximum in (0.0, STRENGTH / (1.01 + LITERAL_REPEATS)):
        resting = a_part({"flat": 0.0}, landings=(landing(maximum=maximum),), landing_stress=())
        assert judge(resting, None, asked(criterion="paper")).sure


# --- doubts -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("allowed", [TOLERANCE, 1.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_test_closer_to_its_limit_than_it_repeats_leaves_a_doubt(allowed, side):
    repeats = max(REPEATS, REPEATS_SHARE * allowed)
    for share, sure in ((0.99, False), (1.01, True)):
        judged = judge(a_part({"flat": allowed + side * share * repeats}), None, asked(tolerance=allowed))
        assert judged.sure is sure
        assert judged.doubts == (() if sure else (Doubt(about="limit", test="flat", landing="flat", value=judged.deciding.used),))
        strain = BREAKS * (1.0 + side * share * REPEATS_SHARE)
        assert judge(a_part({"flat": (0.0, strain)}), None, asked()).sure is sure


@pytest.mark.parametrize(
    ("share", "outcome", "sure"), [(0.99, "HOLDS", True), (1.01, "HOLDS", False), (1.01 * SMEARED * 1.2, "FAILS", True)]
)
def test_a_print_that_holds_is_sure_only_where_it_would_with_its_infill_meshed_sheet_by_sheet(share, outcome, sure):
    solid = a_part({"flat": share * TOLERANCE / SMEARED})
    judged = judge(replace(solid, plastic_share=0.4), None, asked())
    assert (judged.outcome, judged.sure) == (outcome, sure)
    assert judge(solid, None, asked()).sure, "of a solid part nothing is smeared out"


@pytest.mark.parametrize(("carries", "sure"), [(0.88, True), (0.92, False), (1.08, False), (1.12, True)])
def test_a_load_that_a_little_more_or_less_would_turn_leaves_a_doubt(carries, sure):
    """What collapses keeps its shape until then: 0 mm at .97 of what breaks it is not far from its limit."""
    held, gone = load_row(0.0, carries=carries), load_row(2.0, carries=carries, collapses=True)
    assert held.sure is gone.sure is sure
    assert load_row(0.0, carries=carries, plastic_strain=0.2, outcome="FAILS").sure, "it cracks whatever it carries"
    assert load_row(2.0, carries=carries, collapses=True, outcome="NO WORSE").sure


def test_one_sure_failure_settles_it_and_of_failures_in_doubt_only_they_are_named():
    settled = judge(a_part({"flat": 0.201, "direction 1": 0.9}, carried=0.1), None, asked())
    assert (settled.outcome, settled.doubts) == ("FAILS", ())
    unsettled = judge(a_part({"flat": 0.201, "direction 1": 0.199}, carried=0.1), None, asked())
    assert [(doubt.about, doubt.landing) for doubt in unsettled.doubts] == [("limit", "flat")]


@pytest.mark.parametrize(
    ("figure", "about", "value", "good"),
    [
        ("thicker", "relief", math.nan, False),
        ("thicker", "relief", 1.01 * THICKER, False),
        ("thicker", "relief", THICKER, True),
        ("grounded", "base", math.nan, False),
        ("grounded", "base", 0.99 * LEAST_GROUNDED, False),
        ("grounded", "base", LEAST_GROUNDED, True),
        ("volume_error", "volume", math.nan, False),
        ("volume_error", "volume", -1.01 * VOLUME_ERROR, False),
        ("volume_error", "volume", VOLUME_ERROR, True),
        ("enlarged", "pattern", 1.01 * LIKE_ASKED, False),
        ("enlarged", "pattern", LIKE_ASKED, True),
    ],
)
def test_a_mesh_that_is_thicker_or_hangs_or_misses_volume_leaves_a_doubt_on_what_passes(figure, about, value, good):
    for plain in (None, a_part({"flat": 0.0})):
        judged = judge(a_part({"flat": 0.0}, **{figure: value}), plain, asked())
        assert judged.passes
        assert [doubt.about for doubt in judged.doubts] == ([] if good else [about])


def test_what_passes_in_some_of_the_landings_alone_says_how_many_are_missing():
    """While a relief grows it falls in few landings: that they hold is not that all hold."""
    plain = a_part({"flat": 0.0, "tilted left": 0.01, "tilted right": 0.01, "direction 1": 0.01})
    judged = judge(a_part({"flat": 0.0, "tilted left": 0.01}), plain, asked())
    assert (judged.passes, judged.sure, [(one.about, one.value) for one in judged.doubts]) == (True, False, [("landings", 2.0)])
    assert "2 of 4 landings were not dropped" in judged.doubt
    assert judge(plain, plain, asked()).sure
    paper = judge(a_part({"flat": 0.0}), plain, asked(criterion="paper"))
    assert not [one for one in paper.doubts if one.about == "landings"], "which reads the flat landing alone"


# --- what is stored -----------------------------------------------------------------------------------------------

OLD = b"""{"outcome":"HOLDS","criterion":"robust","fall":1500.0,"strength":45.6,"material":"generic PLA","style":"brick","rows":[
{"test":"flat","outcome":"HOLDS","stress":40.0,"limit":45.6,"height":1949.4,"asked":1500.0,"original":2400.0,"landing":"flat","decides":true},
{"test":"load","outcome":"HOLDS","stress":30.0,"limit":45.6,"factor":1.52,"asked":1.0,"original":null,"load":"coat","decides":true}],
"doubts":[{"about":"limit","value":1.3,"test":"flat","landing":"flat"}],"failure":""}"""


def test_a_verdict_of_an_older_measure_is_none():
    older = msgspec.json.decode(OLD, type=Verdict)
    assert is_no_answer(older, OLDER)
    assert "older measure" in older.head
    assert is_no_answer(msgspec.structs.replace(verdict(), measure=MEASURE + 1), OLDER)


def test_a_verdict_comes_back_from_json_as_it_was():
    doubted = verdict(row(), load_row(0.9), doubts=(Doubt(about="limit", value=1.01, test="flat", landing="flat"),))
    assert msgspec.json.decode(msgspec.json.encode(doubted), type=Verdict) == doubted
    assert not doubted.sure
    with pytest.raises(msgspec.ValidationError, match="FINE"):
        msgspec.json.decode(msgspec.json.encode(doubted).replace(b'"outcome":"FAILS"', b'"outcome":"FINE"', 1), type=Verdict)
