"""The first minute: a finished comparison is on show, one button leads on, and a file dropped on the view is the part."""

from __future__ import annotations

import base64

import pytest
from playwright.sync_api import expect

from mechstyle.geometry.files import save
from support.knob import knob

from .conftest import SETTLED, VIEWPORT

pytestmark = pytest.mark.browser

DROP = """([place, name, data]) => {
    const bytes = Uint8Array.from(atob(data), (one) => one.charCodeAt(0)), given = new DataTransfer();
    given.items.add(new File([bytes], name));
    for (const kind of ['dragover', 'drop'])
        document.querySelector(place).dispatchEvent(new DragEvent(kind, {dataTransfer: given, bubbles: true, cancelable: true}));
}"""

SEEN = """() => [...document.querySelectorAll('.mechstyle-viewer canvas')].map((one) => one.getBoundingClientRect())
    .reduce((sum, box) => sum + box.width * (Math.min(box.bottom, innerHeight) - box.top), 0) / (innerWidth * innerHeight)"""
"""Share of the window in which parts are seen."""


@pytest.fixture(scope="module")
def opened(notebook):
    notebook.open("from mechstyle_widgets import Studio\nstudio = Studio()\nstudio")
    return notebook


def test_a_finished_comparison_is_on_show_and_nothing_is_computed(opened):
    for pane in range(2):
        opened.drawn(pane)
    words = opened.page.locator(".mechstyle-studio").inner_text()
    for said in ("MechStyle", "HOLDS", "Freestyle", "FAILS", "and cracks"):
        assert said in words
    assert opened.python("print(studio.state.session, studio.previewer.awaited)") == "None False"
    opened.keep("opening")


@pytest.mark.parametrize("width", [720, VIEWPORT["width"], 1440])
def test_what_leads_on_is_seen_without_scrolling(opened, width):
    """In two columns and in one it stood below the part and its curves."""
    opened.page.set_viewport_size({"width": width, "height": 900})
    opened.page.evaluate(SETTLED)
    opened.page.locator(".mechstyle-studio").evaluate("one => one.scrollIntoView()")
    box = opened.page.get_by_role("button", name="Make yours").bounding_box()
    opened.page.set_viewport_size(VIEWPORT)
    assert box["y"] + box["height"] <= 450


def test_no_scale_and_no_word_lies_over_the_part(opened):
    seen, under = (opened.page.locator(place).first.bounding_box() for place in (".mechstyle-seen", ".mechstyle-under"))
    assert under["y"] >= seen["y"] + seen["height"] - 1.0


def test_in_the_full_window_the_comparison_has_most_of_it_and_what_is_next_stands_over_the_result(opened):
    opened.page.set_viewport_size({"width": 1440, "height": 900})
    opened.page.get_by_role("button", name="Full window").first.click()
    opened.page.wait_for_function(f"() => ({SEEN})() >= 0.45")
    opened.keep("opening-full-window")
    boxes = [opened.page.locator(place).first.bounding_box() for place in (".mechstyle-next", ".mechstyle-result")]
    assert boxes[0]["x"] == boxes[1]["x"]
    assert boxes[0]["y"] + boxes[0]["height"] <= boxes[1]["y"]
    opened.page.get_by_role("button", name="Full window").first.click()
    opened.page.set_viewport_size(VIEWPORT)


def test_the_one_filled_button_waits_for_a_style_of_ones_own(opened):
    opened.page.get_by_role("button", name="Make yours").click()
    expect(opened.page.get_by_placeholder("small blue stones")).to_be_focused()
    expect(opened.page.get_by_placeholder("small blue stones")).to_have_value("")
    expect(opened.page.locator(".mechstyle-studio").get_by_role("alert")).to_have_count(0)


def test_three_figures_stand_in_a_row(opened):
    tops = opened.page.locator(".mechstyle-figures > div").evaluate_all("all => all.map(one => one.getBoundingClientRect().top)")
    assert len(tops) == 3
    assert len(set(tops)) == 1


def test_a_file_dropped_on_the_view_is_the_part(opened, tmp_path):
    save(knob(), tmp_path / "mine.stl")
    data = base64.b64encode((tmp_path / "mine.stl").read_bytes()).decode()
    opened.page.evaluate(DROP, [".mechstyle-stage", "mine.stl", data])
    opened.until("studio.part_picker.name", "mine")
    opened.drawn()
