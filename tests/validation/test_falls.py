"""Critical heights against drops from there, and touches read off a drop without a break."""

import re

import numpy as np
import pytest

from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import DropTest, drop, tracks_for
from mechstyle.fea.elements import LINEAR
from mechstyle.fea.explicit import no_progress
from mechstyle.fea.flight import RigidBody
from mechstyle.fea.linear_solvers import lowest_period
from mechstyle.fea.phases import follow
from mechstyle.records.material import LIBRARY
from support.cases import held, quick
from validation import falls
from validation.falls import TILTS, WORST, _landed_again, later_touches, tilted_ways
from validation.meshes import box, bracket

PLA = LIBRARY["PLA"]


@pytest.mark.parametrize(("window", "count"), [(1.5, 0), (8.0, 1)])
def test_a_long_window_has_the_touch_a_short_one_has_not(window, count):
    bar, turn = box((15, 3, 1), (120.0, 20.0, 4.0)), np.radians(35.0)
    way, body = np.array([[np.sin(turn), 0.0, np.cos(turn)]]), discretise(bar, PLA, 0.01, LINEAR)
    period, test = lowest_period(body), DropTest(window=window, element="tet4")
    tracks, scheme = tracks_for(body, PLA, way, test)
    follow(CoreBody(body), scheme, tracks, no_progress)
    found = later_touches(tracks[0], RigidBody.of(body, scheme.gravity), period)
    assert len(found) == count
    if found:
        phases = drop(bar, PLA, way, DropTest(element="tet4"), device="cpu", period=period).phases[0]
        assert found[0].time == pytest.approx(phases[1].start, rel=0.02)
        assert found[0].speed == pytest.approx(phases[1].speed, rel=0.02)


def test_a_bar_in_six_tilts_meets_the_floor_as_in_a_full_run():
    """Every second touch within 3 % of its time and speed, none missed, the largest σ_V within 5 %.

    A second impact is one of a body at rest in itself: steep landings, whose other end comes down later, read up to a fifth less.
    """
    found = list(_landed_again("bar", box((24, 4, 1), (120.0, 20.0, 4.0)), tilted_ways(), 20.0, [f"{tilt:g}°" for tilt in TILTS]))
    assert [f"{one.case}: {one.error:.3g}, {one.note}" for one in found if not one.passed] == []
    assert sum("35°" in one.case for one in found) == 2
    assert [one.limit for one in found[-2:]] == [0.0, WORST]
    each = [(float(ours), float(whole)) for ours, whole in re.findall(r"([\d.]+) \(([\d.]+)\)", found[-1].note)]
    assert len(each) == len(TILTS)
    assert each[0][0] == pytest.approx(each[0][1], rel=0.03)
    assert all(ours > 0.8 * whole for ours, whole in each), found[-1].note


@pytest.mark.parametrize("name", quick(falls))
def test_the_simulation_holds(name, monkeypatch):
    """Of one body in half as many cells; the case of the suite drops two of them."""
    monkeypatch.setattr(falls, "_bodies", lambda: {"bracket": bracket(20.0, 8.0, 4.0, 4.0)})
    held(name)
