"""Protected regions as records: read from words, kept in recipes, refused in one sentence."""

import msgspec
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.records import Recipe
from mechstyle.records.material import LIBRARY
from mechstyle.records.regions import (
    ENDS,
    KINDS,
    Box,
    End,
    HalfSpace,
    Holes,
    Inside,
    Outside,
    Region,
    Rim,
    Segment,
    Sides,
    Sphere,
    Vertices,
    region,
    regions,
)  # fmt: skip

WRITTEN = {
    "box 0 0 0 10 20 30": Box((0.0, 0.0, 0.0), (10.0, 20.0, 30.0)),
    "sphere 1 2 3 4.5": Sphere((1.0, 2.0, 3.0), 4.5),
    "plane 0 0 5 1 0 1": HalfSpace((0.0, 0.0, 5.0), (1.0, 0.0, 1.0)),
    "above 12": HalfSpace((0.0, 0.0, 12.0), (0.0, 0.0, 1.0)),
    "below 12": HalfSpace((0.0, 0.0, 12.0), (0.0, 0.0, -1.0)),
    "inside": Inside(),
    "outside ramp 3": Outside(ramp=3.0),
    "sides": Sides(),
    "rim": Rim(),
    "rim 4.5 ramp 2": Rim(4.5, ramp=2.0),
    "holes": Holes(),
    "holes 6 ramp 1": Holes(6.0, ramp=1.0),
    **{end: End(end) for end in ENDS},
    "top 20 colour": End("top", 20.0, colour=True),
    "segment 1 2 3 colour": Segment((1.0, 2.0, 3.0), colour=True),
    "vertices 3 1 2 ramp 0.5 colour": Vertices((3, 1, 2), ramp=0.5, colour=True),
}


@pytest.mark.parametrize("text", WRITTEN)
def test_what_people_write_is_read(text):
    assert region(text) == WRITTEN[text]


@pytest.mark.parametrize("one", WRITTEN.values(), ids=list(WRITTEN))
def test_words_read_back_as_the_same_region(one):
    assert region(one.words) == one


def test_every_kind_is_tried_here():
    assert {text.split()[0] for text in WRITTEN} == set(KINDS)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("insde", "unknown region to protect 'insde': did you mean 'inside'"),
        ("", "unknown region"),
        ("box 0 0 0 10 10", "write box x y z x y z"),
        ("sphere 0 0 0 big", "write sphere x y z radius"),
        ("inside 3", "cannot read the region 'inside 3'"),
        ("inside ramp", "cannot read the region 'inside ramp'"),
        ("inside ramp -1", "ramp of a protected region is -1 mm"),
        ("inside ramp nan", "ramp of a protected region is nan mm"),
        ("rim wide", "write rim [width]"),
        ("rim -1", "width of a rim is -1 mm"),
        ("top inf", "depth of the top is inf mm"),
        ("left 1 2", "write left [depth]"),
        ("vertices 1.5", "write vertices i j k"),
        ("vertices", "at least one number"),
        ("vertices 3 -1", "none below zero"),
        ("box 0 0 0 10 -1 10", "lower than the second"),
        ("sphere 0 0 0 0", "radius above zero"),
        ("sphere 0 0 inf 1", "three finite numbers"),
        ("plane 0 0 0 0 0 0", "normal that is not zero"),
    ],
)
def test_what_cannot_be_is_refused_in_one_sentence(text, said):
    with pytest.raises(BadInput) as caught:
        region(text)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("given", [[3], [None], ["inside", {"kind": "box"}], [("box", 1)]])
def test_what_is_no_region_is_refused(given):
    with pytest.raises(BadInput, match="no region to protect"):
        regions(given)


@pytest.mark.parametrize("make", [lambda: Box((0, 0), (1, 1)), lambda: Box((0, 0, 0), (1, 1, "a")), lambda: Segment((1.0, np.nan, 2.0))])
def test_points_that_are_none_are_refused(make):
    with pytest.raises(BadInput, match="three finite numbers"):
        make()


def test_one_region_or_several_in_any_form_are_one_recipe():
    """1 and 1.0, lists and arrays must not make different runs of the same request."""
    assert regions("inside") == (Inside(),)
    ints, arrays = Sphere((1, 2, 3), 4), Sphere(np.array([1.0, 2.0, 3.0]), np.float64(4))
    assert regions([ints]) == regions(arrays) == regions(["sphere 1 2 3 4"])
    assert msgspec.json.encode(regions(ints)) == msgspec.json.encode(regions(arrays)) == msgspec.json.encode(regions("sphere 1 2 3 4"))


def test_a_recipe_keeps_its_regions_through_json():
    kept = tuple(WRITTEN.values())
    recipe = Recipe.of(surface="s", tetrahedra="t", prompt="brick", material=LIBRARY["PLA"], protect=kept)
    back = msgspec.json.decode(msgspec.json.encode(recipe), type=Recipe)
    assert back == recipe
    assert back.digest == recipe.digest
    assert back.digest != recipe.with_settings(protect=()).digest


def test_a_stored_region_is_checked_like_a_new_one():
    with pytest.raises(BadInput, match="radius above zero"):
        msgspec.json.decode(b'{"kind":"sphere","centre":[0,0,0],"radius":-1}', type=Region)
