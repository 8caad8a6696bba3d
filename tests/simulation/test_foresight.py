"""What is foreseen of a cure: between the plain part and the one that failed, nearer to the plain one the more of the flow it reaches."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.records import Simulation
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation import foresight
from mechstyle.simulation.foresight import certain_share, held_back, hinge, thickened, with_less_relief
from mechstyle.teaching import box
from support.records import landing, load_result, load_row, published_row, row, verdict

LONG = box((24, 2, 2), (60.0, 5.0, 5.0))
"""A bar along x."""


@pytest.fixture
def bar() -> SurfaceMesh:
    surface = LONG.boundary
    return SurfaceMesh(surface.vertices, surface.faces)


def of(bar, relief, strain=0.0, stress=10.0, loads=()):
    """A simulation of a flat landing, or of a load in its place, by its fields over the bar."""
    count, fields = len(bar.vertices), {}
    kind, names = ("load", {"loads": loads}) if loads else ("landing", {"landings": (landing(),)})
    for what, values in (("strain", strain), ("stress", stress)):
        fields[f"{kind}_{what}"] = np.broadcast_to(np.asarray(values, np.float32), (1, count))
    return Simulation(displacement=np.broadcast_to(np.float32(relief), count), contact=np.zeros(count, bool), **names, **fields)


@pytest.fixture
def failed(bar):
    """It is cut 2 mm deep into walls of 5 mm and flows at its end, x < 10 mm; the plain one is stressed there most."""
    x = bar.vertices[:, 0]
    return of(bar, -2.0, np.where(x < 10.0, 0.02, 0.0)), of(bar, 0.0, stress=30.0 - 0.4 * x)


FAILS = verdict(row(0.5, plain_permanent_set=0.1))


def foreseen(bar, failed, left, judged=FAILS, **how):
    tested, plain = failed
    return with_less_relief(judged, tested, plain, bar, np.full(len(bar.vertices), 5.0), left, **how)


def test_without_any_relief_it_bends_as_the_plain_part(bar, failed):
    found = foreseen(bar, failed, np.zeros(len(bar.vertices)))
    assert (found.least, found.most, found.why) == (0.1, pytest.approx(0.1 + foresight.REPEATS), "")


def test_the_more_relief_goes_where_it_flows_the_less_stays_bent(bar, failed):
    x = bar.vertices[:, 0]
    most = [foreseen(bar, failed, np.where(x < reach, 0.0, 1.0)).most for reach in (3.0, 7.0, 12.0, 60.0)]
    assert most == sorted(most, reverse=True)
    assert len(set(most)) == len(most)
    assert most[0] < 1.1 * 0.5


def test_a_cure_far_from_what_flows_says_that_it_does_not_help(bar, failed):
    found = foreseen(bar, failed, np.where(bar.vertices[:, 0] > 30.0, 0.0, 1.0))
    assert found.why == "hardly any relief goes where it bends, landing flat"
    assert foreseen(bar, failed, np.where(bar.vertices[:, 0] < 12.0, 0.0, 1.0)).why == ""


def test_where_the_weakest_section_is_left_more_may_stay_bent(bar, failed):
    """The same flow is reached; what is left is cut as deep as now, or not at all."""
    x = bar.vertices[:, 0]
    near, everywhere = (foreseen(bar, failed, left).most for left in (np.where(x < 12.0, 0.0, 1.0), np.zeros_like(x)))
    assert near > everywhere


def test_where_masks_hold_back_as_much_may_stay_bent_as_now(bar, failed):
    """Bricks shallower where the trophy bends: masks let through elsewhere what was relieved, and 0.19 mm stayed instead of 0.18 mm."""
    x = bar.vertices[:, 0]
    free, fed = (foreseen(bar, failed, np.where(x < 12.0, 0.0, 1.0), masked=masked) for masked in (False, True))
    assert free.most < fed.most == pytest.approx(1.1 * 0.5)
    assert (free.least, free.why) == (fed.least, fed.why)


def test_every_test_that_fails_counts(bar, failed):
    """The other one is under a load that the simulation knows nothing of: no cure is seen to reach it."""
    both = verdict(row(0.5, plain_permanent_set=0.1), load_row(0.8, outcome="FAILS"))
    found = foreseen(bar, failed, np.zeros(len(bar.vertices)), both)
    assert (found.why, found.most) == ("hardly any relief goes where it bends, under the load 'coat'", pytest.approx(0.88))


def test_the_published_rule_says_nothing_of_a_bend(bar, failed):
    assert foreseen(bar, failed, np.zeros(len(bar.vertices)), verdict(published_row()))[:2] == (0.0, 0.0)


def test_a_correction_ends_at_what_is_allowed_and_keeps_what_holds_in_proportion():
    assert held_back(FAILS)[:2] == (0.1, FAILS.rows[0].allowed)
    share = certain_share(FAILS)
    assert 0.1 + share * (0.5 - 0.1) == pytest.approx(FAILS.rows[0].allowed)
    assert certain_share(verdict(row(0.05))) == 1.0


def test_the_hinge_is_where_most_flows_not_where_it_is_off_most(bar):
    x = bar.vertices[:, 0]
    flow = np.where(np.abs(x - 15.0) < 6.0, 0.01, 0.0) + np.where(x > 59.0, 0.02, 0.0)
    assert abs(x[hinge(FAILS, of(bar, 0.0, flow), bar, 8.0)] - 15.0) < 6.0
    nothing = of(bar, 0.0, stress=x)
    assert x[hinge(FAILS, nothing, bar, 8.0)] == 60.0, "where nothing flows it is the largest stress"


@pytest.mark.parametrize(("judged", "power"), [(verdict(row(0.5)), 0.5), (verdict(load_row(0.5, outcome="FAILS")), 2.0)])
def test_thicker_walls_bear_a_load_better_than_a_blow(bar, judged, power):
    tested = of(bar, 0.0, 0.02, loads=(load_result(),) if judged.rows[0].load else ())
    found = thickened(judged, tested, bar, np.full(len(bar.vertices), 5.0), 1.5)
    assert (found.least, found.most) == (0.0, pytest.approx(0.5 * (5.0 / 8.0) ** power))
