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
from mechstyle.records.sentences import COLUMNS, EXPLANATION, MEANINGS, NOT_SURE, doubt, head, length, note, paired, short, table
from mechstyle.records.written import written
from support.records import STRENGTH, UNKNOWN, load_row, published_row, row, verdict

SOLID = "Solid PLA, which yields at 45.6 MPa."
CORNER = "tilted 3° onto the left front corner"
FLAT = row(1900.0, original=2400.0)
TILTED = row(500.0, test="nearly flat", landing=CORNER, original=540.0, outcome="NO WORSE", limit=85.0)
DENTED = row(150.0, original=4800.0)
COAT = load_row(1.4, original=2.0)


def failing(one, original):
    return msgspec.structs.replace(one, outcome="FAILS", original=original, limit=STRENGTH)


# --- the head -----------------------------------------------------------------------------------------------------

HEADS = [
    (verdict(FLAT), "HOLDS a fall of 1.5 m (plain 2.4 m, brick 1.9 m)"),
    (verdict(row(1900.0), style=""), "HOLDS a fall of 1.5 m (it survives 1.9 m)"),
    (
        verdict(FLAT, COAT),
        "HOLDS a fall of 1.5 m (plain 2.4 m, brick 1.9 m) and the load 'coat' (plain 2.00 ×, brick 1.40 ×)",
    ),
    (
        verdict(FLAT, COAT, load_row(1.2, load="push", original=3.0)),
        (
            "HOLDS a fall of 1.5 m (plain 2.4 m, brick 1.9 m) and all 2 loads, of which the load 'push' (plain 3.00 ×, brick 1.20 ×)"
            " has the least reserve"
        ),
    ),
    (
        verdict(FLAT, TILTED),
        (
            f"NO WORSE than the plain part: flat it holds a fall of 1.5 m (plain 2.4 m, brick 1.9 m); {CORNER} it begins to yield"
            " below 1.5 m (plain 54 cm, brick 50 cm)"
        ),
    ),
    (
        verdict(row(1300.0, original=1400.0, outcome="NO WORSE", limit=50.0)),
        "NO WORSE than the plain part: flat it begins to yield below 1.5 m (plain 1.4 m, brick 1.3 m)",
    ),
    (
        verdict(FLAT, load_row(0.9, original=0.95, outcome="NO WORSE", limit=53.0)),
        (
            "NO WORSE than the plain part: flat it holds a fall of 1.5 m (plain 2.4 m, brick 1.9 m); under the load 'coat' it begins"
            " to yield before all of it acts (plain 0.95 ×, brick 0.90 ×)"
        ),
    ),
    (verdict(DENTED), "FAILS a fall of 1.5 m (plain 4.8 m, brick 15 cm)"),
    (
        verdict(DENTED, failing(row(30.0, test="nearly flat", landing="tilted 3° to the left front"), 150.0)),
        "FAILS a fall of 1.5 m (plain 4.8 m, brick 15 cm), and also tilted 3° to the left front (plain 15 cm, brick 3 cm)",
    ),
    (
        verdict(FLAT, failing(TILTED, 1800.0)),
        f"FAILS a fall of 1.5 m {CORNER} (plain 1.8 m, brick 50 cm); flat it holds a fall of 1.5 m (plain 2.4 m, brick 1.9 m)",
    ),
    (
        verdict(FLAT, failing(load_row(0.8), 2.0)),
        "FAILS the load 'coat' (plain 2.00 ×, brick 0.80 ×); flat it holds a fall of 1.5 m (plain 2.4 m, brick 1.9 m)",
    ),
    (
        verdict(row(1300.0, original=1400.0, outcome="NO WORSE", limit=50.0), failing(load_row(0.8), 2.0)),
        (
            "FAILS the load 'coat' (plain 2.00 ×, brick 0.80 ×); flat it is no worse than the plain part in a fall of 1.5 m"
            " (plain 1.4 m, brick 1.3 m)"
        ),
    ),
]  # fmt: skip


@pytest.mark.parametrize(("found", "words"), HEADS)
def test_the_head_says_the_outcome_and_the_figures_it_rests_on(found, words):
    assert head(found) == f"{words}. {SOLID}"
    assert head(found).startswith(found.outcome)


def test_where_there_is_no_answer_the_head_says_why():
    assert head(UNKNOWN) == "UNKNOWN: the integration blew up."
    assert head(msgspec.structs.replace(UNKNOWN, failure="It took too long.")) == "UNKNOWN: It took too long."


@pytest.mark.parametrize(("maximum", "said"), [(40.0, "HOLDS"), (90.0, "FAILS")])
def test_by_the_published_rule_the_head_is_about_the_literal_maximum(maximum, said):
    one = published_row(STRENGTH / maximum, decides=True)
    found = verdict(msgspec.structs.replace(row(1900.0), decides=False), one, criterion="paper")
    side = "at most" if said == "HOLDS" else "above"
    assert head(found) == (
        f"{said} by the published rule: the largest element stress is {maximum:.1f} MPa, {side} the 45.6 MPa at which PLA yields."
    )
    assert short(found) == f"{said} by the published rule"


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (verdict(FLAT), "HOLDS a fall of 1.5 m"),
        (verdict(FLAT, fall=1220.0), "HOLDS a fall of 1.22 m"),
        (verdict(FLAT, TILTED), "NO WORSE than the plain part"),
        (verdict(DENTED), "FAILS a fall of 1.5 m"),
        (verdict(FLAT, failing(load_row(0.8), 2.0)), "FAILS the load 'coat'"),
        (UNKNOWN, "UNKNOWN"),
    ],
)
def test_on_a_badge_it_is_a_few_words(found, words):
    assert short(found) == words


# --- the doubt ----------------------------------------------------------------------------------------------------


def near(value, test="flat", landing="flat", load=""):
    return Doubt(about="limit", value=value, test=test, landing=landing, load=load)


MISSED, SMALLER = Doubt(about="relief", value=0.78), Doubt(about="volume", value=-0.035)
DOUBTS = [
    (verdict(FLAT), ""),
    (UNKNOWN, ""),
    (
        verdict(FLAT, doubts=(near(1.04),)),
        "Not sure: flat passes by 4%, closer than the test repeats; ask for less relief or a lower fall.",
    ),
    (
        verdict(FLAT, style="", doubts=(near(1.04),)),
        "Not sure: flat passes by 4%, closer than the test repeats; ask for a lower fall.",
    ),
    (
        verdict(DENTED, doubts=(near(0.97, "nearly flat", CORNER),)),
        f"Not sure: {CORNER} fails by 3%, closer than the test repeats; less relief or a lower fall may pass.",
    ),
    (
        verdict(FLAT, COAT, doubts=(near(1.001), near(1.02, "load", "", "coat"))),
        (
            "Not sure: flat passes by less than 1% and the load 'coat' passes by 2%, closer than these tests repeat; ask for less relief"
            " or a lower fall or a smaller load."
        ),
    ),
    (verdict(FLAT, doubts=(MISSED,)), "Not sure: the mesh follows only 78% of the relief; ask for more vertices."),
    (
        verdict(FLAT, doubts=(near(1.04), MISSED, SMALLER)),
        (
            "Not sure: flat passes by 4%, closer than the test repeats; ask for less relief or a lower fall; the mesh follows only 78%"
            " of the relief and the volume of the mesh is -3.5% off that of the part; ask for more vertices."
        ),
    ),
]  # fmt: skip


@pytest.mark.parametrize(("found", "words"), DOUBTS)
def test_the_doubt_says_what_is_not_sure_and_what_to_do_once(found, words):
    assert doubt(found) == words


@pytest.mark.parametrize(
    ("about", "words"), [("relief", "what the mesh follows of the relief is not known"), ("volume", "the volume of the mesh is not known")]
)
def test_a_share_that_is_not_known_is_no_number(about, words):
    assert doubt(verdict(FLAT, doubts=(Doubt(about=about, value=math.nan),))) == f"Not sure: {words}; ask for more vertices."


# --- the table ----------------------------------------------------------------------------------------------------

SHOWN = msgspec.structs.replace(TILTED, decides=False, outcome="FAILS", original=None)


def test_the_table_has_a_row_for_each_test_and_judges_only_what_decides():
    assert table(verdict(FLAT, TILTED, COAT, published_row(0.5, original=0.8))) == [
        ("flat", "2.4 m", "1.9 m", "1.5 m", "+27%", "HOLDS"),
        (f"nearly flat: {CORNER}", "54 cm", "50 cm", "1.5 m", "+16%", "NO WORSE"),
        ("load coat", "2.00 ×", "1.40 ×", "1 ×", "+40%", "HOLDS"),
        ("published rule", "0.80 ×", "0.50 ×", "1 ×", "-50%", "not judged"),
    ]


def test_of_a_part_by_itself_the_table_has_one_column_of_figures():
    headings, rows = sentences.tabulated(verdict(row(1900.0), SHOWN, published_row()))
    assert headings == ("test", "survives", "asked", "reserve", "outcome")
    assert [cells[-1] for cells in rows] == ["HOLDS", "not judged", "not judged"]
    assert all(len(cells) == len(headings) for cells in rows)
    assert sentences.tabulated(verdict(FLAT))[0] == COLUMNS


def test_several_runs_of_one_part_stand_side_by_side_and_the_published_rule_last():
    free, fed = verdict(DENTED, failing(TILTED, 540.0), published_row()), verdict(FLAT, published_row(), COAT)
    assert paired([free, fed]) == [
        ("flat", "4.8 m", "15 cm FAILS", "1.9 m HOLDS", "1.5 m"),
        ("nearly flat", "54 cm", "50 cm FAILS", "–", "1.5 m"),
        ("load coat", "2.00 ×", "–", "1.40 × HOLDS", "1 ×"),
        ("published rule", "–", "0.76 × not judged", "0.76 × not judged", "1 ×"),
    ]


def test_in_full_every_test_is_a_line_between_how_it_is_judged_and_the_doubt():
    found = verdict(FLAT, TILTED, doubts=(MISSED,))
    first, said, flat, nearly, last = sentences.in_full(found).splitlines()
    assert (first, said, last) == (" ".join(EXPLANATION), head(found), doubt(found))
    assert flat == "flat: plain 2.4 m, styled 1.9 m, asked 1.5 m, reserve +27%, outcome HOLDS"
    assert nearly.startswith(f"nearly flat: {CORNER}: plain 54 cm")


# --- beside other things ------------------------------------------------------------------------------------------


def test_under_a_picture_stands_the_stress_of_the_test_it_is_of():
    assert note(verdict(FLAT, TILTED)) == f"NO WORSE than the plain part; {CORNER}: {TILTED.stress:.1f} of 85.0 MPa"
    assert note(verdict(FLAT, doubts=(MISSED,))).startswith(f"HOLDS a fall of 1.5 m {NOT_SURE}; flat: ")
    assert note(UNKNOWN) == "UNKNOWN: this test gave no answer"
    others = row(400.0, test="any landing", landing="direction 3", outcome="NO WORSE", limit=90.0)
    assert sentences.figures(others) == f"direction 3; the mean of all other landings is {others.stress:.1f} of 90.0 MPa"


def test_the_test_with_the_least_reserve_is_named_with_its_landing():
    assert sentences.least(verdict(row(9000.0, original=9500.0), TILTED)) == f"nearly flat: {CORNER}: plain 54 cm, brick 50 cm"
    assert sentences.least(UNKNOWN) == ""
    marked = sentences.least_left("soft", verdict(FLAT), {"main": 41.2, "soft": 44.6})
    assert marked == (
        "✕ marks where soft has least left (flat: plain 2.4 m, brick 1.9 m); stress there, each in the test that decides: main 41 MPa,"
        " soft 45 MPa."
    )


def test_an_outcome_is_marked_where_it_is_not_sure_and_never_where_there_is_none():
    assert [sentences.marked(outcome, sure=sure) for outcome, sure in (("HOLDS", True), ("FAILS", False), ("UNKNOWN", False))] == [
        "HOLDS", "FAILS (not sure)", "UNKNOWN",
    ]  # fmt: skip


# --- lengths ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("height", "words"),
    [
        (1.0, "1 mm"), (9.4, "9 mm"), (9.6, "1 cm"), (152.0, "15 cm"), (994.0, "99 cm"), (996.0, "1.0 m"), (1540.0, "1.5 m"),
        (9940.0, "9.9 m"), (9960.0, "10 m"), (10_000.0, "10 m"), (10_001.0, "more than 10 m"), (1e5, "more than 10 m"),
    ],
)  # fmt: skip
def test_a_height_is_told_as_a_person_would(height, words):
    assert length(height) == words


@pytest.mark.parametrize(
    ("height", "words"), [(1500.0, "1.5 m"), (1220.0, "1.22 m"), (1372.5, "1.3725 m"), (760.0, "76 cm"), (9.0, "9 mm"), (1000.0, "1 m")]
)
def test_what_was_asked_for_is_told_as_it_was_asked(height, words):
    assert written(height) == words


@given(st.floats(1.0, 1e5), st.floats(1.0, 1e5))
def test_a_greater_height_never_reads_as_a_smaller_one(one, other):
    units = {"mm": 1.0, "cm": 10.0, "m": 1000.0}

    def read(words):
        number, unit = words.removeprefix("more than ").split()
        return float(number) * units[unit]

    low, high = sorted((one, other))
    assert read(length(low)) <= read(length(high)) + 1e-9


# --- words --------------------------------------------------------------------------------------------------------

WORDS = "told|borne|breaks?|broken|viable|marginal|safe|as it came|as it comes|beside the original"
BANNED = re.compile(rf"\b({WORDS})\b|None|nan|  ", re.IGNORECASE)
ALL = [one for one, _ in (*HEADS, *DOUBTS)]


@pytest.mark.parametrize("found", ALL)
def test_no_sentence_says_more_than_a_simulation_knows(found):
    said = [head(found), doubt(found), short(found), note(found), sentences.least(found)]
    said += [cell for cells in table(found) for cell in cells]
    for words in said:
        assert not BANNED.search(words), words
        assert "\n" not in words
    assert len(head(found)) < 320


def test_how_it_is_judged_is_five_short_sentences_and_every_outcome_has_a_meaning():
    assert len(EXPLANATION) == 5
    for words in (*EXPLANATION, *MEANINGS.values()):
        assert not BANNED.search(words), words
        assert len(words.split()) <= 30
    assert set(MEANINGS) == set(get_args(Outcome))


def test_what_a_part_survives_is_found_by_the_test_alone():
    assert sentences.survived(verdict(FLAT, TILTED, COAT)) == {"flat": "1.9 m", "nearly flat": "50 cm", "load coat": "1.40 ×"}


# --- two runs beside each other -----------------------------------------------------------------------------------

TWO = ("Freestyle", "MechStyle")


@pytest.mark.parametrize(
    ("free", "fed", "kept", "words"),
    [
        ((row(200.0),), (row(1900.0),), (1.0, 0.97), "Both look alike. Freestyle may fall from 20 cm, MechStyle from 1.9 m; 1.5 m"),
        ((row(1900.0),), (row(1950.0),), (0.94, 0.6),  # the shares that badge and table have, not 64 %
         "MechStyle keeps 60% of the relief, Freestyle 94%. Freestyle and MechStyle may both fall from 1.9 m; 1.5 m"),
        ((FLAT, TILTED), (FLAT, row(1800.0, test="nearly flat", landing=CORNER)), (None, None),
         "Freestyle may fall from 50 cm, MechStyle from 1.8 m, landing nearly flat; 1.5 m"),
        ((FLAT, load_row(0.5)), (FLAT, COAT), (1.0, 1.0),
         "Both look alike. Freestyle may carry the load 'coat' 0.50 times, MechStyle 1.40 times; once"),
    ],
)  # fmt: skip
def test_two_runs_are_compared_in_the_test_that_decides(free, fed, kept, words):
    said = sentences.side_by_side(TWO, (verdict(*free), verdict(*fed)), kept)
    assert said == f"{words} was asked for."
    assert not BANNED.search(said)


def test_without_an_answer_nothing_is_compared():
    assert "nothing to compare" in sentences.side_by_side(TWO, (UNKNOWN, verdict(FLAT)), (1.0, 1.0))


def test_where_little_of_the_style_is_left_it_is_said_how_to_keep_more():
    """A pill box in brick keeps a third with cuts, since its walls bend as a whole, and all of it with relief outwards."""
    said = sentences.little_left(0.33, "auto")
    assert said.startswith("only 33% of the style is left")
    assert "--side outwards" in said
    assert not BANNED.search(said)
    assert sentences.little_left(0.33, "outwards") == sentences.little_left(0.95, "auto") == ""
