"""The report as its reader meets it: opened from disk with the network off, scrubbed by keyboard and mouse, on a desk and on a phone."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect

from support import ROOT

pytestmark = pytest.mark.browser

SCREENSHOTS = ROOT / "build" / "browser"
PATIENCE = 60_000  # [ms]


@pytest.fixture(scope="module")
def report(finished_run, tmp_path_factory):
    return finished_run.report(tmp_path_factory.mktemp("reports") / "report.html", impact=True)


@pytest.fixture
def opened(chromium, report):
    """Opens the report in a page without a network; what it asks for outside and what goes wrong in it fails the test."""
    contexts, asked, errors = [], [], []

    def open_at(width=1100, scheme="light"):
        context = chromium.new_context(viewport={"width": width, "height": 900}, offline=True, color_scheme=scheme)
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(PATIENCE)
        page.on("request", lambda request: asked.append(request.url))
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
        page.goto(report.as_uri())
        page.locator("body[data-ready='replay']").wait_for()
        return page

    yield open_at
    for context in contexts:
        context.close()
    assert asked == [report.as_uri()] * len(contexts)
    assert errors == []


def pixels(page):
    shot = page.locator("#replay .ms-canvas").screenshot()
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB")).astype(int)


def differing(one, other):
    return float((np.abs(one - other).max(axis=-1) > 12).mean())


def until(page, told):
    """Pixels as soon as they are what is waited for, else the last that were seen; the caller asserts which."""
    for _ in range(100):
        now = pixels(page)
        if told(now):
            break
    return now


def changed(page, before, share):
    """Wait until at least a share of the pixels differs from before; what it looks like then."""
    now = until(page, lambda now: differing(before, now) > share)
    assert differing(before, now) > share
    return now


def at(page, iteration):
    expect(page.locator("#replay .ms-count")).to_have_text(f"{iteration} / 12")


def keep(page, name):
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=SCREENSHOTS / f"{name}.png", full_page=True)


def test_arrow_keys_scrub_through_the_iterations(opened):
    page = opened()
    at(page, 12)
    end = pixels(page)
    assert differing(end, np.broadcast_to(end[2, 2], end.shape)) > 0.1
    page.get_by_label("Iteration", exact=True).focus()
    for _ in range(3):
        page.keyboard.press("ArrowLeft")
    at(page, 9)
    page.keyboard.press("Home")
    at(page, 0)
    changed(page, end, 0.05)


NO_PICTURE_BETWEEN = """() => {
    document.querySelector("#replay .ms-canvas").dispatchEvent(new KeyboardEvent("keydown", { key: "2", bubbles: true }));
    const knob = document.querySelector("#replay input[aria-label='Threshold']");
    knob.value = "5";
    knob.dispatchEvent(new Event("input"));
}"""
"""The layer of stress is chosen and its threshold set at once: no picture is drawn in between."""


def test_layers_are_chosen_by_key_and_by_mouse_and_the_threshold_moves_the_picture(opened):
    page = opened()
    style = pixels(page)
    page.locator("#replay .ms-canvas").focus()
    page.keyboard.press("2")
    page.get_by_role("radio", name="Stress", checked=True).wait_for()
    stress = changed(page, style, 0.1)
    expect(page.locator("#replay .ms-label")).to_contain_text("von Mises stress")
    page.keyboard.press("3")
    expect(page.locator("#replay .ms-label")).to_contain_text("what stays bent [mm]")
    knob = page.locator("#replay").get_by_label("Threshold")
    page.evaluate(NO_PICTURE_BETWEEN)
    expect(page.locator("#replay .ms-label")).to_contain_text("above 5 MPa")
    changed(page, stress, 0.05)
    page.get_by_role("radio", name="Displacement").click()
    expect(page.locator("#replay .ms-label")).to_contain_text("[mm]")
    expect(knob).to_be_hidden()


def test_the_timeline_moves_the_replay_and_the_replay_moves_the_timeline(opened):
    page = opened()
    page.locator(".mark[data-iteration='4']").first.click()
    at(page, 4)
    expect(page.locator("#replay .ms-caption")).to_contain_text("every 4 iterations")
    assert page.locator("tr[data-current]").first.get_attribute("data-iteration") == "4"
    place = page.locator(".cursor").get_attribute("transform")
    page.locator("svg.timeline").focus()
    page.keyboard.press("ArrowRight")
    at(page, 5)
    assert page.locator(".cursor").get_attribute("transform") != place
    page.locator("tr[data-iteration='8']").first.focus()
    page.keyboard.press("Enter")
    at(page, 8)


def test_dragging_turns_the_part_and_keys_do_it_as_well(opened):
    page = opened()
    before, box = pixels(page), page.locator("#replay .ms-canvas").bounding_box()
    page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.4 * box["height"], steps=5)
    page.mouse.up()
    turned = changed(page, before, 0.05)
    page.keyboard.press("+")
    changed(page, turned, 0.03)
    page.keyboard.press("0")
    page.locator("#replay .ms-canvas").evaluate("canvas => canvas.blur()")  # the ring around it is no part of the picture
    page.mouse.move(0, 0)
    again = until(page, lambda now: differing(before, now) < 0.02)
    assert differing(before, again) < 0.02


def test_the_original_stands_beside_it_with_the_same_camera(opened):
    page = opened()
    page.get_by_role("button", name="Beside the original").click()
    page.get_by_text("original", exact=True).first.wait_for()
    both = pixels(page)
    left, right = both[:, : both.shape[1] // 2], both[:, both.shape[1] // 2 :]
    drawn = [np.abs(side - side[2, 2]).max(axis=-1) > 12 for side in (left, right)]
    assert all(side.mean() > 0.1 for side in drawn)
    assert differing(left, right[:, : left.shape[1]]) > 0.05


@pytest.mark.parametrize(("width", "scheme"), [(1100, "light"), (1100, "dark"), (380, "light")])
def test_nothing_runs_over_the_edge_and_it_follows_the_theme(opened, width, scheme):
    page = opened(width, scheme)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    red, _, _ = page.evaluate("getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)")
    assert (red > 128) == (scheme == "light")
    keep(page, f"report-{scheme}-{width}")


def test_print_shows_the_pictures_instead_of_the_replay(opened):
    page = opened()
    assert not page.locator(".still").is_visible()
    page.emulate_media(media="print")
    assert page.locator(".still").is_visible()
    assert not page.locator("#replay").is_visible()


def test_the_impact_opens_at_its_peak_and_plays_to_the_shape_that_stays(opened):
    page = opened()
    impact = page.locator("#impact")
    impact.scroll_into_view_if_needed()
    expect(impact.locator(".ms-caption")).to_contain_text("the moment of the peak")
    slider = impact.get_by_label("Moment", exact=True)
    last = slider.get_attribute("max")

    def seen():
        return np.asarray(Image.open(io.BytesIO(impact.locator(".ms-canvas").screenshot())).convert("RGB")).astype(int)

    at_peak = seen()
    assert differing(at_peak, np.broadcast_to(at_peak[2, 2], at_peak.shape)) > 0.03, "the part is there"
    page.locator("section.played").screenshot(path=SCREENSHOTS / "report-impact.png")
    impact.get_by_role("combobox").select_option("100")
    until(page, lambda _: differing(seen(), at_peak) > 0.01)
    assert differing(seen(), at_peak) > 0.01, "deformed five times as much"
    slider.focus()
    page.keyboard.press("End")
    expect(slider).to_have_value(last)
    expect(impact.locator(".ms-caption")).to_contain_text("mm stays bent")
    impact.get_by_role("button", name="To the peak").click()
    expect(impact.locator(".ms-caption")).to_contain_text("the moment of the peak")
    impact.get_by_role("button", name="Play").click()
    expect(slider).to_have_value(last)
    expect(impact.get_by_role("button", name="Play")).to_be_visible()
