"""Quantities that are read from several tests of one part: each against its own limit."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from mechstyle.loop.objects import Objects
from mechstyle.pictures.fields import known, quantities, safety_factor
from mechstyle.records import LoadResult
from mechstyle.runs.report.replay_data import Digests, _channel
from support.records import COUNT, VERDICT, checkpoint, recipe, simulation

DROP, LOAD = 80.0, 20.0
"""Stress of the drop and under a load, in a part whose original reads above its strength when it falls [MPa]."""
TOLD = msgspec.structs.replace(VERDICT, limits=(("", 91.2), ("coat", 25.0)))


def fallen(**changes):
    """A part that bears DROP in one half and LOAD, under a load, in the other."""
    fell, hung = (np.where(np.arange(COUNT) < 3, *both).astype(np.float32) for both in ((DROP, 0.0), (0.0, LOAD)))
    case = LoadResult(name="coat", peak=LOAD, where=(0.0, 0.0, 0.0), deflection=0.1)
    fields = {"stress": np.maximum(fell, hung), "dropped_stress": fell, "loaded_stress": hung[None], "loaded": (case,), "failure": ""}
    return simulation(**{**fields, **changes})


def factor_of(verdict, found):
    state = replace(checkpoint(), stress=fallen().stress)
    fields = known(recipe(), 45.6, state, found, np.ones(COUNT), state, verdict)
    return next(field.values for field in fields if field.quantity.name == "safety_factor")


def test_the_drop_and_each_load_are_drawn_against_their_own_limit():
    """A drop at 80 of 91 MPa was drawn at 0.57, against the limit of the load that is told."""
    factors = factor_of(TOLD, fallen())
    assert factors[:3] == pytest.approx(91.2 / DROP)
    assert factors[3:] == pytest.approx(25.0 / LOAD)


@pytest.mark.parametrize(
    ("verdict", "found"),
    [
        (VERDICT, fallen()),
        (None, fallen()),
        (msgspec.structs.replace(TOLD, criterion="paper"), fallen()),
        (TOLD, fallen(failure="it broke down")),
        (TOLD, None),
    ],
    ids=["an earlier record", "before the first", "one limit for all", "a test that broke down", "none"],
)
def test_where_the_tests_are_not_known_the_stress_of_all_is_drawn_against_the_one_limit(verdict, found):
    factors = factor_of(verdict, found)
    assert factors[:3] == pytest.approx(45.6 / DROP)
    assert factors[3:] == pytest.approx(45.6 / LOAD)


def test_a_replay_draws_the_same(tmp_path):
    objects, found = Objects(tmp_path), fallen()
    stress, name = objects.put_array(found.stress), objects.put_record(found)
    broken = objects.put_record(fallen(failure="it broke down"))
    one = Digests("", "", stress, "", "", name)
    frames = [one, one, msgspec.structs.replace(one, simulation=broken)]
    channel = _channel(objects, frames, safety_factor(45.6, TOLD.each))
    assert channel.frames == [0, 0, 1]
    read = [channel.low + channel.step * plane for plane in channel.planes]
    assert read[0][[0, -1]] == pytest.approx([91.2 / DROP, 25.0 / LOAD], abs=2e-3)
    assert read[1][[0, -1]] == pytest.approx([45.6 / DROP, 45.6 / LOAD], abs=2e-3)
    assert [quantity.name for quantity in quantities(recipe(), 45.6, TOLD.each)][:2] == ["stress", "safety_factor"]
