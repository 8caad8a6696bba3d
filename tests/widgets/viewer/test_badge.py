"""The badge: the word of the verdict, the least factor of the rules that count, and the way to the place that decides."""

import msgspec
import numpy as np
import pytest

from mechstyle.records import Judgement, Simulation, Verdict
from mechstyle_widgets.state.outcomes import LOOKS
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.viewer import badge
from mechstyle_widgets.viewer.run_viewer import RunViewer


def rule(value, limit, *, unit="MPa", marginal=False):
    return Judgement(rule="a rule", outcome="VIABLE" if value <= limit else "FAILS", value=value, limit=limit, unit=unit, marginal=marginal)


def verdict(as_placed, all_orientations=None, **more):
    outcome = "FAILS" if any(one and one.outcome == "FAILS" for one in (as_placed, all_orientations)) else "VIABLE"
    given = {"outcome": outcome, "criterion": "robust", "literal": rule(80.0, 45.0), "words": "", **more}
    return Verdict(as_placed=as_placed, all_orientations=all_orientations, **given)


def test_the_figure_is_the_factor_of_the_rule_that_decides():
    told = badge.told(verdict(rule(43.8, 45.6), rule(1.18, 1.10, unit="x the original")))
    assert "FAILS" in told
    assert "<b>0.93</b>" in told
    assert "1.18 of 1.10 times, of all landings" in told
    assert LOOKS["FAILS"].fill in told


def test_what_is_not_sure_is_amber_and_never_green():
    told = badge.told(verdict(rule(44.0, 45.0, marginal=True)))
    assert "MARGINAL" in told
    assert "VIABLE" not in told
    assert LOOKS["MARGINAL"].fill in told
    assert LOOKS["VIABLE"].fill not in told


def test_no_answer_has_no_figure():
    told = badge.told(verdict(rule(float("nan"), 45.0), outcome="UNKNOWN"))
    assert "UNKNOWN" in told
    assert "nan" not in told
    assert "safety factor" not in told


@pytest.mark.parametrize("look", LOOKS.values())
def test_words_on_a_badge_can_be_read(look):
    def luminance(colour):
        channels = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
        return np.where(channels <= 0.03928, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4) @ (0.2126, 0.7152, 0.0722)

    low, high = sorted((luminance(look.fill), luminance(look.ink)))
    assert (high + 0.05) / (low + 0.05) >= 4.5


def test_it_tells_of_the_last_drop_and_when_that_was(done):
    state = StudioState(done)
    viewer = RunViewer(state)
    state.iteration = 6
    tested = state.row(4)
    assert f"<b>{tested.verdict.safety_factor:.2f}</b>" in viewer.badge._words.value
    assert "tested at iteration 4" in viewer.badge._words.value
    state.iteration = 12
    assert "tested at" not in viewer.badge._words.value


def test_the_worst_place_is_flown_to_and_asked_about(done):
    state = StudioState(done)
    viewer = RunViewer(state)
    before = tuple(viewer._orbit.three.position)
    viewer.badge._worst.click()
    worst = done.store.objects.get_record(state.checkpoint.simulation, Simulation)
    place = badge.worst_place(state.row().verdict, worst)
    nearest = np.linalg.norm(viewer.at_rest.vertices - place, axis=1).argmin()
    assert viewer.probed == nearest
    assert tuple(viewer._orbit.three.position) != before
    np.testing.assert_allclose(viewer._orbit.seen.target, viewer.subject.mesh.vertices[nearest], atol=1e-6)


def test_the_place_is_that_of_the_test_whose_rule_decides(done):
    tested = done.simulation()
    there = msgspec.structs.replace(tested.as_placed, where=(1.0, 2.0, 3.0))
    tested = Simulation(**{**{name: getattr(tested, name) for name in tested.__dataclass_fields__}, "overall": there})
    assert badge.worst_place(verdict(rule(20.0, 45.0), rule(1.05, 1.10, unit="x the original")), tested) == (1.0, 2.0, 3.0)
    assert badge.worst_place(verdict(rule(44.0, 45.0), rule(0.5, 1.10, unit="x the original")), tested) == tested.as_placed.where


def test_keys_turn_the_part_and_bring_it_back(done):
    viewer = RunViewer(StudioState(done))
    home = viewer._orbit.seen
    viewer.key("ArrowRight")
    assert viewer._orbit.seen.azimuth == pytest.approx(home.azimuth + 15.0)
    viewer.key("ArrowUp", ctrl=True)
    assert viewer._orbit.seen.elevation == pytest.approx(home.elevation + 1.0)
    viewer.key("+")
    assert viewer._orbit.seen.distance < home.distance
    viewer.key("5", shift=True)
    assert viewer._orbit.seen.distance == pytest.approx(home.distance)
    for _ in range(12):
        viewer.key("ArrowUp")
    assert viewer._orbit.seen.elevation == pytest.approx(85.0)
