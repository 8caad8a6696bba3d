"""Load cases as people write them: what is understood, and what a file that cannot be used is told."""

import pickle
import re

import msgspec
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.records.load_cases import SHAPES, Load, LoadCase, Patch, Support, load_cases, read_loads
from mechstyle.records.regions import Box, HalfSpace, Inside, Outside, Segment, Sphere, Vertices
from support import ROOT

HAND = """
[[case]]
name = "hand on the rim"
supports = [{ at = "resting face" }]
loads = [{ at = { sphere = [40, 0, 100, 8] }, force = [0, 0, -50] }, { gravity = 1 }]
"""
GRAVITY = "[[case]]\nname = 'shelf'\nsupports = [{ at = 'resting face' }]\nloads = [{ gravity = 1 }]\n"


@pytest.fixture
def file(tmp_path):
    """Writes a load file."""

    def write(text):
        path = tmp_path / "loads.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_a_file_says_what_python_would(file):
    hand = LoadCase(
        name="hand on the rim",
        supports=(Support(at="resting face"),),
        loads=(Load(at=Patch(sphere=(40.0, 0.0, 100.0, 8.0)), force=(0.0, 0.0, -50.0)), Load(gravity=1.0)),
    )
    assert read_loads(file(HAND)) == (hand,)
    assert load_cases(file(HAND)) == load_cases(hand) == load_cases([hand]) == (hand,)


def test_cases_come_back_from_json_as_they_were(file):
    cases = read_loads(file(HAND + GRAVITY))
    assert msgspec.json.decode(msgspec.json.encode(cases), type=tuple[LoadCase, ...]) == cases


def test_a_case_that_went_to_another_process_is_written_as_the_same_bytes(file):
    """A default that is equal and another object was written out, so that a recipe got another digest, and its rows were not found."""
    cases = read_loads(file(HAND + GRAVITY))
    assert msgspec.json.encode(pickle.loads(pickle.dumps(cases))) == msgspec.json.encode(cases)


def test_whole_numbers_and_lists_given_in_python_are_the_same_case(file):
    loose = LoadCase(
        name="hand on the rim",
        supports=[Support(at="resting face")],
        loads=[Load(at=Patch(sphere=[40, 0, 100, 8]), force=[0, 0, -50]), Load(gravity=1)],
    )
    assert msgspec.json.encode(load_cases([loose])) == msgspec.json.encode(read_loads(file(HAND)))


@pytest.mark.parametrize(
    ("region", "written"),
    [
        (Sphere((40, 0, 100), 8), "{ sphere = [40, 0, 100, 8] }"),
        (Sphere(np.array([40.0, 0.0, 100.0]), np.float64(8.0)), "{ sphere = [40, 0, 100, 8] }"),
        (Box((0, 0, 0), (10, 10, 0.5)), "{ box = [0, 0, 0, 10, 10, 0.5] }"),
        (HalfSpace((0, 0, 90), (0, 0, 1)), "{ plane = [0, 0, 90, 0, 0, 1] }"),
    ],
)
def test_a_region_is_the_place_of_that_shape_to_the_byte(file, region, written):
    case = LoadCase(name="hand on the rim", supports=(Support(at=region),), loads=(Load(at=region, pressure=1.0),))
    text = f"[[case]]\nname = 'hand on the rim'\nsupports = [{{ at = {written} }}]\nloads = [{{ at = {written}, pressure = 1 }}]"
    assert load_cases(case) == read_loads(file(text))
    assert msgspec.json.encode(load_cases(case)) == msgspec.json.encode(read_loads(file(text)))


@pytest.mark.parametrize("region", [Inside(), Outside(), Segment((1.0, 2.0, 3.0)), Vertices((1, 2))])
def test_a_region_that_is_no_shape_is_no_place_of_a_load(region):
    with pytest.raises(BadInput, match=rf"'{region.words}' is no place of a support or a load: write ms\.Sphere"):
        Support(at=region)


@pytest.mark.parametrize("region", [Sphere((0, 0, 0), 1, ramp=2), Sphere((0, 0, 0), 1, colour=True)])
def test_a_place_of_a_load_does_not_fade_and_has_no_colour(region):
    with pytest.raises(BadInput, match="no ramp and no colour"):
        Load(at=region, pressure=1.0)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[[case]]", "[[case]", "cannot be read"),
        ("[[case]]", "[[cases]]", "unknown key 'cases'"),
        ("[[case]]", "case = []\n[other]", "unknown key 'other'"),
        (HAND, "", "no load case: begin one with [[case]]"),
        ('name = "hand on the rim"\n', "", "case number 1: it is missing required field `name`"),
        ('"hand on the rim"', '" "', "a load case needs a name"),
        ('[{ at = "resting face" }]', "[]", "'hand on the rim' has no supports"),
        ("{ sphere = [40, 0, 100, 8] }", "{ spere = [40, 0, 100, 8] }", "unknown field `spere` at `loads[0].at`; a place is"),
        ("[40, 0, 100, 8]", "[40, 0, 100]", "length 4, got 3 at `loads[0].at.sphere`"),
        ("[40, 0, 100, 8]", "[40, 0, 100, -8]", "the radius of sphere [40, 0, 100, -8] is -8 mm"),
        ("[40, 0, 100, 8]", "[nan, 0, 100, 8]", "must be finite"),
        ("sphere = [40, 0, 100, 8]", "box = [0, 0, 9, 1, 1, 1]", "lowest corner first"),
        ("sphere = [40, 0, 100, 8]", "plane = [0, 0, 9, 0, 0, 0]", "no direction"),
        ("sphere = [40, 0, 100, 8]", "facet = [0, 0, 9], angle = 120", "angle is 120"),
        ("{ sphere = [40, 0, 100, 8] }", "{ }", "not nothing"),
        ("sphere = [40, 0, 100, 8]", "sphere = [40, 0, 100, 8], near = [0, 0, 1, 2]", "not sphere and near"),
        ('"resting face"', '"the table"', "`supports[0].at`; a place is 'resting face' or"),
        ('"resting face"', '"resting face", kind = "glued"', "'glued' at `supports[0].kind`"),
        ("[0, 0, -50]", "[0, 0, 0]", "force is zero"),
        ("[0, 0, -50]", "[0, 0, -50], pressure = 1", "not force and pressure"),
        ("{ gravity = 1 }", "{ gravity = 0 }", "gravity is zero"),
        ("{ gravity = 1 }", "{ gravity = 1, direction = [0, 0, 0] }", "direction of gravity is zero"),
        ("{ gravity = 1 }", "{ pressure = 1 }", "pressure needs a place"),
        ("{ gravity = 1 }", "{ gravity = 1, at = 'resting face' }", "gravity acts everywhere"),
    ],
)
def test_a_file_that_cannot_be_used_gets_one_sentence_with_file_and_reason(file, old, new, words):
    assert old in HAND
    path = file(HAND.replace(old, new))
    with pytest.raises(BadInput) as caught:
        read_loads(path)
    assert str(path) in str(caught.value)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_two_cases_of_one_name_and_other_objects_are_refused(file, tmp_path):
    with pytest.raises(BadInput, match="does not exist"):
        read_loads(tmp_path / "none.toml")
    with pytest.raises(BadInput, match="two cases are called 'shelf'"):
        read_loads(file(GRAVITY * 2))
    with pytest.raises(BadInput, match="a load file or a list of LoadCase"):
        load_cases([{"name": "shelf"}])


def test_the_file_in_the_documentation_is_understood(file):
    page = (ROOT / "docs" / "loads.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```toml\n(# coat\.toml.*?)```", page, re.DOTALL)
    coat, bump = read_loads(file(example))
    assert coat.loads[0].force == (0.0, -120.0, 0.0)
    assert [load.gravity for load in bump.loads] == [None, 1.0]
    assert all(f"{{ {shape} = [" in page for shape in SHAPES)
