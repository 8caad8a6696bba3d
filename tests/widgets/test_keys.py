"""The keys of the Studio, as the page hands them over; `tests/browser/test_access.py` presses them."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.gallery import make
from mechstyle_widgets import Studio, Viewer
from mechstyle_widgets.jupyter.frame import Frame


@pytest.fixture
def studio(done):
    opened = Studio(done)
    yield opened
    opened.close()


def press(studio, key):
    studio.frame._handle_custom_msg({"kind": "studio", "key": key}, [])


def test_p_paints_and_escape_leaves_the_brush_before_anything_else(studio):
    press(studio, "m")
    press(studio, "p")
    press(studio, "Escape")
    assert (studio.regions_picker.paint, studio.viewer.tool) == (False, "measure")


def test_w_asks_what_if(studio):
    studio._tabs.selected_index = 1
    press(studio, "w")
    assert studio._tabs.titles[studio._tabs.selected_index] == "What if"


def test_i_shows_the_impact_and_then_the_part_at_rest(studio, monkeypatch):
    asked = []
    monkeypatch.setattr(studio.viewer.player, "play", lambda: asked.append("play"))
    press(studio, "i")
    assert asked == ["play"]


def test_i_while_the_impact_is_worked_out_ends_that(studio, later):
    """Each press began another drop beside those under way."""
    player = studio.viewer.player
    press(studio, "i")
    assert player.children == (player._progress,)
    press(studio, "i")
    assert (player.impact, player.children, len(later.drops)) == (None, (player._start,), 1)
    press(studio, "i")
    assert (player.children, len(later.drops)) == ((player._progress,), 2)


@pytest.mark.parametrize(("key", "what"), [("r", "run"), (".", "step"), (">", "step_to_simulation"), (" ", "pause")])
def test_a_key_does_what_its_button_does(done, monkeypatch, key, what):
    asked = []
    monkeypatch.setattr(f"mechstyle_widgets.state.controller.Controller.{what}", lambda _controller: asked.append(what))
    opened = Studio(done)
    press(opened, key)
    opened.close()
    assert asked == [what]


def test_with_shift_an_arrow_moves_what_is_looked_at_and_nothing_else(studio):
    before = studio.viewer._orbit.seen
    studio.viewer.key("ArrowRight", shift=True)
    after = studio.viewer._orbit.seen
    moved = np.subtract(after.target, before.target)
    assert moved @ before.axes[0] == pytest.approx(-np.linalg.norm(moved))
    assert np.linalg.norm(moved) > 0.0
    assert (after.azimuth, after.elevation, after.distance) == pytest.approx((before.azimuth, before.elevation, before.distance))


def test_a_view_displayed_by_itself_brings_one_frame_that_hears_its_keys():
    viewer = Viewer(make("pen_holder"))
    for _ in range(2):
        viewer._repr_mimebundle_()
    (frame,) = [child for child in viewer.children if isinstance(child, Frame)]
    frame._handle_custom_msg({"kind": "studio", "key": "o"}, [])
    assert viewer.parallel
    viewer.close()
