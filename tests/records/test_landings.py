"""Ways to land and drop standards: what a standard brings, what it is called, and that nothing claims more."""

from __future__ import annotations

import pytest

from mechstyle.errors import BadInput
from mechstyle.records import POSES
from mechstyle.records.landings import STANDARDS, landings_after, with_drops
from mechstyle.records.recipe import DEFAULTS, described
from support.records import recipe

PRESCRIBED = {
    "mil-810h": ("box26", 1220.0),
    "ista-1a": ("box10", 760.0),
    "en71": ("box26", 850.0),
    "astm-f963": ("fibonacci", 1372.0),
    "astm-f963-96": ("fibonacci", 914.0),
}
LANDINGS = ("poses", "orientations", "height")


def landings_of(settings):
    return {name: settings[name] for name in LANDINGS if name in settings}


def test_the_standards_are_those_that_are_known_by_name():
    assert {name: (standard.poses, standard.height) for name, standard in STANDARDS.items()} == PRESCRIBED
    assert [STANDARDS[name].orientations for name in ("astm-f963", "astm-f963-96")] == [10, 4]
    assert all(name in described("standard") for name in STANDARDS)
    assert {standard.poses for standard in STANDARDS.values()} <= set(POSES)


@pytest.mark.parametrize("name", STANDARDS)
def test_a_standard_brings_its_landings_and_its_height_unless_given(name):
    standard = STANDARDS[name]
    own = {"poses": standard.poses, "orientations": standard.orientations, "height": standard.height}
    assert landings_of(with_drops({"standard": name})) == own
    assert landings_of(with_drops({"standard": name, "height": 500.0})) == own | {"height": 500.0}
    assert landings_of(with_drops({"standard": name, "orientations": 3})) == own | {"orientations": 3}
    other = landings_of(with_drops({"standard": name, "poses": "resting"}))
    assert other == own | {"poses": "resting", "orientations": POSES["resting"]}, "other poses take their own number of drops"


def test_without_a_standard_nothing_is_brought():
    assert with_drops({}) == {}
    assert with_drops({"standard": "", "seed": 3}) == {"standard": "", "seed": 3}


@pytest.mark.parametrize("name", STANDARDS)
def test_words_are_of_orientations_and_never_of_a_test_that_was_met(name):
    one = recipe(**with_drops({"standard": name}))
    assert one.test.after_standard == f"simulated orientations after {STANDARDS[name].title}"
    for words in (one.test.after_standard, STANDARDS[name].departs, STANDARDS[name].title, described("standard")):
        assert not any(claim in words.lower() for claim in ("pass", "compl", "certif", "conform", "according"))
    assert STANDARDS[name].departs.endswith(".")
    assert "undamaged" in STANDARDS[name].departs


def test_what_departs_from_the_standard_is_said():
    other = recipe(**with_drops({"standard": "mil-810h", "orientations": 5, "height": 500.0}))
    assert other.test.after_standard.endswith(", but 5 orientations instead of 27, 50 cm instead of 1.22 m")
    resting = landings_after("ista-1a", poses="resting", orientations=11, height=760.0)
    assert resting.endswith(", but poses resting instead of box10")
    assert recipe().test.after_standard == ""


def test_a_standard_that_is_not_known_is_refused_with_the_nearest():
    with pytest.raises(BadInput, match="unknown standard 'mil-810g': did you mean 'mil-810h'"):
        recipe(standard="mil-810g")
    assert DEFAULTS["standard"] == ""
