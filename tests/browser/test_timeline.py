"""The timeline as a user meets it: a click or an arrow key shows another iteration, everywhere."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.browser

PLACE = """([row, x, y]) => {
    const plot = document.querySelector('.mechstyle-timeline .js-plotly-plot'), full = plot._fullLayout;
    const xaxis = full.xaxis, yaxis = full[row], box = plot.getBoundingClientRect();
    return [box.x + xaxis._offset + xaxis.d2p(x), box.y + yaxis._offset + yaxis.d2p(y)];
}"""

DRAWN_ANEW = """() => {
    const plot = document.querySelector('.mechstyle-timeline .js-plotly-plot'), paper = () => plot._fullLayout.paper_bgcolor;
    const before = paper();
    plot.on('plotly_afterplot', () => { window.drawnAnew ||= paper() !== before; });
}"""
"""Notes when the chart was drawn with other colours."""


@pytest.fixture(scope="module")
def shown(notebook, finished_run):
    opened = notebook.open(
        f"""
import ipywidgets
from mechstyle import Run
from mechstyle_widgets import RunViewer
from mechstyle_widgets import StudioState
from mechstyle_widgets import Timeline
state = StudioState(Run.open({str(finished_run.store.root)!r}))
viewer, timeline = RunViewer(state, height=300), Timeline(state)
ipywidgets.VBox([viewer, timeline])
"""
    )
    opened.page.wait_for_function("document.querySelector('.mechstyle-timeline .js-plotly-plot')?._fullLayout?.yaxis?._categories?.length")
    opened.drawn()
    return opened


def click(shown, row, x, y):
    """Go there first and away afterwards: the line that says what is under the mouse may move the chart."""
    shown.page.mouse.move(*shown.page.evaluate(PLACE, [row, x, y]))
    shown.pixels(shown.page.locator(".mechstyle-timeline"))
    shown.page.mouse.click(*shown.page.evaluate(PLACE, [row, x, y]))
    shown.page.mouse.move(1.0, 1.0)


def where(shown):
    return "(state.lane, state.iteration, timeline.iteration, viewer.iteration, state.checkpoint.iteration)"


def test_a_click_on_a_simulation_shows_that_iteration(shown):
    shown.keep("timeline")
    before = shown.drawn()
    click(shown, "yaxis", 4, "main")
    shown.until(where(shown), "('main', 4, 4, 4, 4)")
    shown.changed(shown.canvas(), before, 0.003)


def test_hovering_tells_why_it_was_simulated(shown):
    shown.page.mouse.move(*shown.page.evaluate(PLACE, ["yaxis", 8, "main"]))
    told = shown.page.locator(".mechstyle-timeline .mechstyle-hint")
    told.get_by_text("tested after step 8").wait_for()
    assert "MechStyle · iteration 8" in told.text_content()
    shown.keep("timeline-hover")


def test_a_click_on_another_lane_shows_that_lane(shown):
    before = shown.pixels(shown.page.locator(".mechstyle-timeline"))
    click(shown, "yaxis", 9, "frozen")
    shown.until(where(shown), "('frozen', 9, 9, 9, 9)")
    shown.changed(shown.page.locator(".mechstyle-timeline"), before, 0.001)
    shown.keep("timeline-lane")


def test_a_click_counts_though_the_chart_is_drawn_anew_under_it(shown):
    """While a run goes on it is drawn at every iteration, perhaps between press and release; plotly then forgets the press."""
    shown.page.mouse.move(*shown.page.evaluate(PLACE, ["yaxis", 8, "main"]))
    shown.page.locator(".mechstyle-timeline .mechstyle-hint").get_by_text("MechStyle · iteration 8").wait_for()
    shown.page.mouse.down()
    shown.page.evaluate(DRAWN_ANEW)
    shown.python("timeline.theme = 'dark'")
    shown.page.wait_for_function("() => window.drawnAnew")
    shown.page.mouse.up()
    shown.until(where(shown), "('main', 8, 8, 8, 8)")
    shown.python("timeline.theme = 'light'")
    click(shown, "yaxis", 9, "frozen")
    shown.until(where(shown), "('frozen', 9, 9, 9, 9)")


def test_arrow_keys_step(shown):
    shown.page.get_by_role("slider", name="iteration").focus()
    shown.page.keyboard.press("ArrowLeft")
    shown.until(where(shown), "('frozen', 8, 8, 8, 8)")
    shown.page.keyboard.press("ArrowRight")
    shown.until(where(shown), "('frozen', 9, 9, 9, 9)")


def test_it_plays_to_the_end(shown):
    shown.page.keyboard.press("PageDown")
    shown.until(where(shown), "('frozen', 0, 0, 0, 0)")
    shown.page.locator(".mechstyle-timeline .widget-play button").first.click()
    shown.until(where(shown), "('frozen', 12, 12, 12, 12)")


def test_what_python_sets_is_what_the_mouse_sets(shown):
    timeline, before = shown.page.locator(".mechstyle-timeline"), shown.drawn()
    drawn = shown.pixels(timeline)
    shown.python("timeline.iteration = 1")
    shown.until(where(shown), "('frozen', 1, 1, 1, 1)")
    shown.changed(timeline, drawn, 0.001)
    shown.changed(shown.canvas(), before, 0.003)


def test_page_and_kernel_fall_silent_when_nobody_moves_the_line(shown):
    """Line, play button and kernel hold the same iteration: none may answer the others for ever."""
    shown.python("heard = []; timeline._curves.observe(heard.append, 'head'); timeline._play.observe(heard.append, 'value')")
    shown.page.get_by_role("slider", name="iteration").focus()
    for key in ("End", "ArrowLeft", "Home", "ArrowRight", "ArrowRight", "ArrowLeft"):
        shown.page.keyboard.press(key)
    shown.until(where(shown), "('frozen', 1, 1, 1, 1)")  # or a key that comes late is the last to say where it is
    shown.python("timeline.iteration = 3")
    shown.until(where(shown), "('frozen', 3, 3, 3, 3)")
    shown.page.wait_for_timeout(1000)
    before = shown.python("print(len(heard))")
    shown.page.wait_for_timeout(1000)
    assert shown.python("print(len(heard))") == before
    shown.until(where(shown), "('frozen', 3, 3, 3, 3)")
