"""What a run will do, and what has come of it."""

import re
from html import escape
from types import SimpleNamespace

import msgspec
import pytest

from mechstyle.records import Doubt, sentences
from mechstyle.runs.summary import little_left
from mechstyle_widgets.panels.result import Result, carried, of_verdict, steps, weighed
from mechstyle_widgets.state.studio_state import StudioState
from support.records import load_row, row, verdict

SETTINGS = {"schedule": "every", "every": 4, "travel": 0.1, "iterations": 12, "relief": None, "amplitude": None, "orientations": 1}


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({}, "Drop it on the way, 2 times, in 3 landings"),
        ({"schedule": "geometry"}, "Drop it on the way, about"),
        ({"nearly_flat": False}, "Drop it on the way, 2 times, in 1 landing"),
        ({"nearly_flat": False}, "Drop what has come of it flat"),
        ({}, "Drop what has come of it flat and nearly flat"),
        ({"orientations": 2}, "Drop what has come of it flat, nearly flat and in 1 other landing"),
        ({"orientations": 5}, "Drop what has come of it flat, nearly flat and in 4 other landings"),
        ({"loads": ("a case",)}, "Drop what has come of it flat and nearly flat, and load it"),
    ],
)
def test_a_plan_is_given_step_by_step(changed, expected):
    said = steps({**SETTINGS, **changed})
    assert said[0].startswith("Drop the plain part flat")
    assert any(step == expected or step.startswith(f"{expected} ") for step in said), said


def test_what_is_dropped_at_the_end_only_is_not_dropped_on_the_way():
    assert not any("on the way" in step for step in steps({**SETTINGS, "schedule": "never"}))


def test_thickening_comes_before_all_else_where_it_is_asked_for():
    assert steps({**SETTINGS, "strengthen": 1.5})[0].startswith("Thicken it by up to 1.5 mm")
    assert not any("hicken" in step for step in steps({**SETTINGS, "strengthen": 0.0}))


def test_nothing_is_promised_while_the_settings_are_not_known():
    assert steps({}) == []


def test_a_plan_gives_way_to_the_table_of_falls_and_the_outcome_of_each_lane(done):
    state = StudioState()
    state.settings = SETTINGS
    result = Result(state)
    assert "Drop the plain part" in result.value
    state.open(done)
    assert "Drop the plain part" not in result.value
    last = done.history[-1].verdict
    for words in ("MechStyle", "soft", last.outcome, *sentences.COLUMNS, *sentences.tabulated(last)[1][0]):
        assert words in result.value
    assert last.head.split("(")[0] in result.value


def test_the_table_is_that_of_the_lane_on_show(done):
    state = StudioState(done)
    result, before = Result(state), Result(state).value
    state.lane = "soft"
    assert result.value != before
    _, verdict = next((row, row.verdict) for row in reversed(state.history) if row.verdict is not None)
    assert sentences.tabulated(verdict)[1][0][2] in result.value


def test_a_plain_part_has_one_column_of_what_stays_bent(done):
    plain = done.history[0].verdict
    assert '<th scope="col">stays bent</th>' in of_verdict(plain)
    assert '<th scope="col">plain</th>' not in of_verdict(plain)


def test_of_many_tests_the_worst_are_shown_and_all_unfold():
    """A standard has 27 landings; all of them pushed what is looked into out of sight."""
    rows = [row(0.01 * number, test="any landing", landing=f"on edge {number}") for number in range(12)]
    said = of_verdict(verdict(*rows))
    shown, _, every = said.partition("<details><summary>all 12 tests</summary>")
    assert [f"on edge {number}" for number in (11, 10, 9, 8)] == re.findall(r"on edge \d+(?=</td>)", shown)
    assert all(f"<td>{one.landing}</td>" in every for one in rows)
    assert "<details>" not in of_verdict(verdict(*rows[:4]))


def test_how_much_of_a_load_is_carried_stands_under_the_table():
    assert "it carries 1.50 times the load &#x27;coat&#x27;" in of_verdict(verdict(row(), load_row()))


def test_a_doubt_stands_under_the_table(done):
    last = done.history[-1].verdict
    assert "mechstyle-warning" not in of_verdict(msgspec.structs.replace(last, doubts=()))
    unsure = msgspec.structs.replace(last, doubts=(Doubt(about="relief", value=0.4),))
    assert "mechstyle-warning" in of_verdict(unsure)
    assert "between the relief the mesh is 40% thicker than the part" in of_verdict(unsure)


def test_what_gave_no_answer_has_no_table(done):
    unknown = msgspec.structs.replace(done.history[-1].verdict, outcome="UNKNOWN", rows=(), doubts=(), failure="the mesh is gone")
    assert of_verdict(unknown) == "<div>UNKNOWN: the mesh is gone.</div>"


def test_what_a_part_weighs_stands_under_its_verdict_beside_the_plain_one(done, monkeypatch):
    assert "weighs" not in Result(StudioState(done)).value, "a sheet encloses nothing"
    monkeypatch.setattr(type(done.part.surface), "volume", property(lambda mesh: 1000.0 if mesh is done.part.surface else 1100.0))
    density = done.recipe.test.material.density
    assert weighed(1100.0 * density, 1000.0 * density) in Result(StudioState(done)).value
    assert weighed(41.6, 38.2) == "Printed solid it weighs 42 g, the plain part 38 g."
    assert weighed(1.36, 1.24) == "Printed solid it weighs 1.4 g, the plain part 1.2 g."


def test_what_the_command_line_would_say_of_a_finished_lane_is_said_but_for_what_the_badge_says(done, monkeypatch):
    notes = ("the relief was lowered on 3% of the surface, where it would have folded over itself", "a note of <mine>")
    summary = SimpleNamespace(kept=0.33, notes=(*notes, little_left(0.33, "auto")))
    state = StudioState(done)
    assert "<details" not in Result(state).value
    monkeypatch.setattr(type(done), "summary", property(lambda _run: summary))
    result = Result(state)
    assert all(f"<li>{escape(note)}</li>" in result.value for note in notes)
    assert "outwards" not in result.value
    state.iteration = 8
    assert "<details" not in result.value


def test_how_much_of_a_load_is_carried_is_a_factor_and_what_was_not_tried_is_at_least():
    coat = load_row(0.11, plain_permanent_set=0.1)
    assert carried(coat) == "it carries 1.50 times the load 'coat'"
    assert carried(msgspec.structs.replace(coat, most_tried=True)) == "it carries at least 1.50 times the load 'coat'"
    assert carried(row(0.06)) == ""
