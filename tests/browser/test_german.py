"""A page of a Studio in German: no word of it is English, and the slider under the view moves what is seen."""

from __future__ import annotations

import pytest

from mechstyle.records.landings import STANDARDS
from support.german import english_in

from .conftest import CUT_SHORT, SETTLED, VIEWPORT

pytestmark = pytest.mark.browser

ITERATIONS = 12
WRITTEN = """() => {
    const texts = new Set(), studio = document.querySelector('.mechstyle-studio');
    const walker = document.createTreeWalker(studio, NodeFilter.SHOW_ELEMENT | NodeFilter.SHOW_TEXT);
    for (let node = walker.currentNode; node; node = walker.nextNode()) {
        if (node.nodeType === Node.TEXT_NODE && node.parentElement.localName !== 'style') texts.add(node.data.trim());
        for (const name of ['title', 'aria-label', 'aria-valuetext', 'placeholder', 'alt'])
            texts.add(node.getAttribute?.(name)?.trim() ?? '');
    }
    return [...texts].filter(Boolean);
}"""


AT = """at => {
    const plot = document.querySelector('.mechstyle-timeline .js-plotly-plot'), {xaxis, yaxis} = plot._fullLayout;
    const box = plot.getBoundingClientRect();
    return [box.x + xaxis._offset + xaxis.d2p(at), box.y + yaxis._offset + yaxis._length - 2];
}"""
"""Where an iteration is in the chart, on the line of the lower branch [pixels]."""


@pytest.fixture(scope="module")
def shown(notebook, finished_run):
    opened = notebook.open(
        f"""
from mechstyle_widgets import Studio
studio = Studio({str(finished_run.store.root)!r}, language="de")
studio
"""
    )
    opened.page.wait_for_function("document.querySelector('.mechstyle-timeline .js-plotly-plot')?._fullLayout?.xaxis?._length")
    opened.drawn()
    return opened


def test_the_line_that_is_dragged_moves_the_view_with_it(shown):
    shown.python("studio.state.layer = 'displacement'")
    before, ends = shown.drawn(), [shown.page.evaluate(AT, at) for at in (ITERATIONS, ITERATIONS // 3)]
    shown.page.mouse.move(*ends[0])
    shown.page.mouse.down()
    shown.page.mouse.move(*ends[1], steps=8)
    shown.until("(studio.state.iteration, studio.viewer.up_to_date)", (ITERATIONS // 3, True))
    shown.changed(shown.canvas(), before, 0.003)
    shown.page.mouse.up()
    assert shown.python("print(studio.state.iteration, studio.state.lane)") == f"{ITERATIONS // 3} main", "let go over a mark of another"


def test_a_page_in_german_has_no_word_of_english(shown):
    """What a script of the page said by itself came from no table."""
    shown.python(f"studio.state.iteration = {ITERATIONS}; studio.state.layer = 'stays_bent'")
    shown.drawn()
    shown.page.locator(".mechstyle-studio .js-plotly-plot .main-svg").first.wait_for()
    texts = shown.page.evaluate(WRITTEN)
    assert {"Schritt", "Start", "Ganzes Fenster", "darf abweichen"} <= {*texts}
    assert {text: found for text in texts if (found := english_in(text))} == {}


@pytest.mark.parametrize("language", ["en", "de"])
def test_no_label_and_no_choice_of_the_settings_is_cut_short(notebook, finished_run, language):
    """Of "measured against", and of when is tested, only the beginning was to be read."""
    notebook.open(
        f"""
from mechstyle_widgets import Studio
studio = Studio({str(finished_run.store.root)!r}, language={language!r})
for group in studio._groups:
    group.page, group.unfolded = False, True  # all in sight at once
studio
"""
    )
    notebook.drawn()
    for width in (720, VIEWPORT["width"], 1440):
        notebook.page.set_viewport_size({**VIEWPORT, "width": width})
        notebook.page.evaluate(SETTLED)
        cut = {text.replace("\N{NO-BREAK SPACE}", " ") for text in notebook.page.evaluate(CUT_SHORT)}
        assert cut <= {standard.title for standard in STANDARDS.values()}, "only these stand in full under the choice"
    notebook.page.set_viewport_size(VIEWPORT)
