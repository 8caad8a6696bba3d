"""The original on tetrahedra made for a relief: a notch that the way back leaves raises no limit."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from mechstyle.fea.verdict import judge
from mechstyle.records.material import LIBRARY
from mechstyle.simulation.original import FINER, sobered
from support.records import simulation

PLA = LIBRARY["PLA"]


def original(surface, contact=10.0, tilted=20.0):
    """An original with these stresses; its fields are as high everywhere."""
    one = simulation(failure="")
    placed = msgspec.structs.replace(one.as_placed, peak=max(surface, contact), surface=surface, contact=contact)
    nearly = msgspec.structs.replace(one.as_placed, peak=tilted, surface=tilted)
    count = len(one.stress)
    return replace(one, as_placed=placed, tilted=nearly, stress=np.full(count, surface), tilted_stress=np.full(count, tilted))


def test_a_part_may_not_bear_what_only_a_notch_left_over_in_its_stand_in_bears():
    notched, whole, styled = original(240.0), original(40.0), original(120.0)
    assert judge(styled, notched, PLA, "robust").outcome == "VIABLE", "the error this is here for"
    assert judge(styled, sobered(notched, whole), PLA, "robust").outcome == "FAILS"


def test_what_finer_tetrahedra_read_is_left_as_it_is():
    """On those of a relief a pen holder reads 56 MPa in the middle of its floor, on its own 41, styled or not."""
    finer, plain = original(56.0, contact=50.0, tilted=60.0), original(41.0, contact=40.0, tilted=55.0)
    found = sobered(finer, plain)
    assert (found.as_placed, found.tilted) == (finer.as_placed, finer.tilted)
    assert np.array_equal(found.stress, finer.stress)


def test_each_rule_is_held_by_itself():
    found = sobered(original(30.0, contact=200.0, tilted=300.0), original(40.0, contact=20.0, tilted=50.0))
    assert (found.as_placed.surface, found.as_placed.contact, found.as_placed.peak) == (30.0, FINER * 20.0, 30.0)
    assert found.tilted.surface == FINER * 50.0
    assert float(found.tilted_stress.max()) == pytest.approx(FINER * 50.0)


def test_percentiles_over_all_orientations_stay_those_of_the_same_tetrahedra():
    here = replace(original(30.0), overall=msgspec.structs.replace(original(30.0).as_placed, p99=25.0))
    assert sobered(here, original(40.0)).overall.p99 == 25.0


def test_what_failed_to_be_simulated_at_rest_takes_nothing_away():
    here = original(30.0)
    assert sobered(here, replace(original(1.0), failure="it broke down")) is here
