"""The slider of a Studio is dragged: the page draws what it passes without a word to the kernel, which is asked where it rests."""

from __future__ import annotations

import pytest

from support.german import english_in

pytestmark = pytest.mark.browser

ITERATIONS = 12
SLIDER = ".mechstyle-scrubber input"
PACKED = f"document.querySelector('.mechstyle-scrubber')?.dataset.ready === '{ITERATIONS + 1}'"
LISTEN = """() => {
    window.said = [];
    const send = WebSocket.prototype.send;
    WebSocket.prototype.send = function (data) {
        const text = typeof data === 'string' ? data : new TextDecoder().decode(data);
        if (text.includes('comm_msg')) window.said.push(text);
        return send.call(this, data);
    };
    document.addEventListener('mechstyle-scrubbed', event => (window.passed ??= []).push(event.detail.iteration));
}"""
SAID = "() => window.said.length"
DRAWN = "what => document.querySelector('.mechstyle-scrubber').dataset.drawn === what"
SCRUBBED = "at => window.passed?.at(-1) === at"


@pytest.fixture(scope="module")
def shown(notebook, finished_run):
    opened = notebook.open(
        f"""
from mechstyle_widgets import Studio
studio = Studio({str(finished_run.store.root)!r}, language="de")
studio
"""
    )
    opened.page.locator(SLIDER).wait_for()
    opened.drawn()
    opened.page.wait_for_function(PACKED)
    opened.page.evaluate(LISTEN)
    opened.page.add_style_tag(content=":is(.mechstyle-badge, .mechstyle-legend) { visibility: hidden; }")  # of what the kernel shows
    return opened


def x_of(shown, iteration):
    """Where the handle stands for an iteration, in a slider whose handle is 16 pixels wide."""
    box = shown.page.locator(SLIDER).bounding_box()
    return box["x"] + 8 + (box["width"] - 16) * iteration / ITERATIONS, box["y"] + box["height"] / 2


def drag(shown, *iterations):
    """Press on the first, move over the others, and stay on the last, pressed."""
    shown.page.locator(SLIDER).scroll_into_view_if_needed()
    shown.page.mouse.move(*x_of(shown, iterations[0]))
    shown.page.mouse.down()
    for iteration in iterations[1:]:
        shown.page.mouse.move(*x_of(shown, iteration), steps=6)
    shown.page.wait_for_function(SCRUBBED, arg=iterations[-1])


def kernel_draws(shown, layer, iteration, *, markers=False):
    """Let the kernel draw an iteration; what it looks like."""
    shown.python(f"studio.state.layer, studio.state.iteration, studio._viewer.markers = {layer!r}, {iteration}, {markers}")
    shown.page.wait_for_function(DRAWN, arg=f"{layer} {iteration}")
    shown.drawn()
    return shown.pixels(shown.canvas())


@pytest.mark.parametrize("layer", ["style", "stress", "displacement"])
def test_what_is_passed_is_drawn_without_the_kernel_and_as_the_kernel_draws_it(shown, layer):
    by_kernel = kernel_draws(shown, layer, 4)
    last = kernel_draws(shown, layer, 12)
    before = shown.page.evaluate(SAID)
    drag(shown, 12, 8, 1, 4)
    by_page = shown.pixels(shown.canvas())
    assert shown.page.evaluate(SAID) == before, "the kernel hears nothing while it is dragged"
    assert shown.python("print(studio.state.iteration)") == "12"
    alike = shown.difference(by_page, by_kernel)
    # The page draws in the scale of what the kernel shows, whose end moves with the stress that decides: by a thousandth from 4 to 12.
    share, most = (0.7, 0.005) if layer == "stress" else (0.3, 0.001)
    assert alike < share * shown.difference(by_kernel, last), "stress is cut off at what is judged: few pixels differ at all"
    assert alike < most
    shown.page.mouse.up()
    shown.page.wait_for_function(DRAWN, arg=f"{layer} 4")
    shown.page.wait_for_function("!document.querySelector('.mechstyle-passing')")
    assert shown.difference(shown.pixels(shown.canvas()), by_kernel) < most


def test_back_where_it_was_the_kernel_has_nothing_to_draw_and_the_picture_is_its_own(shown):
    before = kernel_draws(shown, "stress", 12, markers=True)
    said = shown.page.evaluate(SAID)
    drag(shown, 12, 3, 12)
    shown.page.mouse.up()
    shown.page.wait_for_function("!document.querySelector('.mechstyle-passing')")
    assert shown.page.evaluate(SAID) == said
    assert shown.difference(shown.pixels(shown.canvas()), before) == 0.0


def test_keys_step_and_the_kernel_follows_when_they_rest(shown):
    shown.page.locator(SLIDER).focus()
    shown.page.keyboard.press("Home")
    shown.until("(studio.state.iteration, studio._viewer.page['drawn'])", "(0, 0)")
    for _ in range(3):
        shown.page.keyboard.press("ArrowRight")
    shown.until("(studio.state.iteration, studio._viewer.page['drawn'])", "(3, 3)")


def test_it_plays_to_the_end_and_tells_the_kernel_then(shown):
    shown.page.evaluate("() => { window.said = []; window.passed = []; }")
    shown.page.get_by_role("button", name="Abspielen").click()
    shown.until("studio.state.iteration", ITERATIONS)
    assert shown.page.evaluate("() => new Set(window.passed).size") > 1
    assert shown.page.evaluate("""() => window.said.filter(text => text.includes('"state":{"value"')).length""") == 1


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


def test_a_page_in_german_has_no_word_of_english(shown):
    """The slider said "12 of 12" and "iteration": what a script of the page says came from no table."""
    kernel_draws(shown, "style", ITERATIONS)
    shown.page.locator(".mechstyle-studio .js-plotly-plot .main-svg").first.wait_for()
    texts = shown.page.evaluate(WRITTEN)
    assert any(text.startswith("Schritt 12 von 12, ") for text in texts), "what is heard of the slider tells its verdict"
    assert {"Schritt", "12 von 12", "Abspielen", "Start", "Ganzer Bildschirm"} <= {*texts}
    assert {text: found for text in texts if (found := english_in(text))} == {}
