"""Lanes: which there are, a new one, and two iterations compared."""

import pytest

from mechstyle.errors import MissingPiece
from mechstyle.records.load_cases import Load, LoadCase, Support
from mechstyle.records.regions import Inside
from mechstyle.records.sentences import found
from mechstyle.runs.run import Draft
from mechstyle_widgets.panels.branches import Branches, most_bent, said, said_of, side_by_side
from mechstyle_widgets.state.controller import Controller
from mechstyle_widgets.state.studio_state import StudioState
from support.records import UNKNOWN, load_row, published_row, row, verdict


@pytest.fixture
def branches(done):
    """The lanes of a finished run with a branch; it is only looked at."""
    return Branches(Controller(StudioState(done), lambda: Draft(done.recipe, done.part, 500, "sheet")))


def test_lanes_are_listed_with_where_they_come_from(branches):
    words = [words for words, _ in branches._choice.options]
    assert words[0].endswith("MechStyle · 12")
    assert words[1].endswith("soft · 12, from MechStyle · 6")


def test_choosing_a_lane_shows_it_and_what_it_changed(branches):
    branches._choice.value = "soft"
    assert branches.state.lane == "soft"
    assert "faster than evenly" in branches._changes.value, "as the setting is called where it is made"
    assert "<td>evenly</td>" in branches._changes.value
    assert ">MechStyle</th>" in branches._changes.value, "lanes have one name everywhere"
    branches.state.lane = "main"
    assert branches._choice.value == "main"


def test_two_iterations_are_compared_in_settings_and_results(branches):
    branches.state.iteration = 4
    branches._pin.click()
    branches.state.lane, branches.state.iteration = "soft", 9
    table = {name: (there, here) for name, there, here in branches.comparison()}
    assert table["control"] == ("faster than evenly", "evenly")
    assert table["tested because"] == ("every 4 iterations", "every 3 iterations")
    tested = (branches.state.row(4, "main").verdict, branches.state.row(9, "soft").verdict)
    assert table["outcome"] == tuple(said_of(verdict) for verdict in tested)
    assert table["flat"] == tuple(found(verdict.row(landing="flat")) for verdict in tested)
    assert table["allowed"] == ("0.20 mm", "0.20 mm")
    assert "MechStyle · 4" in branches._comparison.value


def test_what_was_not_tested_has_a_dash_for_what_stays_bent(branches):
    branches.state.iteration = 5
    branches._pin.click()
    branches.state.iteration = 4
    table = {name: (there, here) for name, there, here in branches.comparison()}
    assert (table["outcome"][0], table["flat"][0]) == ("–", "–")
    assert table["flat"][1] != "–"


def test_nothing_is_compared_before_something_is_pinned(branches):
    assert branches.comparison() == []
    assert branches._comparison.layout.display == "none"


def test_a_branch_from_the_iteration_on_show_takes_what_was_changed_at_the_left(controller, settle):
    controller.run()
    settle(controller)
    branches = Branches(controller)
    controller.state.iteration = 5
    branches.branch()
    assert "Nothing differs from MechStyle" in branches.trouble
    controller.state.iteration = 6
    assert branches.trouble == "", "it is about what was asked for, and stays no longer than that"
    controller.state.iteration = 5
    changed = controller.state.run.recipe.with_settings(every=2)
    controller.wanted = lambda: Draft(changed, controller.state.run.part, 500, "sheet")
    branches._name.value = "often"
    assert branches._branch.description == "branch from iteration 5"
    branches._branch.click()
    settle(controller)
    assert (controller.state.lane, controller.state.run.recipe.schedule.every) == ("often", 2)
    assert branches.trouble == ""


def test_a_branch_has_the_very_settings_of_the_left_column(controller, settle):
    """Given `frozen` alone, a branch would compare with the part's own maximum, which is not what the column shows."""
    branches = Branches(controller)
    controller.run()
    settle(controller)
    shown = controller.state.run.recipe.with_settings(control="frozen", poses="resting")
    controller.wanted = lambda: Draft(shown, controller.state.run.part, 500, "sheet")
    controller.state.iteration = 5
    branches._branch.click()
    settle(controller)
    assert controller.state.lane == "branch-1"
    assert controller.state.run.recipe == shown


def test_a_name_that_cannot_be_is_refused_in_one_sentence(controller, settle):
    controller.run()
    settle(controller)
    controller.state.iteration = 5
    controller.branch(5, "12", control="linear")
    assert "lane name '12' must begin with" in controller.state.message


CASE = LoadCase(name="heavy coat", supports=(Support(at="resting face"),), loads=(Load(gravity=1.0),))


@pytest.mark.parametrize(("value", "words"), [
    (True, "yes"), (0.1234567, "0.1235"), ((), "–"), ("", "–"), (20, "20"), ((CASE,), "heavy coat"), ((Inside(),), "inside"),
])  # fmt: skip
def test_values_for_a_table(value, words):
    assert said(value) == words


def test_what_is_missing_for_a_branch_is_said(branches, done):
    def refuse():
        raise MissingPiece("the CLIP weights are not there; fetch them")

    branches.controller.wanted = refuse
    branches.branch()
    assert "the CLIP weights are not there; fetch them" in branches.trouble


FLAT, BENT = row(0.06, plain_permanent_set=0.05), row(1.24, plain_permanent_set=0.02, place="high up")
COAT, BROKEN = load_row(0.11, plain_permanent_set=0.1), load_row(3.0, carries=0.62, collapses=True)
TWO = ("Freestyle", "MechStyle")


@pytest.mark.parametrize(
    ("free", "fed", "kept", "words"),
    [
        ((BENT,), (FLAT,), (1.0, 0.97),
         "Both look alike. Freestyle stays bent by 1.24 mm and MechStyle stays bent by 0.06 mm, landing flat; 0.20 mm is allowed."),
        ((FLAT,), (row(0.07),), (0.94, 0.6),
         "MechStyle keeps 60% of the relief, Freestyle 94%. Of both 0.06 mm stays bent, landing flat; 0.20 mm is allowed."),
        ((FLAT, BROKEN), (FLAT, COAT), (None, None),
         "Freestyle gives way and MechStyle stays bent by 0.11 mm, under the load 'coat'; 0.20 mm is allowed."),
        ((published_row(60.0),), (published_row(40.0),), (1.0, 1.0),
         "Both look alike. Largest stress: Freestyle 60.0 MPa, MechStyle 40.0 MPa; 45.6 MPa is allowed."),
        ((BENT,), (load_row(),), (1.0, 1.0), "One of the two gave no answer, so there is nothing to compare."),
    ],
)  # fmt: skip
def test_two_runs_are_compared_in_the_test_that_decides(free, fed, kept, words):
    assert side_by_side(TWO, (verdict(*free), verdict(*fed)), kept) == words
    assert "nothing to compare" in side_by_side(TWO, (UNKNOWN, verdict(*fed)), kept)


def test_the_mark_at_the_worst_place_says_where_it_stays_bent_most():
    marked = most_bent("soft", verdict(FLAT), {"main": "0.04 mm", "soft": "0.06 mm"})
    assert marked.startswith("✕ marks where soft stays bent most (flat: plain 0.05 mm, brick 0.06 mm); ")
    assert marked.endswith("main 0.04 mm, soft 0.06 mm.")
