"""The fields of a checkpoint: each says of which test it is, and is drawn against what that test allows."""

from dataclasses import replace

import numpy as np
import pytest

from mechstyle.pictures.fields import BENT_ABOVE, judged, known, most_bent, quantities, stays_bent
from support.records import (
    COUNT,
    STRENGTH,
    UNKNOWN,
    checkpoint,
    landing,
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


def fields_of(found_of, found, state=None):
    state = checkpoint() if state is None else state
    return {field.quantity.name: field for field in known(recipe(), state, found, np.ones(COUNT), state, found_of)}


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
    assert np.array_equal(found["stress"].quantity.values_in(simulated()), simulated().landing_stress[2]), "as a file with fields reads it"
    assert np.array_equal(found["stays_bent"].values, judged(np.linalg.norm(simulated().landing_set[2], axis=1), TILTED))
    loaded = fields_of(verdict(row(), load_row(0.15, load="coat")), simulated(), checkpoint(simulated_at=3))
    assert loaded["stress"].note == loaded["stays_bent"].note == "load coat"
    assert np.array_equal(loaded["stress"].quantity.values_in(simulated()), simulated().load_stress[1])


@pytest.mark.parametrize("figure", [0.3, 0.6])
def test_what_stays_bent_ends_at_the_figure_that_was_judged(figure):
    """Also where the vertices miss what the tetrahedras' volume has; of a part that gives way its last shape is shown as it was."""
    lengths = np.array([0.1, 0.2, 0.5, 0.4])
    ends = judged(lengths, row(figure))
    assert (ends.max(), ends[:2].tolist()) == (np.float32(figure), lengths[:2].astype(np.float32).tolist())
    assert ends.argmax() == 2
    assert np.array_equal(judged(lengths, row(figure, outcome="FAILS", collapses=True)), lengths.astype(np.float32))
    assert not judged(np.zeros(4), row(figure)).any()


def test_the_most_bent_vertex_is_the_one_nearest_to_the_place_judged():
    bend = np.zeros((1, COUNT, 3), np.float32)
    bend[0, :, 2] = np.linspace(0.0, 0.6, COUNT)
    vertices = np.column_stack([np.arange(COUNT), np.zeros((COUNT, 2))])
    tested = simulation(landings=(landing(),), landing_set=bend, landing_stress=np.zeros((1, COUNT)), landing_strain=np.zeros((1, COUNT)))
    found = most_bent(vertices, row(0.35, where=(3.0, 0.0, 0.0)), tested)
    assert found == 4, "3 is nearer, but less is left of its bend"


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
