"""A comparison: nothing but a finite error within its limit passes, and what cannot be run says why."""

import math

import pytest

from mechstyle.errors import BadInput, MissingPiece
from validation.cases import Case, bounded, compared, named


@pytest.mark.parametrize(("measured", "passed"), [(1.04, True), (0.96, True), (1.06, False), (math.nan, False), (math.inf, False)])
def test_only_a_finite_error_within_the_limit_passes(measured, passed):
    assert compared("a", measured, 1.0, 0.05).passed is passed
    assert bounded("a", abs(measured - 1.0), 0.05).passed is passed


def test_what_is_missing_is_not_run_and_says_why():
    def nothing():
        raise MissingPiece("there is no wind tunnel")
        yield

    (result,) = Case("wind", "In the wind", nothing).results()
    assert result.passed is None
    assert result.note == "there is no wind tunnel"


def test_a_case_is_found_by_its_name_or_refused_with_the_nearest():
    case = Case("wind", "In the wind", lambda: iter(()))
    assert named("wind", {"wind": case}) is case
    with pytest.raises(BadInput, match="did you mean 'wind'"):
        named("wint", {"wind": case})
