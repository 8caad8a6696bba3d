"""Heights of fall and tolerances: what is read, what is asked about, and what is refused."""

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechstyle.errors import BadInput
from mechstyle.records.written import LEAST_BARE, length_of, share_of, tolerance_of, written


@pytest.mark.parametrize(
    "text", ["1.5 m", "1.5m", "1,5 m", "150 cm", "1500 mm", "1500mm", "1500", " 1500 ", "1.5 M", "1.5e3", "+1500", "1500.", 1500, 1500.0]
)
def test_a_height_is_read_in_every_unit_and_a_bare_number_is_in_millimetres(text):
    assert length_of(text) == 1500.0


@pytest.mark.parametrize(
    ("text", "length"), [("4 cm", 40.0), ("30 mm", 30.0), ("0,125 m", 125.0), (".5 m", 500.0), (50, 50.0), ("1.220 m", 1220.0)]
)
def test_a_unit_leaves_nothing_to_ask(text, length):
    assert length_of(text) == length


@pytest.mark.parametrize("value", [1.5, "1.5", "1,5"])
def test_a_bare_number_too_small_for_millimetres_is_asked_about(value):
    with pytest.raises(BadInput) as caught:
        length_of(value)
    assert str(caught.value) == 'a height of 1.5 would be 1.5 mm: write "1.5 m", "1.5 cm" or "1.5 mm"'


def test_the_least_bare_number_is_read_and_the_next_below_is_not():
    assert length_of(LEAST_BARE) == LEAST_BARE
    with pytest.raises(BadInput, match="would be 49 mm"):
        length_of(49)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (math.nan, "a height of nan is no fall"),
        (math.inf, "a height of inf is no fall"),
        (10**400, "a height of inf is no fall"),
        (-1500, "a height of -1500 is no fall"),
        ("-1.5 m", "a height of -1.5 m is no fall"),
        (0, "a height of 0 is no fall"),
        ("0 m", "a height of 0 m is no fall"),
        ("1e999 m", "a height of inf m is no fall"),
        ("nan", "cannot read 'nan' as a height"),
        ("inf m", "cannot read 'inf m' as a height"),
        ("", "cannot read '' as a height"),
        ("   ", "cannot read '   ' as a height"),
        ("m", "cannot read 'm' as a height"),
        ("high", "cannot read 'high' as a height"),
        (True, "cannot read True as a height"),
        (None, "cannot read None as a height"),
        ([1500], "cannot read [1500] as a height"),
        ("5 ft", "a height is in m, cm or mm, not in 'ft'"),
        ("60 in", "a height is in m, cm or mm, not in 'in'"),
        ('60"', "a height is in m, cm or mm, not in '\"'"),
        ("1.5 m m", "a height is in m, cm or mm, not in 'm m'"),
        ("1.5.2 m", "a height is in m, cm or mm, not in '.2 m'"),
        ("1 m 50", "a height is in m, cm or mm, not in 'm 50'"),
        ("1,500 mm", "1,500 can be read as 1500 or as 1.500: write it without a comma"),
    ],
)  # fmt: skip
def test_what_is_no_height_is_refused_in_one_sentence(value, said):
    with pytest.raises(BadInput) as caught:
        length_of(value)
    message = str(caught.value)
    assert message.startswith(said)
    assert "write" in message
    assert "\n" not in message
    assert len(message) < 160


@pytest.mark.parametrize(
    ("length", "text"),
    [
        (1500.0, "1.5 m"),
        (1220.0, "1.22 m"),
        (1000.0, "1 m"),
        (760.0, "76 cm"),
        (125.0, "12.5 cm"),
        (40.0, "4 cm"),
        (5.0, "5 mm"),
        (1.5, "1.5 mm"),
    ],
)
def test_a_height_is_written_in_the_unit_of_people(length, text):
    assert written(length) == text


@given(st.floats(1e-3, 1e6))
def test_what_is_written_is_read_to_the_last_digit(length):
    assert length_of(written(length)) == length


@pytest.mark.parametrize(
    ("text", "tolerance"),
    [
        ("0.2 mm", 0.2),
        ("200 µm", 0.2),
        ("200 μm", 0.2),
        ("200um", 0.2),
        ("0,3 mm", 0.3),
        ("0.05 CM", 0.5),
        (".2", 0.2),
        (0.2, 0.2),
        (1, 1.0),
    ],
)
def test_a_tolerance_is_read_in_small_units_and_a_bare_number_is_in_millimetres(text, tolerance):
    assert tolerance_of(text) == pytest.approx(tolerance, rel=1e-12)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("2 m", "a tolerance is in mm or µm, not in 'm'"),
        ("0.2 in", "a tolerance is in mm or µm, not in 'in'"),
        ("5 %", "a tolerance is in mm or µm, not in '%'"),
        ("-1", "a tolerance of -1 is none"),
        ("0 mm", "a tolerance of 0 mm is none"),
        (math.nan, "a tolerance of nan is none"),
        (math.inf, "a tolerance of inf is none"),
        ("", "cannot read '' as a tolerance"),
        ("tight", "cannot read 'tight' as a tolerance"),
        (True, "cannot read True as a tolerance"),
        (None, "cannot read None as a tolerance"),
    ],
)
def test_what_is_no_tolerance_is_refused_in_one_sentence(value, said):
    with pytest.raises(BadInput) as caught:
        tolerance_of(value)
    assert str(caught.value) == f'{said}: write "0.2 mm" or "200 µm"'


@pytest.mark.parametrize(
    ("text", "share"), [("15 %", 0.15), ("15%", 0.15), ("0.15", 0.15), (0.15, 0.15), (1.0, 1.0), ("100 %", 1.0), ("0 %", 0.0)]
)
def test_an_infill_is_a_share(text, share):
    assert share_of(text) == pytest.approx(share)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("15", 'write "15 %"'), (40, 'write "40 %"'), ("120 %", 'write "15 %" or 0.15'), ("-5 %", 'write "15 %" or 0.15'),
        ("15 mm", "an infill is a share such as 15 %, not in 'mm'"), ("much", "cannot read 'much' as an infill"),
    ],
)  # fmt: skip
def test_what_is_no_infill_is_refused_with_what_was_meant(text, said):
    with pytest.raises(BadInput, match=re.escape(said)):
        share_of(text)
