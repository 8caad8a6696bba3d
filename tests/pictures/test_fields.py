"""The fields of a checkpoint: each says of which test it is, and is drawn against what that test allows."""

from dataclasses import replace

import numpy as np
import pytest

from mechstyle.pictures.fields import BENT_ABOVE, known, quantities, stays_bent
from support.records import (
    COUNT,
    STRENGTH,
    UNKNOWN,
    checkpoint,
    load_result,
    load_row,
    published_row,
    recipe,
    row,
    simulation,
    verdict,
)

TILTED = row(0.3, test="nearly flat", landing="tilted right", allowed=0.25)
TOLD = verdict(row(), TILTED, load_row(load="hand on the rim"), load_row(load="coat"))


def simulated(**changes):
    loads = {
        "loads": (load_result("hand on the rim"), load_result("coat")),
        "load_stress": np.stack([np.full(COUNT, 11.0), np.full(COUNT, 12.0)]),
    }
    return simulation(failure="", **loads, **changes)


def fields_of(judged, found, state=None):
    state = checkpoint() if state is None else state
    return {field.quantity.name: field for field in known(recipe(), state, found, np.ones(COUNT), state, judged)}


def test_every_test_has_a_stress_of_its_own_against_the_yield_strength_in_a_fixed_order():
    test = simulated()
    found = fields_of(TOLD, test)
    assert list(found) == [
        "stress", "stays_bent", "restraint", "demand", "displacement", "thickness", "contact",
        "stress_flat", "stress_tilted_right", "stress_hand_on_the_rim", "stress_coat",
    ]  # fmt: skip
    assert np.array_equal(found["stress_tilted_right"].values, test.landing_stress[2])
    assert np.array_equal(found["stress_hand_on_the_rim"].values, test.load_stress[0])
    for name in ("stress", "stress_flat", "stress_coat"):
        assert (found[name].quantity.threshold, found[name].quantity.edge) == (STRENGTH, "yields at")


def test_stress_and_bend_are_of_the_worst_test_and_say_so():
    """A caption told of a tilted landing under a picture of the flat one."""
    assert TOLD.deciding is TILTED
    found = fields_of(TOLD, simulated())
    for name in ("stress", "stays_bent"):
        assert found[name].note == "tilted right, simulated at iteration 0"
    assert np.array_equal(found["stress"].quantity.of(simulated()), simulated().landing_stress[2]), "as a file with fields reads it"
    assert found["stays_bent"].values == pytest.approx(np.linalg.norm(simulated().landing_set[2], axis=1))
    loaded = fields_of(verdict(row(), load_row(0.15, load="coat")), simulated(), checkpoint(simulated_at=3))
    assert loaded["stress"].note == loaded["stays_bent"].note == "load coat"
    assert np.array_equal(loaded["stress"].quantity.of(simulated()), simulated().load_stress[1])


def test_what_stays_bent_is_in_mm_against_what_is_allowed_however_far_a_part_gives_way():
    bend = stays_bent(TILTED)
    assert (bend.unit, bend.threshold, bend.edge) == ("mm", 0.25, "allowed")
    assert bend.limits(np.array([0.0, 9.0])) == bend.limits(np.array([0.0, 0.01])) == (0.0, BENT_ABOVE * 0.25)


def test_what_yields_is_set_apart_and_the_colours_show_the_largest():
    state = replace(checkpoint(), stress=np.linspace(0.0, 48.0, COUNT, dtype=np.float32))
    stress = fields_of(TOLD, None, state)["stress"]
    assert stress.quantity.limits(stress.values) == pytest.approx((0.0, 48.0))
    assert np.array_equal(stress.values, state.stress)
    assert stress.quantity.limits(np.zeros(3)) == pytest.approx((0.0, 1.05 * STRENGTH))


@pytest.mark.parametrize("judged", [None, UNKNOWN, verdict(published_row(), criterion="paper")], ids=["before", "no answer", "published"])
def test_where_no_bend_is_known_none_is_shown(judged):
    fields = fields_of(judged, simulation())
    assert fields["stress"].quantity.threshold == STRENGTH
    assert not [name for name in fields if name == "stays_bent" or name.startswith("stress_")]
    assert [quantity.name for quantity in quantities(recipe(), judged)] == ["stress", "restraint", "demand", "displacement"]


def test_a_test_that_failed_shows_no_stress_of_its_own():
    """Its verdict was of an earlier iteration."""
    assert not [name for name in fields_of(TOLD, simulation()) if name.startswith("stress_")]
