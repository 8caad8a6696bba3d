"""The timeline without a browser: what its traces hold, and that it is one with the state."""

from __future__ import annotations

import msgspec
import pytest
from plotly.graph_objects import Figure

from mechstyle.records import Doubt, sentences
from mechstyle_widgets.state.on_show import on_show
from mechstyle_widgets.state.outcomes import LOOKS
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.timeline.figure import contents, story
from mechstyle_widgets.timeline.timeline import Timeline
from support.models import alive
from support.records import published_row, verdict

LANES, STEPS, HOLDS, NO_WORSE, FAILS, UNKNOWN, OTHERS, ALLOWED, WORST, PLANNED = range(10)


@pytest.fixture
def state(done):
    return StudioState(done)


@pytest.fixture
def timeline(state):
    return Timeline(state)


def trace(timeline, number):
    return timeline._curves.data[number]


def frame(timeline):
    return timeline._curves.frame


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_traces_and_layout_are_such_as_plotly_knows(state, theme):
    """They are plain dictionaries, which nobody checks on the way to the page."""
    curves = Timeline(state, theme=theme)._curves
    figure = Figure(curves.data, curves.frame)
    assert len(figure.data) == len(curves.data)
    assert figure.layout.yaxis2.domain[1] < figure.layout.yaxis.domain[0], "one above the other"


def test_every_simulation_is_a_mark_by_its_outcome(timeline, state):
    for number, outcome in ((HOLDS, "HOLDS"), (NO_WORSE, "NO WORSE"), (FAILS, "FAILS"), (UNKNOWN, "UNKNOWN")):
        of_this = [row.iteration for row in state.histories["main"] if row.outcome == outcome]
        marks = zip(trace(timeline, number)["x"], trace(timeline, number)["y"], strict=True)
        assert [x for x, lane in marks if lane == "main"] == of_this
    assert sum(len(trace(timeline, number)["x"]) for number in (HOLDS, NO_WORSE, FAILS, UNKNOWN)) == 4 + 2


def test_outcomes_differ_in_shape_and_not_by_colour_alone():
    for by in ("mark", "symbol", "line", "fill"):
        assert len({getattr(look, by) for look in LOOKS.values()}) == len(LOOKS)


def test_hovering_tells_outcome_figure_and_reason_in_two_lines(state):
    row = state.row(4)
    first, second = story("a<b", row).split("<br>")
    assert first == f"<b>a&lt;b · iteration 4</b> · {row.outcome} · {sentences.least(row.verdict)}"
    assert second == "tested after step 4: every 4 iterations"
    assert story("main", state.row(3)) == "<b>main · iteration 3</b> · NOT TESTED"
    corrected = msgspec.structs.replace(row, reason="correction: half of the removed relief put back")
    assert story("main", corrected).split("<br>")[1] == "corrected after step 4: half of the removed relief put back"


def test_whose_story_it_is_is_said_while_another_run_is_asked_for(state, timeline):
    state.go_to("main", 4)
    assert "Last run" not in timeline._curves.story
    state.another = True
    assert f"Last run: {on_show(state).title} · " in timeline._curves.story
    state.another = False
    assert "Last run" not in timeline._curves.story


def test_a_branch_starts_where_it_forks_on_its_parents_line(timeline):
    lines = list(zip(trace(timeline, LANES)["x"], trace(timeline, LANES)["y"], strict=True))
    assert lines == [(0, "main"), (12, "main"), (None, "main"), (6, "main"), (6, "soft"), (7, "soft"), (12, "soft"), (None, "soft")]


def test_the_axis_of_lanes_is_one_of_names_before_a_run_as_well():
    timeline = Timeline(StudioState(settings=ASKED))
    assert set(trace(timeline, LANES)["y"]) == {"MechStyle"}, "plotly would take it for an axis of numbers, on which no mark is seen"


def test_what_stays_bent_stands_beside_what_is_allowed(timeline, state):
    decide = [row.verdict.deciding for row in state.history if row.verdict is not None]
    assert trace(timeline, WORST)["y"] == [row.permanent_set for row in decide]
    assert trace(timeline, ALLOWED)["y"][: len(decide)] == [row.allowed for row in decide]
    assert frame(timeline)["yaxis2"]["title"]["text"] == "[mm]"
    assert sentence(timeline) == f"allowed {sentences.allowed(decide[-1])}"


def test_by_the_published_rule_it_is_the_stress(state):
    row = msgspec.structs.replace(state.row(4), verdict=verdict(published_row(30.0), criterion="paper"))
    traces, layout = contents({"main": [row]}, [], "main", "light")
    assert (traces[WORST]["y"], traces[ALLOWED]["y"]) == ([30.0], [45.6, None])
    assert layout["yaxis2"]["title"]["text"] == "[MPa]"
    assert layout["annotations"][0]["text"] == "allowed 45.6 MPa"


def test_what_is_not_sure_has_a_line_around_its_mark(state):
    row = state.row(4)
    doubt = Doubt(about="relief", value=0.4)
    sure, unsure = (msgspec.structs.replace(row, verdict=msgspec.structs.replace(row.verdict, doubts=doubts)) for doubts in ((), (doubt,)))
    traces, _ = contents({"main": [sure, unsure]}, [], "main", "light")
    assert traces[WORST]["marker"]["line"]["width"] == [0, 2]
    assert traces[HOLDS + list(LOOKS).index(row.outcome)]["marker"]["line"]["width"] == [0, 2]


def test_the_line_stands_at_the_iteration(timeline, state):
    state.iteration = 5
    assert timeline.iteration == timeline._curves.head == 5


def test_what_is_said_of_the_iteration_on_show_stands_under_the_chart(timeline, state):
    state.iteration = 4
    assert timeline._curves.story.startswith("<b>MechStyle · iteration 4</b>")
    assert "tested after step 4: " in timeline._curves.story
    state.iteration = 5
    assert timeline._curves.story == "<b>MechStyle · iteration 5</b> · NOT TESTED"


def test_the_line_and_the_trait_move_the_state(timeline, state):
    timeline._curves.head = 3
    assert (timeline.iteration, state.iteration) == (3, 3)
    timeline.iteration = 99
    assert (timeline.iteration, state.iteration) == (12, 12)


def test_a_run_is_followed_however_late_the_curves_are_drawn(fake):
    """The line may move before the figure is drawn again."""
    state = StudioState(fake.run)
    timeline = Timeline(state)
    timeline._redraw._act = lambda: None
    fake.go()
    state.tell(stale=True)
    state.pump()
    assert (state.iteration, timeline.iteration, timeline._curves.head, state.follow) == (12, 12, 12, True)
    timeline._curves.head = 5
    assert (state.iteration, state.follow) == (5, False)


def test_the_browser_is_told_how_far_the_line_goes_before_it_is_there(fake, monkeypatch):
    """Told both at once, what plays may set the value first, cut it off and send it back as if the user had chosen it."""
    state = StudioState(fake.run)
    timeline, told = Timeline(state), []
    monkeypatch.setattr(timeline._curves, "send_state", lambda key=None: told.append(key))
    fake.go()
    state.tell(stale=True)
    state.pump()
    assert told.count("last") == told.count("head") == 1, "each in a message of its own"
    assert told.index("last") < told.index("head")


def test_a_click_shows_lane_and_iteration(timeline, state):
    place = next(number for number, lane in enumerate(trace(timeline, STEPS)["y"]) if lane == "soft") + 1
    timeline._curves._handle_custom_msg({"kind": "click", "trace": STEPS, "point": place}, [])
    assert (state.lane, timeline.lane, state.iteration) == ("soft", "soft", 8)
    assert trace(timeline, ALLOWED)["x"][-2] == 12


def test_it_grows_with_the_run(fake):
    fake.go()
    state = StudioState(fake.run)
    timeline = Timeline(state)
    state.run.branch(4, lane="late", control="linear")
    fake.go("late")
    state.tell(stale=True)
    state.pump()
    assert set(trace(timeline, STEPS)["y"]) == {"main", "late"}
    assert frame(timeline)["height"] > 0


ASKED = {"schedule": "every", "every": 5, "travel": 0.1, "iterations": 20, "relief": None, "amplitude": None}


def sentence(timeline):
    return frame(timeline)["annotations"][0]["text"].replace("<br>", " ")


def test_before_there_is_a_run_it_says_what_will_appear():
    timeline = Timeline(StudioState())
    assert trace(timeline, STEPS)["x"] == trace(timeline, PLANNED)["x"] == []
    assert "Nothing has run yet" in sentence(timeline)


def test_before_there_is_a_run_it_shows_where_the_schedule_will_simulate():
    timeline = Timeline(StudioState(settings=ASKED))
    assert trace(timeline, PLANNED)["x"] == [0, 5, 10, 15, 20]
    assert "The part will be dropped at the hollow marks." in sentence(timeline)
    timeline._state.settings = {**ASKED, "every": 10}
    assert trace(timeline, PLANNED)["x"] == [0, 10, 20]
    timeline._state.settings = {**ASKED, "schedule": "stress"}
    assert "the run decides" in sentence(timeline)
    timeline._clicked(PLANNED, 1)
    assert timeline.iteration == 0


@pytest.mark.parametrize("width", [240, 320, 400, 900])
def test_before_there_is_a_run_its_words_fit_beside_the_axis(width):
    """Letters of the figure's font are at most 6.6 pixels wide on average."""
    timeline = Timeline(StudioState(settings=ASKED), width=width)
    lines = frame(timeline)["annotations"][0]["text"].split("<br>")
    assert max(map(len, lines)) * 6.6 <= width - 96 - 12
    assert "The part will be dropped at the hollow marks." in sentence(timeline)


def test_the_plan_gives_way_to_what_was_simulated(fake):
    state = StudioState(fake.run, settings=ASKED)
    timeline = Timeline(state)
    assert trace(timeline, PLANNED)["x"] == [0, 5, 10, 15, 20]
    fake.go()
    state.tell(stale=True)
    state.pump()
    state.settings = {**ASKED, "every": 10}
    assert trace(timeline, PLANNED)["x"] == []
    assert trace(timeline, STEPS)["x"] == list(range(13))
    assert frame(timeline)["yaxis2"]["showticklabels"]
    assert "allowed" in sentence(timeline)


def test_what_is_allowed_is_named_over_the_end_of_its_line(timeline):
    """At its beginning, where something else may be allowed, the words were crossed out by the line."""
    note, line = frame(timeline)["annotations"][0], trace(timeline, ALLOWED)
    assert note["y"] == [one for one in line["y"] if one is not None][-1]
    assert (note["x"], note["xanchor"], note["yanchor"]) == (12, "right", "bottom")


def test_what_is_allowed_is_named_within_the_curves_while_there_is_little_of_them(state):
    """Left of the first test it lay over the figures of the axis."""
    rows, whole = state.history, [branch for branch in state.branches if branch.lane == "main"]
    for upto, side in ((0, "left"), (4, "left"), (12, "right")):
        [note] = contents({"main": [row for row in rows if row.iteration <= upto]}, whole, "main", "light")[1]["annotations"]
        assert (note["x"], note["xanchor"], note["xshift"] > 0) == (upto, side, side == "left")


def test_the_theme_changes_the_template(timeline):
    before = frame(timeline)["template"]
    timeline.theme = "dark"
    assert frame(timeline)["template"] != before
    assert frame(timeline)["paper_bgcolor"] == "#111111", "pale words need a dark ground where the notebook is light"
    assert frame(timeline)["annotations"][0]["font"]["color"] == "#ff8a80", "the red of a mark is no ink for small words on a dark ground"


def test_closing_leaves_nothing_behind(state):
    Timeline(state).close()  # what all share is made once
    before = alive()
    timeline = Timeline(state)
    timeline.close()
    state.iteration = 3
    assert timeline.iteration == 12
    assert alive() == before
    timeline.close()


def test_a_page_that_is_loaded_anew_gets_what_the_figure_shows(done):
    state = StudioState()
    timeline = Timeline(state)
    assert "Nothing has run yet" in str(timeline._curves.get_state()["frame"])
    state.open(done)
    sent = timeline._curves.get_state()
    assert "Nothing has run yet" not in str(sent["frame"])
    assert sent["data"][STEPS]["x"] == [row.iteration for row in state.history] + [7, 8, 9, 10, 11, 12]
    assert sent["head"] == 12


def test_the_scripts_of_plotly_come_when_a_page_asks_and_are_no_part_of_the_state(timeline, monkeypatch):
    sent = []
    monkeypatch.setattr(timeline._curves, "send", lambda content, buffers=None: sent.append((content, buffers)))
    assert len(str(timeline._curves.get_state())) < 60_000
    timeline._curves._handle_custom_msg({"kind": "plotly"}, [])
    [(content, [script])] = sent
    assert content == {"kind": "plotly"}
    assert b"Plotly" in script


def test_the_line_does_not_leave_a_lane_of_one_iteration(fake):
    next(fake.session()._events(lambda _fraction: None))
    timeline = Timeline(StudioState(fake.run))
    timeline._curves.set_state({"head": 1.0})
    assert (timeline._curves.head, timeline.iteration) == (0, 0)
