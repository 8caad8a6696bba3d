"""The badge: the outcome in a few words, the figures behind it, and the way to the place that decides."""

from html import escape
from types import SimpleNamespace

import numpy as np
import pytest

from mechstyle.records import Doubt, sentences
from mechstyle.runs.summary import little_left
from mechstyle_widgets.state.on_show import OnShow
from mechstyle_widgets.state.outcomes import DOUBT, LOOKS, UNTESTED
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.viewer import badge
from mechstyle_widgets.viewer.run_viewer import RunViewer
from support.records import UNKNOWN, load_row, published_row, row, verdict


def judged(one, **more):
    """The badge of a verdict."""
    return badge.of(OnShow("sheet, brick", verdict=one, **more))


def test_it_says_the_outcome_with_its_fall_and_what_the_test_that_decides_found():
    said = judged(verdict(row(0.12)), kept=0.8)
    assert "HOLDS a fall of 1.5 m" in said
    assert "flat: plain 0 mm, brick 0.12 mm · 80% of the relief kept" in said
    assert LOOKS["HOLDS"].fill in said
    assert DOUBT not in said
    assert sentences.NOT_SURE not in said


def test_the_figures_are_those_of_the_test_that_decides():
    said = judged(verdict(row(0.12), load_row(0.61)))
    assert "FAILS the load" in said
    assert "load coat: plain 0 mm, brick 0.61 mm" in said
    assert LOOKS["FAILS"].fill in said


def test_no_worse_has_a_mark_and_a_shade_of_its_own():
    said = judged(verdict(row(0.33, plain_permanent_set=0.3, allowed=0.35, outcome="NO WORSE")))
    assert "NO WORSE than the plain part" in said
    assert LOOKS["NO WORSE"].fill in said
    assert LOOKS["NO WORSE"].mark in said


def test_what_is_not_sure_has_an_amber_line_around_its_own_colour():
    doubt = Doubt(about="limit", value=0.99, test="flat", landing="flat")
    said = judged(verdict(row(0.19), doubts=(doubt,)))
    assert f"outline:3px solid {DOUBT}" in said
    assert "not sure" in said
    assert LOOKS["HOLDS"].fill in said


def test_no_answer_is_amber_and_has_no_figure():
    said = judged(UNKNOWN)
    assert "UNKNOWN" in said
    assert "the integration blew up" in said
    assert LOOKS["UNKNOWN"].fill in said
    assert "<small></small>" in said


def test_where_the_mouse_rests_it_says_how_the_part_is_judged_and_every_figure():
    found = verdict(row(0.12), load_row(0.33, plain_permanent_set=0.3, allowed=0.35, outcome="NO WORSE"))
    title = judged(found).split('title="')[1].split('">')[0]
    for sentence in sentences.EXPLANATION:
        assert escape(sentence) in title
    for line in sentences.tabulated(found)[1]:
        for cell in line:
            assert escape(cell) in title


@pytest.mark.parametrize("look", LOOKS.values())
def test_words_on_a_badge_can_be_read(look):
    def luminance(colour):
        channels = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
        return np.where(channels <= 0.03928, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4) @ (0.2126, 0.7152, 0.0722)

    low, high = sorted((luminance(look.fill), luminance(look.ink)))
    assert (high + 0.05) / (low + 0.05) >= 4.5


def test_a_surface_that_was_not_tested_says_so_in_grey_and_since_when(done):
    state = StudioState(done)
    viewer = RunViewer(state)
    state.iteration = 4
    found = state.row(4).verdict
    assert LOOKS[found.outcome].fill in viewer.badge._words.value
    state.iteration = 6
    said = viewer.badge._words.value
    assert sentences.NOT_TESTED in said
    assert "since iteration 4" in said
    assert f"background:{UNTESTED.fill}" in said
    assert not any(outcome in said.partition("</style>")[2] for outcome in LOOKS), "that was another surface"
    state.iteration = 12
    assert sentences.NOT_TESTED not in viewer.badge._words.value


@pytest.mark.parametrize("left", [0.33, 0.95])
def test_where_little_of_the_style_is_left_it_says_so_and_what_to_try(done, monkeypatch, left):
    """The command line said it, and who ran it in a Studio never heard."""
    notes = tuple(filter(None, ("drawn with care", little_left(left, 0.5))))
    monkeypatch.setattr(type(done), "summary", property(lambda _run: SimpleNamespace(kept=left, notes=notes)))
    state = StudioState(done)
    viewer = RunViewer(state)
    said = viewer.badge._words.value
    assert f"{left:.0%} of the relief kept" in said
    assert [note for note in notes if escape(note) in said] == [note for note in notes if "outwards" in note]
    state.iteration = 8
    assert "outwards" not in viewer.badge._words.value


def test_the_worst_place_is_flown_to_and_asked_about(done):
    state = StudioState(done)
    viewer = RunViewer(state)
    before = tuple(viewer._orbit.three.position)
    viewer.badge._worst.click()
    vertices, bent = viewer.subject.mesh.vertices, viewer.subject.layer("stays_bent")
    nearest = viewer.probed
    assert (nearest, bent.values[nearest]) == (bent.peak, np.float32(done.history[-1].verdict.deciding.permanent_set))
    assert tuple(viewer._orbit.three.position) != before
    np.testing.assert_allclose(viewer._orbit.seen.target, vertices[nearest], atol=1e-6)


def test_where_nothing_stays_bent_the_worst_place_is_that_of_the_largest_stress(done):
    checkpoint, mesh = done.checkpoint(12), done.surface(12)
    for found in (verdict(row(0.0, place="")), verdict(published_row(), criterion="paper"), UNKNOWN):
        assert badge.worst_vertex(mesh, checkpoint, done.simulation(12), found) == checkpoint.stress.argmax()


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


def test_in_full_every_test_is_a_line_between_how_it_is_judged_and_the_doubt():
    judged = verdict(
        row(0.06, plain_permanent_set=0.05), row(0.1, test="nearly flat", landing="tilted left"), doubts=(Doubt(about="relief", value=0.7),)
    )
    first, said, flat, nearly, last = badge.in_full(judged).splitlines()
    assert (first, said, last) == (" ".join(sentences.EXPLANATION), judged.head, judged.doubt)
    assert flat == "flat: plain 0.05 mm, styled 0.06 mm, allowed 0.20 mm, strain 0.0%, outcome HOLDS"
    assert nearly.startswith("tilted left: plain 0 mm")
