"""The replay without a browser: its data, its traits, and what it refuses."""


import pytest
from ipywidgets import Widget

from mechstyle.errors import BadInput
from mechstyle.runs.report.replay_data import replay_data
from mechstyle_widgets.replay.replay import Replay
from support.lanes import carry_on, lane_on_a_sheet
from support.models import alive


@pytest.fixture
def run(tmp_path):
    return lane_on_a_sheet(tmp_path / "run", iterations=20)


@pytest.fixture
def replay(run):
    yield Replay(run)
    Widget.close_all()


def test_it_stands_at_the_end_and_holds_the_data(replay, run):
    played = replay_data(run)
    assert (replay.iteration, replay.layer, replay.threshold) == (20, "style", None)
    assert replay._header == played.header
    assert replay._payload == played.payload


def test_it_is_shown_by_a_page_that_has_widgets_and_said_by_one_that_has_none(replay):
    shown, _ = replay._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in shown
    assert "widgets" in shown["text/plain"]


def test_everything_can_be_said_at_once(run):
    replay = Replay(run, iteration=7, layer="stress", threshold=22.0)
    assert (replay.iteration, replay.layer, replay.threshold) == (7, "stress", 22.0)
    replay.close()


def test_a_layer_brings_its_threshold_and_keeps_one_that_is_set(replay, run):
    replay.layer = "stress"
    assert replay.threshold == run.verdict.deciding.limit
    replay.threshold = 25.0
    replay.iteration = 3
    assert replay.threshold == 25.0
    replay.layer = "demand"
    assert replay.threshold == run.recipe.restraint.threshold
    replay.threshold = None
    assert replay.threshold is None
    replay.layer = "restraint"
    assert replay.threshold is None


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("iteration", 21, "iteration 21 is not in this replay: it holds 0 to 20"),
        ("layer", "stres", "did you mean 'stress'"),
        ("threshold", 1.0, "the layer 'style' has no threshold"),
    ],
)
def test_what_cannot_be_shown_is_refused_and_nothing_changes(replay, name, value, words):
    before = (replay.iteration, replay.layer, replay.threshold)
    with pytest.raises(BadInput, match=words):
        setattr(replay, name, value)
    assert (replay.iteration, replay.layer, replay.threshold) == before


def test_a_threshold_is_a_number(replay):
    replay.layer = "stress"
    with pytest.raises(BadInput, match="must be a number, not nan"):
        replay.threshold = float("nan")


@pytest.mark.parametrize(
    "wrong", [{"layer": "nonsense"}, {"iteration": 99}, {"threshold": 2.0}, {"layer": "stress", "threshold": float("inf")}]
)
def test_a_refused_replay_leaves_nothing_behind(run, wrong):
    before = alive()
    with pytest.raises(BadInput):
        Replay(run, **wrong)
    assert alive() == before


def test_a_replay_takes_in_what_the_run_did_since(run):
    branch = run.branch(10, lane="later", iterations=30, seed=1)
    replay = Replay(branch)
    assert replay.iteration == 10
    carry_on(branch)
    replay.refresh()
    assert replay.iteration == 30
    replay.iteration = 4
    replay.refresh()
    assert replay.iteration == 4
    replay.close()
