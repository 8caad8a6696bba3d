"""Recipe, measures, judgement, verdict, checkpoint: checked, frozen, named by their content."""

import dataclasses
import hashlib
import json
import math
import os
import subprocess
import sys

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechstyle.errors import BadInput
from mechstyle.records import (
    CONTROLS,
    CRITERIA,
    NORMALISATIONS,
    SCHEDULES,
    Checkpoint,
    Judgement,
    LoadResult,
    Measures,
    Recipe,
    Simulation,
    Verdict,
)
from mechstyle.records.checkpoint import restrained
from mechstyle.records.load_cases import Load, LoadCase, Support, read_loads
from mechstyle.records.material import LIBRARY
from mechstyle.records.regions import Inside, regions

PLA = LIBRARY["PLA"]
PRESS = LoadCase(name="press", supports=(Support(at="resting face"),), loads=(Load(gravity=2.0),))
LIMITS = {
    "iterations": (1, 100_000),
    "every": (1, 100_000),
    "seed": (0, 2**32 - 1),
    "relief": (0.0, 20.0),
    "amplitude": (0.0, 2.0),
    "feature": (0.2, 500.0),
    "nozzle": (0.0, 5.0),
    "image_size": (0.5, 2000.0),
    "travel": (1e-3, 10.0),
    "minimum_wall": (0.0, 100.0),
    "orientations": (1, 512),
    "drop_height": (1.0, 1e5),
    "friction": (0.0, 2.0),
    "window": (0.05, 50.0),
    "damping": (0.0, 1.0),
}
NAMES = {
    "control": CONTROLS,
    "normalisation": NORMALISATIONS,
    "schedule": SCHEDULES,
    "criterion": CRITERIA,
    "transfer": ("barycentric", "nearest"),
    "element": ("tet10", "tet4"),
    "side": ("auto", "outwards", "inwards", "both"),
    "inside": ("plain", "styled"),
    "image_as": ("height", "colour", "both"),
    "image_layout": ("tiled", "placed"),
    "projection": ("box", "planar", "around"),
}


def recipe(**changes):
    return Recipe(**{"surface": "5" * 64, "tetrahedra": "7" * 64, "prompt": "brick", "material": PLA, **changes})


def numbers(field):
    low, high = LIMITS[field]
    return st.integers(low, high) if isinstance(low, int) else st.floats(low, high)


recipes = st.builds(
    recipe,
    prompt=st.text(),
    loads=st.sampled_from([(), (PRESS,)]),
    memory=st.booleans(),
    guarantee=st.booleans(),
    **{field: numbers(field) for field in LIMITS},
    **{field: st.sampled_from(known) for field, known in NAMES.items()},
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
    table["material"] = dict(random.sample(list(table["material"].items()), len(table["material"])))
    shuffled = dict(random.sample(list(table.items()), len(table)))
    assert msgspec.json.decode(json.dumps(shuffled), type=Recipe).digest == one.digest


@pytest.mark.parametrize("hash_seed", ["0", "1"])
def test_digest_is_the_same_in_another_process(hash_seed):
    """Runs on disk are found by it; Python's own hashes differ from process to process."""
    program = (
        "from mechstyle.records.material import LIBRARY; from mechstyle.records import Recipe;"
        "print(Recipe(surface='5' * 64, tetrahedra='7' * 64, prompt='brick', material=LIBRARY['PLA']).digest)"
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


def test_places_are_stored_as_in_runs_made_before(tmp_path):
    """Whatever settings a recipe has got since, every place it can name is written as it always was."""
    file = tmp_path / "loads.toml"
    file.write_text(EVERY_LOAD, encoding="utf-8")
    one = recipe(loads=read_loads(file), protect=regions(EVERY_REGION))
    places = msgspec.json.encode((one.loads, one.protect), order="deterministic")
    assert hashlib.sha256(places).hexdigest() == "f83e84d17f54777833f3822a94ca5ff5dd3ebd2698cdb58a6a0c3085a0f8b8bb"


@pytest.mark.parametrize("field", [field.name for field in msgspec.structs.fields(Recipe)])
def test_every_field_decides_the_digest(field):
    other = {
        "surface": "6" * 64, "tetrahedra": "8" * 64, "prompt": "stone", "material": msgspec.structs.replace(PLA, yield_strength=40.0),
        "control": "linear", "normalisation": "yield", "schedule": "every", "criterion": "paper", "transfer": "nearest", "stylizer": "mine",
        "protect": (Inside(),), "element": "tet4",
        "loads": (PRESS,), "minimum_wall": 1.2, "strengthen": 1.5,
        "memory": True, "retraction": True, "base": "free", "guarantee": False,
        "iterations": 7, "seed": 7, "every": 7, "amplitude": 0.7, "travel": 0.7, "orientations": 7, "poses": "tilts", "standard": "en71",
        "relief": 0.7, "side": "outwards", "feature": 7.0, "nozzle": 0.7, "inside": "styled",
        "image": "9" * 64, "image_size": 7.0, "image_as": "colour", "image_layout": "placed", "projection": "around",
            "delivered": 70_000,
        "tilts": 7, "build_direction": (0.0, 0.0, 1.0), "drop_height": 700.0, "friction": 0.7,
        "window": 0.7, "damping": 0.007, "threshold": 0.7, "guidance": "clip", "field": "network", "clip": "ViT-B-32@7", "crops": 7,
    }  # fmt: skip
    assert recipe(**{field: other[field]}).digest != recipe().digest


def test_recipe_is_frozen_and_refuses_fields_it_does_not_know():
    with pytest.raises(AttributeError):
        recipe().seed = 1
    table = json.loads(msgspec.json.encode(recipe())) | {"colour": "red"}
    with pytest.raises(msgspec.ValidationError, match="colour"):
        msgspec.json.decode(json.dumps(table), type=Recipe)


@pytest.mark.parametrize("field", LIMITS)
def test_numbers_are_welcome_up_to_their_limits(field):
    low, high = LIMITS[field]
    assert getattr(recipe(**{field: low}), field) == low
    assert getattr(recipe(**{field: high}), field) == high


@pytest.mark.parametrize("field", LIMITS)
@pytest.mark.parametrize("side", ["below", "above", "nan"])
def test_a_number_out_of_range_gets_one_sentence_with_field_value_and_range(field, side):
    low, high = LIMITS[field]
    value = {"below": low - 1, "above": high * 2 + 1, "nan": math.nan}[side]
    with pytest.raises(BadInput) as caught:
        recipe(**{field: value})
    message = str(caught.value)
    assert message == f"{field.replace('_', ' ')} is {value:g}, but must lie between {low:g} and {high:g}"
    assert "\n" not in message


@pytest.mark.parametrize("field", NAMES)
def test_an_unknown_name_gets_the_nearest_known_one(field):
    meant = NAMES[field][0]
    with pytest.raises(BadInput, match=f"unknown {field} '{meant}x': did you mean '{meant}'"):
        recipe(**{field: meant + "x"})


def test_settings_are_all_fields_but_the_part():
    given = msgspec.json.decode(msgspec.json.encode(recipe()))
    assert list(recipe().settings) == [name for name in given if name not in {"surface", "tetrahedra"}]
    assert Recipe(surface="5" * 64, tetrahedra="7" * 64, **recipe(seed=7).settings) == recipe(seed=7)


@given(recipes, recipes)
def test_differences_lead_from_one_recipe_to_the_other(one, other):
    changed = {name: there for name, _, there in one.differences(other)}
    assert all(here != there for _, here, there in one.differences(other))
    assert msgspec.structs.replace(one, **changed) == other
    assert one.differences(one) == ()


def test_another_part_is_no_difference():
    assert recipe().differences(recipe(surface="6" * 64, tetrahedra="8" * 64)) == ()


def test_materials_differ_as_a_whole_or_figure_by_figure():
    other = msgspec.structs.replace(PLA, yield_strength=40.0, source="measured")
    assert recipe().differences(recipe(material=other, seed=3)) == (("material", PLA, other), ("seed", 0, 3))
    by_figure = recipe().differences(recipe(material=other, seed=3), by_figure=True)
    assert by_figure == (("yield_strength", PLA.yield_strength, 40.0), ("seed", 0, 3))


def test_another_source_of_a_material_is_a_difference_but_no_figure():
    other = recipe(material=msgspec.structs.replace(PLA, source="measured"))
    assert recipe().differences(other)
    assert recipe().differences(other, by_figure=True) == ()


def test_only_the_control_none_is_without_feedback():
    assert [control for control in CONTROLS if not recipe(control=control).feedback] == ["none"]


# --- judgement and verdict ----------------------------------------------------------------------------------------


def judgement(value, limit, outcome="VIABLE"):
    return Judgement(rule="peak", outcome=outcome, value=value, limit=limit, unit="MPa", marginal=False)


def test_safety_factor_is_limit_over_value():
    assert judgement(22.8, 45.6).safety_factor == pytest.approx(2.0)
    assert judgement(91.2, 45.6).safety_factor == pytest.approx(0.5)
    assert judgement(0.0, 45.6).safety_factor == math.inf


@given(value=st.floats(1e-6, 1e6), limit=st.floats(1e-6, 1e6))
def test_safety_factor_is_at_least_one_exactly_when_the_value_is_within_the_limit(value, limit):
    assert (judgement(value, limit).safety_factor >= 1.0) == (value <= limit)


def test_a_value_that_is_not_a_number_is_never_safe():
    assert not judgement(math.nan, 45.6, "UNKNOWN").safety_factor >= 1.0


def verdict(outcome="VIABLE", criterion="robust"):
    literal = judgement(60.0, 45.6, "FAILS")
    return Verdict(outcome=outcome, criterion=criterion, as_placed=judgement(20.0, 45.6), all_orientations=None, literal=literal, words=".")


@pytest.mark.parametrize(("outcome", "viable"), [("VIABLE", True), ("FAILS", False), ("UNKNOWN", False)])
def test_only_viable_is_viable(outcome, viable):
    assert verdict(outcome).viable is viable


def test_the_criterion_chooses_the_judgement_that_decides():
    assert verdict(criterion="robust").deciding.value == 20.0
    assert verdict(criterion="paper").deciding.value == 60.0


def test_verdict_comes_back_from_json_as_it_was():
    assert msgspec.json.decode(msgspec.json.encode(verdict()), type=Verdict) == verdict()


def test_an_outcome_that_does_not_exist_is_refused_on_reading():
    text = msgspec.json.encode(verdict()).replace(b'"outcome":"VIABLE"', b'"outcome":"FINE"')
    with pytest.raises(msgspec.ValidationError, match="FINE"):
        msgspec.json.decode(text, type=Verdict)


# --- figures of a test --------------------------------------------------------------------------------------------


def test_of_two_tests_each_stress_is_the_larger_and_the_place_that_of_the_larger_peak():
    one = Measures(peak=20.0, surface=20.0, contact=5.0, p999=18.0, p99=12.0, maximum=30.0, where=(0.0, 0.0, 1.0), volume=1000.0)
    other = Measures(peak=15.0, surface=9.0, contact=15.0, p999=19.0, p99=11.0, maximum=31.0, where=(2.0, 2.0, 2.0), volume=1000.0)
    for found in (one.or_worse(other), other.or_worse(one)):
        assert (found.peak, found.surface, found.contact) == (20.0, 20.0, 15.0)
        assert (found.p999, found.p99, found.maximum, found.where) == (19.0, 12.0, 31.0, (0.0, 0.0, 1.0))


def test_a_load_tells_both_the_stress_at_the_surface_and_over_2_mm():
    resolved = LoadResult(name="hand", peak=38.2, surface=38.2, averaged=36.0, where=(1.0, 2.0, 3.0), deflection=0.123)
    assert resolved.words == "38.2 MPa at the surface (36.0 over 2 mm) at (1.0, 2.0, 3.0) mm, deflection 0.12 mm"
    unresolved = msgspec.structs.replace(resolved, peak=36.0, surface=12.0)
    assert unresolved.words == "36.0 MPa over 2 mm at (1.0, 2.0, 3.0) mm, deflection 0.12 mm"


# --- fields over the surface --------------------------------------------------------------------------------------


def simulation(count=5, **changes):
    measures = Measures(peak=20.0, p999=18.0, p99=12.0, maximum=30.0, where=(0.0, 0.0, 1.0), volume=1000.0)
    given_fields = {
        "displacement": np.zeros(count), "stress": np.ones(count), "envelope": np.ones(count), "probability": np.zeros(count),
        "contact": np.zeros(count),
        "as_placed": measures, "overall": None, "backed_off": 0.0, "deviation": 0.0, "time_step": 1e-4, "steps": 10, "added_mass": 0.0,
    }  # fmt: skip
    return Simulation(**{**given_fields, **changes})


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


@pytest.mark.parametrize("field", ["stress", "envelope", "contact"])
def test_a_simulation_field_of_another_length_is_refused_by_name(field):
    with pytest.raises(ValueError, match=rf"{field} must have shape \(5\), not \(6,\)"):
        simulation(**{field: np.zeros(6)})


def test_a_vertex_is_restrained_below_one_half_and_not_at_it():
    mask = np.array([0.0, np.nextafter(np.float32(0.5), np.float32(0.0)), 0.5, 0.75, 1.0], np.float32)
    assert checkpoint(mask=mask).restrained.tolist() == restrained(mask).tolist() == [True, True, False, False, False]


def test_checkpoint_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        checkpoint().iteration = 4
