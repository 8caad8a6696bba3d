"""What people read of a verdict: exact sentences for the typical cases, and what none of them may say."""

from __future__ import annotations

import math
import re
from typing import get_args

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechstyle.records import Doubt, Outcome, sentences
from mechstyle.records.sentences import COLUMNS, EXPLANATION, MEANINGS, NOT_SURE, allowed, bend, doubt, found, head, label, note, short
from support.records import TOLERANCE, UNKNOWN, VERDICT, load_row, published_row, recipe, row, verdict

CORNER = "tilted 3° onto the left front corner"
FLAT = row(0.06, plain_permanent_set=0.05)
TILTED = row(0.24, test="nearly flat", landing=CORNER, plain_permanent_set=0.21, outcome="NO WORSE", allowed=0.26, place="at the foot")
BENT = row(1.24, plain_permanent_set=0.02, place="high up")
CRACKED = row(0.15, test="any landing", landing="direction 3", plastic_strain=0.061, cracks=True, outcome="FAILS")
COAT = load_row(0.11, plain_permanent_set=0.1)
BROKEN = load_row(3.0, carries=0.62, collapses=True, place="halfway up on the left")

# --- the head -----------------------------------------------------------------------------------------------------

HEADS = [
    (verdict(FLAT), "HOLDS a fall of 1.5 m: at worst 0.06 mm stays bent at the top, landing flat (plain part 0.05 mm)"),
    (
        verdict(row(0.06, plain_permanent_set=None), style="", fall=1220.0),
        "HOLDS a fall of 1.22 m: at worst 0.06 mm stays bent at the top, landing flat",
    ),
    (verdict(row(0.004, place="")), "HOLDS a fall of 1.5 m: nothing stays bent"),
    (
        verdict(FLAT, COAT),
        (
            "HOLDS a fall of 1.5 m and the load 'coat': at worst 0.11 mm stays bent at the top, under the load 'coat'"
            " (plain part 0.10 mm)"
        ),
    ),
    (
        verdict(FLAT, COAT, load_row(0.01, load="push")),
        "HOLDS a fall of 1.5 m and 2 loads: at worst 0.11 mm stays bent at the top, under the load 'coat' (plain part 0.10 mm)",
    ),
    (
        verdict(FLAT, TILTED),
        (
            f"NO WORSE than the plain part in a fall of 1.5 m: 0.24 mm stays bent at the foot, {CORNER} (plain part 0.21 mm,"
            " 0.26 mm allowed)"
        ),
    ),
    (
        verdict(BENT, TILTED),
        "FAILS a fall of 1.5 m: 1.24 mm stays bent high up, landing flat (plain part 0.02 mm, 0.20 mm allowed)",
    ),
    (
        verdict(FLAT, CRACKED),
        (
            "FAILS a fall of 1.5 m: it cracks, in the landing 'direction 3', with 6.1% of strain where 5.0% break it,"
            " and 0.15 mm stays bent (plain part 0 mm, 0.20 mm allowed)"
        ),
    ),
    (
        verdict(FLAT, msgspec.structs.replace(CRACKED, permanent_set=0.4)),
        (
            "FAILS a fall of 1.5 m: 0.40 mm stays bent at the top, in the landing 'direction 3' (plain part 0 mm, 0.20 mm allowed),"
            " and it cracks: 6.1% of strain where 5.0% break it"
        ),
    ),
    (verdict(FLAT, BROKEN), "FAILS the load 'coat': the part gives way halfway up on the left, at 0.62 times the load"),
    (verdict(msgspec.structs.replace(BROKEN, carries=None, place="")), "FAILS the load 'coat': the part gives way"),
]  # fmt: skip


@pytest.mark.parametrize(("judged", "words"), HEADS)
def test_the_head_says_the_outcome_the_worst_test_and_its_figures(judged, words):
    assert head(judged) == f"{words}. Solid PLA."
    assert head(judged).startswith(judged.outcome)


def test_where_there_is_no_answer_the_head_says_why():
    assert head(UNKNOWN) == "UNKNOWN: the integration blew up."
    assert head(msgspec.structs.replace(UNKNOWN, failure="It took too long.")) == "UNKNOWN: It took too long."


@pytest.mark.parametrize(("maximum", "said", "side"), [(40.0, "HOLDS", "at most"), (90.0, "FAILS", "above")])
def test_by_the_published_rule_the_head_is_about_the_largest_stress(maximum, said, side):
    judged = verdict(published_row(maximum), criterion="paper")
    stresses = f"the largest element stress is {maximum:.1f} MPa, {side} the 45.6 MPa at which PLA yields"
    assert head(judged) == f"{said} by the published rule: {stresses}, on a rigid floor."
    soft = msgspec.structs.replace(judged, contact_stiffness=300.0)
    assert head(soft) == f"{said} by the published rule: {stresses}, on a penalty floor of 300 N/mm a node."
    assert short(judged) == f"{said} by the published rule"


@pytest.mark.parametrize(
    ("judged", "words"),
    [
        (verdict(FLAT), "HOLDS a fall of 1.5 m"),
        (verdict(FLAT, TILTED), "NO WORSE than the plain part"),
        (verdict(BENT), "FAILS a fall of 1.5 m"),
        (verdict(FLAT, BROKEN), "FAILS the load 'coat'"),
        (UNKNOWN, "UNKNOWN"),
    ],
)
def test_on_a_badge_it_is_a_few_words(judged, words):
    assert short(judged) == words


# --- figures ------------------------------------------------------------------------------------------------------


def test_millimetres_stand_together_and_a_crack_after_them():
    """Red before: "0.15 mm, cracks of 0.20 mm"."""
    assert sentences.figures(CRACKED) == "direction 3: 0.15 mm of 0.20 mm, cracks"
    assert sentences.figures(FLAT) == "flat: 0.06 mm of 0.20 mm"


@pytest.mark.parametrize(
    ("bent", "words"), [(0.0, "0 mm"), (0.0049, "0 mm"), (0.0051, "0.01 mm"), (0.126, "0.13 mm"), (9.94, "9.94 mm"), (12.4, "12 mm")]
)
def test_what_stays_bent_is_told_as_a_caliper_reads_it(bent, words):
    assert bend(bent) == words


def millimetres(words):
    return float(words.split(" mm")[0])


bends = st.one_of(st.floats(0.0, 30.0), st.floats(TOLERANCE - 1e-4, TOLERANCE + 1e-4), st.floats(9.9, 10.1))


@given(bends, bends)
def test_a_greater_bend_never_reads_as_a_smaller_one(one, other):
    low, high = sorted((one, other))
    assert millimetres(bend(low)) <= millimetres(bend(high))


@given(st.lists(st.tuples(bends, st.sampled_from([0.01, TOLERANCE, 0.2049, 10.0])), min_size=1, max_size=4))
def test_every_cell_and_the_sentence_have_the_figures_of_their_row_and_read_as_they_were_judged(given_rows):
    judged = verdict(*(row(bent, landing=f"landing {n}", allowed=limit) for n, (bent, limit) in enumerate(given_rows)))
    for one, cells in zip(judged.rows, sentences.tabulated(judged)[1], strict=True):
        assert cells == (one.landing, "0 mm", found(one), allowed(one), "0.0%", one.outcome)
        assert millimetres(cells[2]) == pytest.approx(one.permanent_set, rel=0.05, abs=0.0051)
        if one.permanent_set > one.allowed + 1e-6:
            assert millimetres(cells[2]) > millimetres(cells[3]), "nothing fails by «0.20 of 0.20 mm»"
    worst = judged.deciding
    if worst.permanent_set >= sentences.NOTHING:
        assert f" {found(worst)} stays bent at the top" in head(judged)
    assert note(judged).endswith(f"; {label(worst)}: {found(worst)} of {allowed(worst)}")
    assert sentences.least(judged) == f"{label(worst)}: plain 0 mm, brick {found(worst)}"


# --- the doubt ----------------------------------------------------------------------------------------------------


def near(test="flat", landing="flat", load=""):
    return Doubt(about="limit", value=1.0, test=test, landing=landing, load=load)


LOWER = "a lower relief is followed more closely"
MISSED, SMALLER = Doubt(about="relief", value=0.22), Doubt(about="volume", value=-0.035)
DOUBTS = [
    (verdict(FLAT), ""),
    (UNKNOWN, ""),
    (
        verdict(FLAT, doubts=(near(),)),
        "Not sure: flat passes more closely than the test repeats; another mesh may say otherwise.",
    ),
    (
        verdict(BENT, doubts=(near("nearly flat", CORNER),)),
        f"Not sure: {CORNER} fails more closely than the test repeats; another mesh may say otherwise.",
    ),
    (
        verdict(FLAT, COAT, doubts=(near(), near("load", "", "coat"))),
        "Not sure: flat and the load 'coat' pass more closely than the test repeats; another mesh may say otherwise.",
    ),
    (
        verdict(FLAT, doubts=tuple(near(landing=f"direction {n}") for n in range(4))),
        "Not sure: 4 tests pass more closely than the test repeats; another mesh may say otherwise.",
    ),
    (
        verdict(FLAT, doubts=(Doubt(about="base", value=0.8),)),
        f"Not sure: only 80% of the base is on the floor in the mesh, too; {LOWER}.",
    ),
    (
        verdict(FLAT, doubts=(Doubt(about="pattern", value=2.34),)),
        "Not sure: the pattern is 2.3 times larger than asked; with more vertices the part may bend more.",
    ),
    (verdict(FLAT, doubts=(MISSED,)), f"Not sure: between the relief the mesh is 22% thicker than the part; {LOWER}."),
    (
        verdict(FLAT, doubts=(near(), MISSED, SMALLER)),
        (
            "Not sure: flat passes more closely than the test repeats; another mesh may say otherwise; between the relief the mesh is"
            f" 22% thicker than the part and the volume of the mesh is -3.5% off that of the part; {LOWER}."
        ),
    ),
    (
        verdict(FLAT, doubts=tuple(Doubt(about=what, value=math.nan) for what in ("relief", "base", "volume"))),
        (
            "Not sure: how thick the mesh is between the relief is not known, what of the base is on the floor in the mesh is not known"
            f" and the volume of the mesh is not known; {LOWER}."
        ),
    ),
]  # fmt: skip


@pytest.mark.parametrize(("judged", "words"), DOUBTS)
def test_the_doubt_says_what_is_not_sure_and_what_to_do(judged, words):
    assert doubt(judged) == words


# --- the table ----------------------------------------------------------------------------------------------------


def test_the_table_has_a_row_for_each_test():
    assert sentences.tabulated(verdict(FLAT, TILTED, CRACKED, COAT, msgspec.structs.replace(BROKEN, plain_permanent_set=None)))[1] == [
        ("flat", "0.05 mm", "0.06 mm", "0.20 mm", "0.0%", "HOLDS"),
        (CORNER, "0.21 mm", "0.24 mm", "0.26 mm", "0.0%", "NO WORSE"),
        ("direction 3", "0 mm", "0.15 mm, cracks", "0.20 mm", "6.1%", "FAILS"),
        ("load coat", "0.10 mm", "0.11 mm", "0.20 mm", "0.0%", "HOLDS"),
        ("load coat", "–", "gives way", "0.20 mm", "0.0%", "FAILS"),
    ]


def test_of_a_part_by_itself_the_table_has_one_column_of_figures():
    headings, rows = sentences.tabulated(verdict(row(0.06, plain_permanent_set=None)))
    assert headings == ("test", "stays bent", "allowed", "strain", "outcome")
    assert rows == [("flat", "0.06 mm", "0.20 mm", "0.0%", "HOLDS")]
    assert sentences.tabulated(verdict(FLAT))[0] == COLUMNS


def test_by_the_published_rule_the_column_of_stresses_is_not_called_what_stays_bent():
    headings, rows = sentences.tabulated(verdict(published_row(60.0, plain_permanent_set=None)))
    assert headings == ("test", "largest stress", "allowed", "strain", "outcome")
    assert rows == [("published rule", "60.0 MPa", "45.6 MPa", "–", "FAILS")]


def test_several_runs_of_one_part_stand_side_by_side():
    assert sentences.paired([verdict(BENT, TILTED), verdict(FLAT, COAT)]) == [
        ("flat", "0.02 mm", "1.24 mm FAILS", "0.06 mm HOLDS", "0.20 mm"),
        (CORNER, "0.21 mm", "0.24 mm NO WORSE", "–", "0.26 mm"),
        ("load coat", "0.10 mm", "–", "0.11 mm HOLDS", "0.20 mm"),
    ]


# --- beside other things ------------------------------------------------------------------------------------------


def test_under_a_picture_stands_what_it_is_of():
    assert note(verdict(FLAT, TILTED)) == f"NO WORSE than the plain part; {CORNER}: 0.24 mm of 0.26 mm"
    assert note(verdict(FLAT, doubts=(MISSED,))).startswith(f"HOLDS a fall of 1.5 m {NOT_SURE}; flat: ")
    assert note(UNKNOWN) == "UNKNOWN: this test gave no answer"
    assert sentences.least(UNKNOWN) == ""


def test_an_outcome_is_marked_where_it_is_not_sure_and_never_where_there_is_none():
    assert [sentences.marked(outcome, sure=sure) for outcome, sure in (("HOLDS", True), ("FAILS", False), ("UNKNOWN", False))] == [
        "HOLDS", "FAILS (not sure)", "UNKNOWN",
    ]  # fmt: skip


# --- words --------------------------------------------------------------------------------------------------------

WORDS = "told|borne|breaks?|viable|marginal|safe|survives?|height|reserve|as it came|as it comes|beside the original"
BANNED = re.compile(rf"\b({WORDS})\b|None|nan|  | [,;:]", re.IGNORECASE)


@pytest.mark.parametrize("judged", [one for one, _ in (*HEADS, *DOUBTS)])
def test_no_sentence_says_more_than_a_simulation_knows(judged):
    said = [head(judged), doubt(judged), short(judged), note(judged), sentences.least(judged)]
    said += [cell for cells in sentences.tabulated(judged)[1] for cell in cells]
    for words in said:
        assert not BANNED.search(words.replace(" break it", "")), words
        assert "\n" not in words
    assert len(head(judged)) < 240


def test_how_it_is_judged_is_five_short_sentences_and_every_outcome_has_a_meaning():
    assert len(EXPLANATION) == 5
    assert set(MEANINGS) == set(get_args(Outcome))
    for words in (*EXPLANATION, *MEANINGS.values()):
        assert len(words.split()) <= 30


def test_a_verdict_names_the_print_that_is_meant():
    assert VERDICT.head.endswith(". Solid PLA.")
    printed = recipe(infill=0.15, walls=1).printed.words
    assert verdict(printed=printed).head.endswith(
        ". Printed in PLA: 1 wall of 0.42 mm, 5 solid layers of 0.2 mm on top and 4 below, 15 % gyroid."
    )
    assert "no infill" in recipe(infill=0.0).printed.words
    assert recipe(walls=1, top=0).printed.words == "solid"
