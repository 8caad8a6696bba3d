"""Ways up to print a part: ranked by what layers bear, dropped no more often than it takes."""

import msgspec
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.material import LIBRARY
from mechstyle.runs.orient import ways_up
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
    stress = {way.up: way.stress for way in found.ways}
    axes = {max(up, tuple(0.0 - part for part in up)) for up in stress}
    assert found.drops == len(axes) < len(found.ways)
    assert all(stress[up] == stress[other] for up in stress for other in stress if np.allclose(np.add(up, other), 0.0))
    layered = block.recipe.with_settings(build_direction=(0.0, 0.0, 1.0))
    simulation = block.simulator(layered).simulate(block.checkpoint().displacement, thorough=False)
    assert stress[0.0, 0.0, 1.0] == pytest.approx(simulation.flat.stress, rel=1e-6)
    assert stress[0.0, 0.0, 1.0] >= block.simulation().flat.stress * (1.0 - 1e-6), "layers only make it weaker"
    assert [way.rank for way in found.ways] == sorted(way.rank for way in found.ways)
    assert found.ways[0].demand <= min(way.demand for way in found.ways) + 0.05


def test_loads_pull_at_layers_as_the_drop_does(block, monkeypatch):
    """Held at one side and pressed down at the other it is bent, which pulls at layers along its length."""
    plain = {way.up: way.stress for way in ways_up(block, count=3).ways}
    ends = [Patch(plane=(at, 0.0, 0.0, out, 0.0, 0.0)) for at, out in ((0.1, -1.0), (9.9, 1.0))]
    case = LoadCase(name="hung", supports=(Support(at=ends[0]),), loads=(Load(at=ends[1], force=(0.0, 0.0, -4000.0)),))
    recipe = block.recipe.with_settings(loads=(case,))
    monkeypatch.setattr(type(block.store), "recipe", lambda *_: recipe)
    loaded = {way.up: way.stress for way in ways_up(block, count=3).ways}
    assert loaded[1.0, 0.0, 0.0] > 1.1 * plain[1.0, 0.0, 0.0]


@pytest.mark.parametrize(("ratio", "stress"), [(None, None), (1.0, "as it was")])
def test_no_drop_is_run_where_it_could_tell_nothing(block, monkeypatch, ratio, stress):
    assert LIBRARY["ABS"].layer_ratio is None
    recipe = of_another_material(block, layer_ratio=ratio)
    monkeypatch.setattr(type(block.store), "recipe", lambda *_: recipe)
    found = ways_up(block, count=3)
    assert found.drops == 0
    expected = None if stress is None else block.simulation().flat.stress
    assert {way.stress for way in found.ways} == {expected}
    assert ("not known" in found.layers) == (ratio is None)


def test_a_number_of_ways_nobody_means_is_refused(block):
    with pytest.raises(BadInput, match="0 ways up"):
        ways_up(block, count=0)
