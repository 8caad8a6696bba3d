"""Ways up to print a part: ranked by what layers bear, dropped no more often than it takes."""

import re

import msgspec
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.records import judge
from mechstyle.records.material import LIBRARY
from mechstyle.runs.orient import WayUp, ways_up
from support import ROOT
from support.kills import on_a_block


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    return on_a_block(tmp_path_factory.mktemp("orient") / "run")


def of_another_material(run, **changes):
    """The run as if its material had other layers: the way up asks for nothing else of it."""
    recipe = run.recipe
    material = msgspec.structs.replace(recipe.test.material, **changes)
    return recipe.with_settings(material=material)


def test_up_and_down_are_one_drop_and_what_layers_bear_is_what_build_direction_says(block):
    found = ways_up(block, count=4)
    bend = {way.up: way.permanent_set for way in found.ways}
    axes = {max(up, tuple(0.0 - part for part in up)) for up in bend}
    assert found.drops == len(axes) < len(found.ways)
    assert all(bend[up] == bend[other] for up in bend for other in bend if np.allclose(np.add(up, other), 0.0))
    layered = block.recipe.with_settings(build_direction=(0.0, 0.0, 1.0))
    simulation = block.simulator(layered).simulate(block.checkpoint().displacement, thorough=True)
    worst = judge(simulation, None, layered).deciding
    upright = next(way for way in found.ways if way.up == (0.0, 0.0, 1.0))
    assert (upright.permanent_set, upright.used) == (pytest.approx(worst.permanent_set, rel=1e-6), pytest.approx(worst.used, rel=1e-6))
    assert [way.rank for way in found.ways] == sorted(way.rank for way in found.ways)


def test_what_uses_little_of_what_is_allowed_is_chosen_by_overhang():
    """Between a tenth and a third of the tolerance there is nothing to choose; beyond it there is."""
    ways = [
        WayUp(name=name, up=(0.0, 0.0, 1.0), permanent_set=0.2 * used, used=used, overhang=over, height=10.0, base=1.0)
        for name, used, over in (("safest", 0.1, 90.0), ("easiest", 0.3, 10.0), ("bent", 1.4, 0.0))
    ]
    assert [way.name for way in sorted(ways, key=lambda way: way.rank)] == ["easiest", "safest", "bent"]


def test_the_page_on_printing_says_up_to_which_share_ways_up_count_as_alike():
    page = (ROOT / "docs" / "printing.md").read_text(encoding="utf-8")
    share = 0.01 * float(re.search(r"use less than (\d+) % of what may stay bent count as alike, above it those in one tenth", page)[1])
    used = (0.0, share - 0.01, share + 0.01, share + 0.09, share + 0.11)
    least, most, above, beside, beyond = (
        WayUp(name="", up=(0.0, 0.0, 1.0), permanent_set=0.1, used=one, overhang=0.0, height=1.0, base=1.0).rank for one in used
    )
    assert least == most < above == beside < beyond


@pytest.mark.parametrize(("ratio", "bend"), [(None, None), (1.0, "as it was")])
def test_no_drop_is_run_where_it_could_tell_nothing(block, monkeypatch, ratio, bend):
    assert LIBRARY["ABS"].layer_ratio is None
    recipe = of_another_material(block, layer_ratio=ratio)
    monkeypatch.setattr(type(block.store), "recipe", lambda *_: recipe)
    found = ways_up(block, count=3)
    assert found.drops == 0
    expected = None if bend is None else judge(block.simulation(), None, recipe).deciding.permanent_set
    assert {way.permanent_set for way in found.ways} == {expected}
    assert ("not known" in found.layers) == (ratio is None)


def test_a_number_of_ways_nobody_means_is_refused(block):
    with pytest.raises(BadInput, match="0 ways up"):
        ways_up(block, count=0)
