"""Recipe, row, verdict, simulation, checkpoint: checked, frozen, named by their content."""

import dataclasses
import hashlib
import json
import math
import os
import subprocess
import sys
from functools import reduce
from operator import getitem

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechstyle.errors import BadInput
from mechstyle.records import CONTROLS, Checkpoint, Recipe, Simulation
from mechstyle.records.checkpoint import restrained
from mechstyle.records.load_cases import Load, LoadCase, Support, read_loads
from mechstyle.records.material import LIBRARY
from mechstyle.records.recipe import CHAPTER_OF, CHOICES, LIMITS, SETTINGS, settings_of
from mechstyle.records.regions import Inside, regions
from support.records import landing, load_result, recipe

PLA = LIBRARY["PLA"]
PRESS = LoadCase(name="press", supports=(Support(at="resting face"),), loads=(Load(gravity=2.0),))
NAMES = CHOICES | {"transfer": ("barycentric", "nearest")}


def numbers(field):
    low, high = LIMITS[field]
    return st.integers(low, high) if isinstance(low, int) else st.floats(low, high)


recipes = st.builds(
    recipe,
    prompt=st.text(),
    loads=st.sampled_from([(), (PRESS,)]),
    nearly_flat=st.booleans(),
    guarantee=st.booleans(),
    **{field: numbers(field) for field in LIMITS},
    **{field: st.sampled_from(sorted(known)) for field, known in NAMES.items()},
)

# --- the recipe ---------------------------------------------------------------------------------------------------


@given(recipes)
def test_recipe_comes_back_from_json_as_it_was(one):
    back = msgspec.json.decode(msgspec.json.encode(one), type=Recipe)
    assert back == one
    assert back.digest == one.digest


@given(recipes, st.randoms(use_true_random=False))
def test_digest_does_not_depend_on_the_order_of_fields(one, random):
    """Neither of the recipe's fields nor of the material's."""
    table = json.loads(msgspec.json.encode(one))
    material = table["test"]["material"]
    table["test"]["material"] = dict(random.sample(list(material.items()), len(material)))
    shuffled = dict(random.sample(list(table.items()), len(table)))
    assert msgspec.json.decode(json.dumps(shuffled), type=Recipe).digest == one.digest


@pytest.mark.parametrize("hash_seed", ["0", "1"])
def test_digest_is_the_same_in_another_process(hash_seed):
    """Runs on disk are found by it; Python's own hashes differ from process to process."""
    program = (
        "from mechstyle.records.material import LIBRARY; from mechstyle.records import Recipe;"
        "print(Recipe.of(surface='5' * 64, tetrahedra='7' * 64, prompt='brick', material=LIBRARY['PLA']).digest)"
    )
    environment = os.environ | {"PYTHONHASHSEED": hash_seed}
    printed = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=environment).stdout
    assert printed.strip() == recipe().digest


EVERY_LOAD = """
[[case]]
name = "hand on the rim"
supports = [{ at = "resting face" }, { at = { facet = [0, 30, 0], angle = 35 }, kind = "roller" }]
loads = [{ at = { sphere = [40, 0, 100, 8] }, force = [0, 0, -50] }, { gravity = 1 }]
[[case]]
name = "in a vice"
supports = [{ at = { box = [0, 0, 0, 10, 10, 0.5] } }]
loads = [{ at = { plane = [0, 0, 90, 0, 0, 1] }, pressure = 0.2 }, { at = { near = [5, 5, 50, 3] }, force = [1, 0, 0] }]
"""
EVERY_REGION = (
    "box 0 0 0 10 20 30", "sphere 1 2 3 4.5 ramp 2 colour", "plane 0 0 5 1 0 1", "below 12", "inside", "outside ramp 3",
    "segment 1 2 3 colour", "vertices 3 1 2",
)  # fmt: skip


def test_places_are_stored_the_same_way_from_version_to_version(tmp_path):
    """Whatever settings a recipe has got since, every place it can name is written as it always was."""
    file = tmp_path / "loads.toml"
    file.write_text(EVERY_LOAD, encoding="utf-8")
    one = recipe(loads=read_loads(file), protect=regions(EVERY_REGION))
    places = msgspec.json.encode((one.test.loads, one.restraint.protect), order="deterministic")
    assert hashlib.sha256(places).hexdigest() == "6ac0b70f61abac6e916d423087cc373d11730150e7b7aa17ae12a7f3833d9754"


def another(field):
    """A value that a field of the recipe does not have."""
    now = recipe().settings.get(field)
    if field in CHOICES:
        return next(name for name in CHOICES[field] if name != now)
    if isinstance(now, bool):
        return not now
    if field in LIMITS:
        return next(value for value in LIMITS[field] if value != now)
    return {
        "surface": "6" * 64, "tetrahedra": "8" * 64, "prompt": "stone", "material": msgspec.structs.replace(PLA, yield_strength=40.0),
        "stylizer": "mine", "protect": (Inside(),), "loads": (PRESS,), "image": "9" * 64, "build_direction": (0.0, 0.0, 1.0),
        "clip": "ViT-B-32@7",
    }[field]  # fmt: skip


@pytest.mark.parametrize("field", ["surface", "tetrahedra", *SETTINGS])
def test_every_field_decides_the_digest(field):
    assert recipe(**{field: another(field)}).digest != recipe().digest


def test_recipe_is_frozen_and_refuses_fields_it_does_not_know():
    with pytest.raises(AttributeError):
        recipe().style.seed = 1
    for place in ((), ("style",), ("test", "specimen")):
        table = json.loads(msgspec.json.encode(recipe()))
        reduce(getitem, place, table)["colour"] = "red"
        with pytest.raises(msgspec.ValidationError, match="colour"):
            msgspec.json.decode(json.dumps(table), type=Recipe)


def test_numbers_are_welcome_within_their_limits_and_others_get_one_sentence_with_field_value_and_range():
    for field, (low, high) in LIMITS.items():
        assert [recipe(**{field: value}).settings[field] for value in (low, high)] == [low, high]
        for value in (low - 1, high * 2 + 1, math.nan):
            with pytest.raises(BadInput) as caught:
                recipe(**{field: value})
            assert str(caught.value) == f"{field.replace('_', ' ')} is {value:g}, but must lie between {low:g} and {high:g}"


def test_an_unknown_name_gets_the_nearest_known_one():
    for field, known in NAMES.items():
        meant = max(known)
        with pytest.raises(BadInput, match=f"unknown {field} '{meant}x': did you mean '{meant}'"):
            recipe(**{field: meant + "x"})


def test_a_recipe_has_six_chapters_and_every_setting_is_in_exactly_one():
    assert Recipe.__struct_fields__ == ("style", "restraint", "schedule", "test", "delivery", "printed")
    written = json.loads(msgspec.json.encode(recipe()))
    specimen = written["test"].pop("specimen")
    assert specimen == {"surface": "5" * 64, "tetrahedra": "7" * 64}
    names = [name for chapter in Recipe.__struct_fields__ for name in written[chapter]]
    assert len(names) == len(set(names))
    assert tuple(names) == SETTINGS == tuple(recipe().settings)
    assert all(name in written[chapter] for name, chapter in CHAPTER_OF.items())
    assert [name for chapter in written for name in settings_of(chapter)] == names


def test_the_flat_view_makes_the_same_recipe_and_knows_no_other_names():
    one = recipe(seed=7, schedule="every", protect=(Inside(),))
    assert Recipe.of(surface="5" * 64, tetrahedra="7" * 64, **one.settings) == one
    assert one.with_settings(**recipe().settings) == recipe()
    assert one.on(tetrahedra="8" * 64) == recipe(seed=7, schedule="every", protect=(Inside(),), tetrahedra="8" * 64)
    for unknown in ("when", "surfce", "style"):
        with pytest.raises(BadInput, match=f"unknown setting '{unknown}'"):
            one.with_settings(**{unknown: 1})


@given(recipes, recipes)
def test_differences_lead_from_one_recipe_to_the_other(one, other):
    changed = {name: there for name, _, there in one.differences(other)}
    assert all(here != there for _, here, there in one.differences(other))
    assert one.with_settings(**changed) == other
    assert one.differences(one) == ()


def test_another_part_is_no_difference():
    assert recipe().differences(recipe(surface="6" * 64, tetrahedra="8" * 64)) == ()


def test_materials_differ_as_a_whole_or_figure_by_figure():
    other = msgspec.structs.replace(PLA, yield_strength=40.0, source="measured")
    assert recipe().differences(recipe(material=other, seed=3)) == (("seed", 0, 3), ("material", PLA, other))
    by_figure = recipe().differences(recipe(material=other, seed=3), by_figure=True)
    assert by_figure == (("seed", 0, 3), ("yield_strength", PLA.yield_strength, 40.0))


def test_another_source_of_a_material_is_a_difference_but_no_figure():
    other = recipe(material=msgspec.structs.replace(PLA, source="measured"))
    assert recipe().differences(other)
    assert recipe().differences(other, by_figure=True) == ()


def test_only_the_control_none_is_without_feedback():
    assert [control for control in CONTROLS if not recipe(control=control).restraint.feedback] == ["none"]


# --- fields over the surface --------------------------------------------------------------------------------------


LEFT = "tilted onto the left side"


def simulation(count=5, **changes):
    bent = np.zeros((2, count, 3))
    bent[1, :, 2] = -0.5
    given_fields = {
        "displacement": np.zeros(count), "contact": np.zeros(count), "loads": (load_result("hand", maximum=50.0),),
        "landings": (landing(maximum=80.0), landing(LEFT, way="nearly flat", maximum=120.0)), "landing_set": bent,
        "landing_stress": [np.full(count, 2.0), np.full(count, 9.0)],
        "load_stress": [np.arange(count)], "load_strain": [np.full(count, 0.1)],
    }  # fmt: skip
    return Simulation(**{**given_fields, **changes})


def test_a_simulation_gives_each_landing_and_load_by_name_and_way():
    one = simulation()
    assert one.flat.name == "flat"
    assert [found.name for found in one.landed("nearly flat")] == [LEFT]
    assert (one.landing(LEFT).maximum, one.load("hand").maximum, one.landing("hand"), one.load(LEFT)) == (120.0, 50.0, None, None)


def test_it_gives_the_fields_of_each_test_and_nothing_of_what_was_not_tested():
    one = simulation()
    assert one.stress_of(landing=LEFT).tolist() == [9.0] * 5
    assert one.stress_of(load="hand").tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert one.strain_of(load="hand").tolist() == [np.float32(0.1)] * 5
    assert one.set_of(landing=LEFT)[:, 2].tolist() == [-0.5] * 5
    assert not one.set_of(load="hand").any()
    assert (one.set_of(landing="none").shape, one.strain_of(load="none").shape) == ((5, 3), (5,))


def test_the_stress_of_a_simulation_is_that_of_the_flat_landing_and_the_loads():
    assert simulation().stress.tolist() == [2.0, 2.0, 2.0, 3.0, 4.0]
    assert simulation().maximum == 80.0


def test_a_test_that_failed_has_no_landing():
    failed = Simulation(displacement=np.zeros(5), contact=np.zeros(5), failure="the drop blew up")
    assert (failed.flat, failed.landed("flat"), failed.maximum) == (None, [], 0.0)
    assert failed.stress.tolist() == [0.0] * 5


def checkpoint(count=5, **changes):
    scalars = {name: np.full(count, 0.5) for name in ("displacement", "mask", "share", "anchor", "stress", "demand")}
    rest = {"iteration": 3, "parent": "", "recipe": "", "colour": np.zeros((count, 3)), "simulated_at": 0, "style_loss": 0.1}
    return Checkpoint(**{**scalars, **rest, **changes})


@pytest.mark.parametrize("record", [simulation(), checkpoint()], ids=["simulation", "checkpoint"])
def test_fields_are_frozen_copies_of_four_bytes_at_most(record):
    found = [getattr(record, field.name) for field in dataclasses.fields(record) if isinstance(getattr(record, field.name), np.ndarray)]
    assert len(found) == (8 if isinstance(record, Simulation) else 7)
    for array in found:
        assert array.dtype in (np.float32, np.float16, np.bool_)
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def test_records_do_not_follow_the_arrays_they_were_made_from():
    mask = np.full(5, 0.5, dtype=np.float32)
    kept = checkpoint(mask=mask)
    mask[:] = 0.0
    assert kept.mask.tolist() == [0.5] * 5


@pytest.mark.parametrize("field", ["mask", "share", "anchor", "stress", "demand"])
def test_a_checkpoint_field_of_another_length_is_refused_by_name(field):
    with pytest.raises(ValueError, match=rf"{field} must have shape \(5\), not \(4,\)"):
        checkpoint(**{field: np.zeros(4)})


def test_a_checkpoint_colour_has_three_columns():
    with pytest.raises(ValueError, match=r"colour must have shape \(5, 3\)"):
        checkpoint(colour=np.zeros((5, 4)))


def test_a_simulation_field_of_another_length_is_refused_by_name():
    with pytest.raises(ValueError, match=r"contact must have shape \(5,?\), not \(6,\)"):
        simulation(contact=np.zeros(6))
    with pytest.raises(ValueError, match="shape"):
        simulation(landing_strain=np.zeros((2, 6)))


def test_a_vertex_is_restrained_below_one_half_and_not_at_it():
    mask = np.array([0.0, np.nextafter(np.float32(0.5), np.float32(0.0)), 0.5, 0.75, 1.0], np.float32)
    assert checkpoint(mask=mask).restrained.tolist() == restrained(mask).tolist() == [True, True, False, False, False]


def test_checkpoint_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        checkpoint().iteration = 4
