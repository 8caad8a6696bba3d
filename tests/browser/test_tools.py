"""The tools of the view as a user meets them in the Studio: by key and by mouse, on every layer, and with nothing over the part."""

from __future__ import annotations

import csv

import pytest

pytestmark = pytest.mark.browser

WITHIN = """() => {
    const edge = document.querySelector('.mechstyle-view').getBoundingClientRect().right + 1;
    return [...document.querySelectorAll('.mechstyle-places button')].every(one => one.getBoundingClientRect().right <= edge);
}"""
"""Whether the list of places ends where the view does."""


@pytest.fixture(scope="module")
def studio(notebook, finished_run):
    opened = notebook.open(f"from mechstyle_widgets import Studio\nstudio = Studio({str(finished_run.store.root)!r})\nstudio")
    opened.page.locator(".mechstyle-studio").wait_for()
    opened.drawn()
    return opened


def press(studio, key):
    """Press a key while the view has the focus."""
    studio.canvas().focus()
    studio.page.keyboard.press(key)


WITHIN = """() => {
    const right = document.querySelector('.mechstyle-viewer canvas').getBoundingClientRect().right;
    const shown = [...document.querySelectorAll('.mechstyle-toolbar button')].filter(one => one.checkVisibility());
    return shown.length > 0 && shown.every(one => one.getBoundingClientRect().right <= right + 1);
}"""
"""Whether all buttons of the toolbar lie within the view."""


@pytest.mark.parametrize("width", [900, 1100, 1400])
def test_the_badge_is_beside_the_part_and_the_toolbar_within_the_view(studio, width):
    studio.page.set_viewport_size({"width": width, "height": 1200})
    studio.drawn()
    studio.page.wait_for_function(WITHIN)  # the kernel gives the view its width when it has heard of the window's
    canvas, badge = studio.canvas().bounding_box(), studio.page.locator(".mechstyle-badge").bounding_box()
    assert badge["y"] + badge["height"] <= canvas["y"]
    for button in studio.page.locator(".mechstyle-toolbar button:visible").all():
        assert button.get_attribute("aria-label") or button.inner_text().strip(), "every button has a name"


@pytest.mark.parametrize(("key", "layer"), [("1", "style"), ("4", "restraint")])
def test_the_part_is_cut_open_on_the_first_layer_and_the_last(studio, key, layer):
    press(studio, key)
    studio.until("studio._viewer.layer", layer)
    whole = studio.drawn()
    press(studio, "x")
    studio.until("studio._viewer.section.on", True)
    cut = studio.changed(studio.canvas(), whole, 0.03)
    press(studio, "PageDown")
    studio.changed(studio.canvas(), cut, 0.003)
    studio.keep(f"tools-cut-{layer}")
    press(studio, "Escape")
    studio.until("studio._viewer.section.on", False)


def test_a_parallel_view_by_key(studio):
    before = studio.drawn()
    press(studio, "o")
    studio.until("studio._viewer.parallel", True)
    studio.changed(studio.canvas(), before, 0.003)
    studio.keep("tools-parallel")
    press(studio, "o")


def test_two_clicks_measure_and_escape_leaves(studio):
    press(studio, "m")
    box = studio.canvas().bounding_box()
    for height in (0.4, 0.6):
        studio.at_rest("studio._viewer")
        studio.page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + height * box["height"])
        studio.until(f"len(studio._viewer.measured) >= {1 if height == 0.4 else 2}", True)
    studio.page.locator(".mechstyle-said", has_text="mm").wait_for()
    studio.keep("tools-measure")
    press(studio, "Escape")
    press(studio, "Escape")
    studio.until("(studio._viewer.tool, studio._viewer.measured)", "('', ())")


def test_places_are_kept_flown_to_saved_and_taken_away(studio):
    press(studio, "a")
    press(studio, "Enter")
    studio.until("len(studio._viewer.places)", 1)
    studio.page.get_by_role("button", name="Look at place 1").click()
    studio.until("studio._viewer.probed == studio._viewer.places[0]", True)
    with studio.page.expect_download() as download:
        studio.page.get_by_text("save CSV").click()
    with download.value.path().open(encoding="utf-8-sig") as saved:
        (row,) = csv.DictReader(saved)
    assert float(row["stress [MPa]"]) > 0.0
    for width in (900, 1400):
        studio.page.set_viewport_size({"width": width, "height": 1200})
        studio.page.wait_for_function(WITHIN)
        studio.keep(f"tools-places-{width}")
    studio.page.get_by_role("button", name="Take place 1 away").click()
    studio.until("studio._viewer.places", "()")
    studio.page.wait_for_function("document.activeElement.title.startsWith('Marks, steps')")  # else keys would go to the notebook


def test_no_key_reaches_the_notebook(studio):
    cells = "document.querySelectorAll('.jp-Notebook .jp-Cell').length"
    before = studio.page.evaluate(cells)
    for key in ("a", "a", "m", "m", "x", "x", "o", "o", "l", "Escape", "PageUp", "b"):
        press(studio, key)
    studio.until("(studio._viewer.tool, studio._viewer.section.on, studio._viewer.parallel)", "('', False, False)")
    assert studio.page.evaluate(cells) == before
