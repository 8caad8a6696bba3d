"""The fields of a checkpoint: each is of one test, drawn against the limit of that very test, and says so."""

from dataclasses import replace

import numpy as np
import pytest

from mechstyle.pictures.fields import known, quantities, safety_factor
from mechstyle.records import LoadResult
from mechstyle.runs.report.replay_data import channel_of
from support.records import COUNT, STRENGTH, UNKNOWN, checkpoint, load_row, recipe, row, simulation, verdict

NEARLY = row(900.0, test="nearly flat", landing="tilted right", outcome="NO WORSE", limit=59.0, original=990.0)
HANDS = [LoadResult(name=name, stress=20.0, maximum=40.0, where=(0.0, 0.0, 0.0), deflection=0.1) for name in ("hand on the rim", "coat")]
TOLD = verdict(row(limit=46.0), NEARLY, load_row(load="hand on the rim", limit=50.0), load_row(load="coat", limit=51.0))


def simulated(**changes):
    loads = {"loads": tuple(HANDS), "load_stress": np.stack([np.full(COUNT, 11.0), np.full(COUNT, 12.0)])}
    return simulation(failure="", **loads, **changes)


def fields_of(judged, found, state=None):
    state = checkpoint() if state is None else state
    return {field.quantity.name: field for field in known(recipe(), state, found, np.ones(COUNT), state, judged)}


def test_every_test_that_has_a_row_has_a_field_of_its_own_limit_in_a_fixed_order():
    test = simulated()
    found = fields_of(TOLD, test)
    assert list(found) == [
        "stress", "safety_factor", "restraint", "demand", "displacement", "thickness", "contact",
        "flat_stress", "nearly_flat_stress", "load_hand_on_the_rim", "load_coat",
    ]  # fmt: skip
    wanted = {
        "flat_stress": (46.0, test.landing_stress[0]), "nearly_flat_stress": (59.0, test.landing_stress[1:].max(axis=0)),
        "load_hand_on_the_rim": (50.0, test.load_stress[0]), "load_coat": (51.0, test.load_stress[1]),
    }  # fmt: skip
    for name, (limit, values) in wanted.items():
        assert found[name].quantity.threshold == limit
        assert np.array_equal(found[name].values, values)


def test_the_stress_of_a_checkpoint_is_of_the_test_that_decides_and_has_its_limit_and_its_name():
    """A caption told of a tilted landing under a picture of the flat one."""
    assert TOLD.deciding is NEARLY
    stress = fields_of(TOLD, simulated())["stress"]
    assert stress.quantity.threshold == NEARLY.limit
    assert stress.note == "tilted right, simulated at iteration 0"
    assert fields_of(TOLD, simulated(), checkpoint(simulated_at=3))["stress"].note == "tilted right"
    assert np.array_equal(stress.quantity.of(simulated()), simulated().landing_stress[2]), "as a file with fields reads it"
    loaded = fields_of(verdict(row(), load_row(1.05, load="coat")), simulated())["stress"]
    assert loaded.note.startswith("load coat")
    assert np.array_equal(loaded.quantity.of(simulated()), simulated().load_stress[1])


@pytest.mark.parametrize(
    ("judged", "found"), [(None, None), (UNKNOWN, simulation()), (TOLD, simulation())], ids=["before the first", "no answer", "failed"]
)
def test_where_nothing_was_tested_the_limit_is_the_strength_and_no_test_has_a_field(judged, found):
    fields = fields_of(judged, found)
    assert fields["stress"].quantity.threshold == (STRENGTH if judged is not TOLD else NEARLY.limit)
    assert not {"flat_stress", "nearly_flat_stress", "load_coat"} & set(fields)


def test_a_safety_factor_is_the_yield_strength_over_the_stress_whatever_the_limit():
    state = replace(checkpoint(), stress=np.array([0.0, 1.0, 22.8, STRENGTH, 60.0, 80.0, 91.2], np.float32))
    factor = fields_of(TOLD, simulated(), state)["safety_factor"]
    least = STRENGTH / NEARLY.stress  # that of the verdict, as what is above σ_V counts as that
    assert least == pytest.approx(TOLD.safety_factor)
    assert factor.values == pytest.approx([10.0, 10.0, 2.0, 1.0, *[least] * 3])
    alone = safety_factor(STRENGTH).made(state.stress)
    assert alone == pytest.approx([10.0, 10.0, 2.0, 1.0, 0.76, 0.57, 0.5])
    assert factor.quantity.threshold == 1.0
    assert np.array_equal(factor.quantity.of(simulated()), factor.quantity.formed(simulated().landing_stress[2]))


def test_what_is_shown_is_what_is_judged():
    """A bar ended at 287 MPa over a note that said σ_V 77.7."""
    state = replace(checkpoint(), stress=np.linspace(0.0, 287.0, COUNT, dtype=np.float32))
    failed = verdict(row(stress=77.7, limit=48.1, outcome="FAILS"))
    stress = fields_of(failed, None, state)["stress"]
    assert stress.quantity.limits(stress.values) == pytest.approx((0.0, 77.7))
    assert stress.values == pytest.approx(np.minimum(state.stress, 77.7))
    assert (stress.quantity.judged, stress.quantity.most) == (77.7, "σ_V 77.7 MPa")
    holds = fields_of(verdict(row(stress=30.0, limit=45.6)), None, state)["stress"]
    assert not (holds.values > holds.quantity.threshold).any(), "nothing of a part that holds is set apart as beyond the limit"
    assert holds.quantity.limits(holds.values) == pytest.approx((0.0, 1.05 * 45.6))


def test_a_replay_draws_the_same():
    state, made = checkpoint(), safety_factor(STRENGTH).made
    channel = channel_of("safety", [made(np.full(COUNT, value, np.float32)) for value in (22.8, 91.2)], [0, 0, 1])
    assert channel.frames == [0, 0, 1]
    assert [float((channel.low + channel.step * plane)[0]) for plane in channel.planes] == pytest.approx([2.0, 0.5], abs=1e-3)
    assert [quantity.name for quantity in quantities(recipe(), None)] == list(fields_of(None, None, state))[:5]
