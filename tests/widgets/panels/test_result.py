"""What a run will do, and what has come of it."""

import msgspec
import pytest

from mechstyle_widgets.panels.result import Result, informing, steps
from mechstyle_widgets.state.studio_state import StudioState
from support.lanes import lane_on_a_sheet

SETTINGS = {"schedule": "every", "every": 4, "travel": 0.1, "iterations": 12, "relief": None, "amplitude": None, "orientations": 6}


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({}, "Drop it on the way, 2 times"),
        ({"schedule": "geometry"}, "Drop it on the way, about"),
        ({"orientations": 1}, "Drop what has come of it, once"),
        ({"orientations": 5, "tilts": 3}, "Drop what has come of it, 8 times"),
    ],
)
def test_a_plan_is_told_step_by_step(changed, told):
    said = steps({**SETTINGS, **changed})
    assert said[0] == "Drop the part as it came"
    assert any(step.startswith(told) for step in said)


def test_what_is_dropped_at_the_end_only_is_not_dropped_on_the_way():
    assert not any("on the way" in step for step in steps({**SETTINGS, "schedule": "never"}))


def test_thickening_comes_before_all_else_where_it_is_asked_for():
    assert steps({**SETTINGS, "strengthen": 1.5})[0].startswith("Thicken it by up to 1.5 mm")
    assert not any("hicken" in step for step in steps({**SETTINGS, "strengthen": 0.0}))


def test_nothing_is_promised_while_the_settings_are_not_known():
    assert steps({}) == []


def test_a_plan_gives_way_to_the_last_verdict_of_each_lane(done):
    state = StudioState()
    state.settings = SETTINGS
    result = Result(state)
    assert "Drop the part as it came" in result.value
    state.open(done)
    assert "Drop the part" not in result.value
    last = done.history[-1].verdict
    assert "as it came" in result.value.replace("\N{NO-BREAK SPACE}", " ")
    for word in ("main", "soft", f"{last.safety_factor:.2f}", last.tightest.short):
        assert word in result.value


def test_the_worst_landing_and_random_drops_stand_beside_those_of_the_part_as_it_came(tmp_path, monkeypatch):
    done, state = lane_on_a_sheet(tmp_path / "run", iterations=10), StudioState()
    summary = done.summary
    known = {"worst": 151.2, "worst_landing": "direction 1", "failure_probability": 0.4}
    now, before = (msgspec.structs.replace(strength, **known) for strength in (summary.result, summary.baseline))
    other = msgspec.structs.replace(summary, result=now, baseline=msgspec.structs.replace(before, worst=98.0, failure_probability=0.1))
    result = Result(state)
    monkeypatch.setattr(type(done), "summary", other)
    state.open(done)
    assert "Worst landing of main: 151 MPa, direction 1; as it came 98 MPa. 40% of random drops begin to yield it, 10% as" in result.value
    unknown = msgspec.structs.replace(before, worst=None, failure_probability=None)
    monkeypatch.setattr(type(done), "summary", msgspec.structs.replace(summary, result=now, baseline=unknown))
    assert informing(done) == ""
    assert informing(None) == ""
