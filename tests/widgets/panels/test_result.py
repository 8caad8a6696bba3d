"""What a run will do, and what has come of it."""

import re
from html import escape
from types import SimpleNamespace

import msgspec
import pytest

from mechstyle.records import Doubt, Recipe, sentences
from mechstyle.records.material import LIBRARY
from mechstyle.runs.summary import little_left
from mechstyle.simulation.estimate import estimated
from mechstyle_widgets.panels import result
from mechstyle_widgets.panels.result import Result, figures, of_show, steps
from mechstyle_widgets.state.on_show import OnShow
from mechstyle_widgets.state.outcomes import LOOKS
from mechstyle_widgets.state.studio_state import StudioState
from support.records import load_row, row, verdict

SETTINGS = {"schedule": "every", "every": 4, "travel": 0.1, "iterations": 12, "relief": None, "amplitude": None, "orientations": 1}


def told(one):
    """All that is said of a verdict."""
    return "".join(of_show(OnShow("sheet, brick", verdict=one)))


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
    said = [step for step, _, _ in steps({**SETTINGS, **changed})]
    assert said[0].startswith("Drop the plain part flat")
    assert any(step == expected or step.startswith(f"{expected} ") for step in said), said


def test_what_is_dropped_at_the_end_only_is_not_dropped_on_the_way():
    assert not any("on the way" in step for step, _, _ in steps({**SETTINGS, "schedule": "never"}))


def test_thickening_comes_before_all_else_where_it_is_asked_for():
    assert steps({**SETTINGS, "strengthen": 1.5})[0][0].startswith("Thicken it by up to 1.5 mm")
    assert not any("hicken" in step for step, _, _ in steps({**SETTINGS, "strengthen": 0.0}))


@pytest.mark.parametrize("changed", [{}, {"nearly_flat": False}, {"orientations": 5}, {"guarantee": False}, {"schedule": "never"}], ids=str)
def test_the_falls_of_all_steps_are_those_that_stand_at_the_run(changed):
    """The line at *Run* told of 33 falls, and the list of two times in three landings."""
    settings = {**SETTINGS, **changed}
    told = estimated(Recipe.of(prompt="brick", material=LIBRARY["PLA"], **settings), 2000).falls
    assert sum(count + more for _, count, more in steps(settings)) == told


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


def test_the_table_is_that_of_the_iteration_on_show(done):
    state = StudioState(done)
    result, before = Result(state), Result(state).value
    state.lane = "soft"
    assert result.value != before
    assert sentences.tabulated(state.row().verdict)[1][0][2] in result.value
    state.iteration = 7
    assert "NOT TESTED since iteration" in result.value
    assert not any(outcome in result.value.partition("<details")[0] for outcome in LOOKS), "of another surface"


def test_a_plain_part_has_one_column_of_what_stays_bent(done):
    plain = done.history[0].verdict
    assert '<th scope="col">stays bent</th>' in told(plain)
    assert '<th scope="col">plain</th>' not in told(plain)


def test_of_many_tests_the_worst_are_shown_and_all_unfold():
    """A standard has 27 landings; all of them pushed what is looked into out of sight."""
    rows = [row(0.01 * number, test="any landing", landing=f"on edge {number}") for number in range(12)]
    said = told(verdict(*rows))
    shown, _, every = said.partition("<details><summary>all 12 tests</summary>")
    assert [f"on edge {number}" for number in (11, 10, 9, 8)] == re.findall(r"on edge \d+(?=</td>)", shown)
    assert all(f"<td>{one.landing}</td>" in every for one in rows)
    assert "<details>" not in told(verdict(*rows[:4]))


def test_how_much_of_a_load_is_carried_stands_under_the_table():
    assert "it carries 1.50 times the load &#x27;coat&#x27;" in told(verdict(row(), load_row()))


def test_a_doubt_stands_under_the_table(done):
    last = done.history[-1].verdict
    assert "mechstyle-warning" not in told(msgspec.structs.replace(last, doubts=()))
    unsure = msgspec.structs.replace(last, doubts=(Doubt(about="relief", value=0.4),))
    assert "mechstyle-warning" in told(unsure)
    assert "between the relief the mesh is 40% thicker than the part" in told(unsure)


def test_what_gave_no_answer_has_no_table(done):
    unknown = msgspec.structs.replace(done.history[-1].verdict, outcome="UNKNOWN", rows=(), doubts=(), failure="the mesh is gone")
    assert told(unknown) == "<div>UNKNOWN: the mesh is gone.</div>"


def test_what_a_part_weighs_and_costs_stands_beside_the_plain_one(done, monkeypatch):
    assert "printed solid" not in Result(StudioState(done)).value, "a sheet encloses nothing"
    monkeypatch.setattr(type(done.part.surface), "volume", property(lambda mesh: 30e3 if mesh is done.part.surface else 33e3))
    state, density = StudioState(done, price=20.0), done.recipe.test.material.density
    told = Result(state).value
    assert f"<dd>{33e3 * density:.0f} g</dd>" in told
    assert f"{33e3 * density * 0.02:.2f} of your currency, plain {30e3 * density:.0f} g" in told
    assert "printed solid" in told


def test_a_print_with_infill_is_not_called_solid(done, monkeypatch):
    monkeypatch.setattr(type(done.part.surface), "volume", property(lambda _: 30e3))
    monkeypatch.setattr(result, "plastic_share", lambda *_: 0.8)
    monkeypatch.setattr(type(done.recipe.printed), "solid", property(lambda _: False))
    told = Result(StudioState(done)).value
    assert f"<dd>{0.8 * 30e3 * done.recipe.test.material.density:.0f} g</dd>" in told
    assert "printed as asked" in told
    assert "printed solid" not in told


def test_three_figures_are_those_of_the_test_that_decides():
    one = verdict(row(0.12, plain_permanent_set=0.06), load_row(0.61))
    told = figures(OnShow("sheet, brick", verdict=one, kept=0.79))
    assert "<dd>0.61 mm</dd>" in told
    assert f"allowed {sentences.allowed(one.deciding)}" in told
    assert "<dd>79%</dd>" in told
    assert "0.12 mm" not in told


def test_a_part_that_cracks_says_so_under_its_figure():
    told = figures(OnShow("sheet, brick", verdict=verdict(row(0.53, cracks=True)), kept=0.93))
    assert "<dd>0.53 mm</dd><dd><small>cracks, allowed" in told


def test_what_was_not_tested_has_no_figure_of_another_test():
    told = figures(OnShow("sheet, brick", verdict=None, tested_at=5))
    assert "<dt>stays bent</dt><dd>–</dd><dd><small></small></dd>" in told, "the head over it says that it was not tested"
    assert "mm" not in told


def test_what_the_command_line_would_say_of_a_finished_lane_is_said_but_for_what_the_badge_says(done, monkeypatch):
    notes = ("the relief was lowered on 3% of the surface, where it would have folded over itself", "a note of <mine>")
    summary = SimpleNamespace(kept=0.33, notes=(*notes, little_left(0.33, 0.5)))
    state = StudioState(done)
    assert "<ul>" not in Result(state).value
    monkeypatch.setattr(type(done), "summary", property(lambda _run: summary))
    result = Result(state)
    assert all(f"<li>{escape(note)}</li>" in result.value for note in notes)
    assert "outwards" not in result.value
    state.iteration = 8
    assert "<ul>" not in result.value
