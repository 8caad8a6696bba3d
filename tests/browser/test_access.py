"""What a person without a mouse, without full sight or without patience for movement meets: in the Studio, every widget and the report."""

from __future__ import annotations

from importlib.resources import files

import pytest
from axe_playwright_python.sync_playwright import Axe

from mechstyle_widgets.settings.section import table
from support import ROOT

pytestmark = pytest.mark.browser

RUN = f"""
import sys
sys.path.insert(0, {str(ROOT / "tests")!r})
from pathlib import Path
from support.lanes import lane_on_a_sheet
from mechstyle_widgets import *
run = lane_on_a_sheet(Path("access"), iterations=12)
"""
STUDIO = f"""{RUN}
studio = Studio(run)
for group in studio._groups:
    group.page, group.unfolded = False, True  # all in sight at once
studio
"""
ALONE = f"""{RUN}
from mechstyle.gallery import make
from mechstyle_widgets.state.controller import Controller
state = StudioState(run)
controller = Controller(state, lambda: None)
viewer = Viewer(make("pen_holder"))
display(Timeline(state), RunViewer(state), viewer, MaskInspector(controller), RunControls(controller), Branches(controller))
display(PartPicker(), PromptBox(), MaterialPicker(), ControlSelector(), ScheduleSelector(), RegionsPicker(), DropOptions())
"""
THEMES = ("JupyterLab Light", "JupyterLab Dark")
SEEN = {"wide and light": (1400, THEMES[0]), "narrow and dark": (400, THEMES[1])}
"""Widths and themes: barriers of a width are those of its layout, barriers of a theme those of its colours."""
LIT = "document.body.dataset.jpThemeLight === '{}'"
CELLS = "() => window.jupyterapp.shell.currentWidget.content.widgets.length"
MOVING = """() => [...document.querySelectorAll('.mechstyle-studio, .mechstyle-studio *')].filter(one => {
    const style = getComputedStyle(one);
    return parseFloat(style.transitionDuration) > 0 || style.animationName !== 'none';
}).map(one => one.className)"""


SETTLED = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
CUT = """buttons => buttons.filter(button => {
    const [style, text] = [button.style, document.createRange()];
    style.fontWeight = "600";
    text.selectNodeContents(button);
    const [all, room] = [text.getBoundingClientRect(), button.getBoundingClientRect()];
    style.fontWeight = "";
    return all.left < room.left || all.right > room.right || all.bottom > room.bottom;
}).map(button => button.textContent)"""
"""Names of buttons that do not fit into them once they are bold."""
LINES = """cells => cells.map(cell => {
    const text = document.createRange();
    text.selectNodeContents(cell);
    return new Set([...text.getClientRects()].map(line => line.top)).size;
})"""
"""On how many lines the words of each cell stand."""


@pytest.fixture(scope="module")
def shown(notebook):
    notebook.open(STUDIO)
    notebook.drawn()
    return notebook


@pytest.fixture(scope="module")
def alone(notebook):
    notebook.open(ALONE)
    notebook.drawn()
    return notebook


def grave(page, context):
    """What axe finds serious or critical, a line each."""
    found = Axe().run(page, context=context).response["violations"]
    return [f"{one['id']}: {node['html'][:160]}" for one in found if one["impact"] in ("serious", "critical") for node in one["nodes"]]


def looked_through(notebook, width, theme):
    """What axe finds in the outputs of a notebook of a width in a theme."""
    notebook.page.set_viewport_size({"width": width, "height": 1200})
    notebook.page.emulate_media(reduced_motion="reduce")  # a colour on its way to another has no contrast that counts
    notebook.page.evaluate("theme => window.jupyterapp.commands.execute('apputils:change-theme', {theme})", theme)
    notebook.page.wait_for_function(LIT.format(str(theme == THEMES[0]).lower()))
    notebook.drawn()
    found = grave(notebook.page, ".jp-OutputArea")
    notebook.page.emulate_media(reduced_motion="no-preference")
    return found


@pytest.mark.parametrize(("width", "theme"), SEEN.values(), ids=SEEN)
def test_every_widget_by_itself_has_no_serious_barrier(alone, width, theme):
    assert looked_through(alone, width, theme) == []


def test_keys_stay_in_a_widget_that_stands_alone(alone):
    cells, widgets = alone.page.evaluate(CELLS), alone.page.locator(".mechstyle-alone")
    widgets.locator("canvas").nth(1).focus()
    for key in ("o", "b", "d", "d"):
        alone.page.keyboard.press(key)
    alone.until("viewer.parallel", True)
    assert alone.page.evaluate(CELLS) == cells


@pytest.mark.parametrize(("width", "theme"), SEEN.values(), ids=SEEN)
def test_the_studio_has_no_serious_barrier(shown, width, theme):
    assert looked_through(shown, width, theme) == []


@pytest.fixture(scope="module")
def report(finished_run, tmp_path_factory):
    return finished_run.report(tmp_path_factory.mktemp("report") / "report.html")


@pytest.mark.parametrize(("width", "scheme"), [(1400, "light"), (400, "dark")])
def test_the_report_has_no_serious_barrier(chromium, report, width, scheme):
    context = chromium.new_context(
        viewport={"width": width, "height": 900}, offline=True, color_scheme=scheme, bypass_csp=True,
        reduced_motion="reduce",  # a colour on its way to another has no contrast that counts
    )  # fmt: skip
    page = context.new_page()
    page.goto(report.as_uri())
    page.locator("body[data-ready='replay']").wait_for()
    found = grave(page, None)
    context.close()
    assert found == []


def test_the_list_of_keys_opens_and_closes_by_key(shown):
    page, cells = shown.page, shown.page.evaluate(CELLS)
    page.set_viewport_size({"width": 1400, "height": 1200})
    shown.canvas().focus()
    page.keyboard.press("?")
    panel = page.get_by_role("dialog", name="What the keys do")
    panel.wait_for()
    shown.keep("access-keys", page.locator(".mechstyle-studio"))
    for key in ("b", "d", "d"):
        page.keyboard.press(key)
    page.keyboard.press("Escape")
    panel.wait_for(state="detached")
    assert page.evaluate("document.activeElement.tagName") == "CANVAS"
    assert page.evaluate(CELLS) == cells


def test_a_word_explains_itself_to_mouse_and_keyboard(shown):
    setup, tip = shown.page.locator(".mechstyle-setup"), shown.page.locator(".mechstyle-studio > .mechstyle-tip")
    setup.get_by_text("stops at", exact=True).first.hover()
    tip.locator("svg").wait_for()
    assert "Demand at which a place may move no further" in tip.inner_text()
    shown.keep("access-tip", shown.page.locator(".mechstyle-studio"))
    assert grave(shown.page, ".mechstyle-tip") == []
    shown.page.keyboard.press("Escape")
    tip.wait_for(state="hidden")
    setup.get_by_label("holds back").focus()
    tip.get_by_text("How demand slows the style").wait_for()
    assert setup.get_by_label("holds back").get_attribute("aria-describedby") == tip.get_attribute("id")
    shown.canvas().focus()
    tip.wait_for(state="hidden")


def test_keys_do_what_the_list_says(shown):
    page = shown.page
    page.mouse.move(2, 2)  # a tip under it would take the Escape
    shown.canvas().focus()
    page.keyboard.press("w")
    shown.until("studio._tabs.selected_index", 0)
    page.keyboard.press("p")
    shown.until("studio.regions_picker.paint", True)
    page.keyboard.press("Escape")
    shown.until("studio.regions_picker.paint", False)
    shown.python("at = studio._viewer._orbit.seen.target")
    page.keyboard.press("Shift+ArrowRight")
    shown.until("studio._viewer._orbit.seen.target != at", True)
    page.keyboard.press("Home")


LOST = {
    "disabled": ("button[title^='Run to the end']", "studio.state.status = 'running'"),
    "taken away": ("button[title^='Drop this part']", "studio.viewer.player._say(studio.viewer.player._progress)"),
}
"""Controls that go out of reach when they are pressed, and what does so."""


@pytest.mark.parametrize("how", LOST)
def test_keys_go_on_when_what_was_pressed_is_out_of_reach(shown, how):
    """The focus went to the page, where no key of the Studio is heard."""
    pressed, act = LOST[how]
    shown.python("studio.state.status = 'stopped'")
    button, page = shown.page.locator(f".mechstyle-studio {pressed}:enabled"), shown.page
    button.focus()
    shown.python(act)
    button.wait_for(state="detached")
    page.evaluate(SETTLED)
    page.keyboard.press("p")
    shown.until("studio.regions_picker.paint", True)
    page.keyboard.press("Escape")
    shown.until("studio.regions_picker.paint", False)
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "none"
    shown.python("studio.viewer.player.put_away(); studio.state.status = 'finished'")


def test_a_focus_that_left_the_studio_is_not_brought_back(shown):
    shown.python("studio.state.status = 'stopped'")
    button = shown.page.locator(".mechstyle-studio button[title^='Run to the end']:enabled")
    button.focus()
    button.blur()
    shown.page.evaluate(SETTLED)
    shown.python("studio.state.status = 'running'")
    button.wait_for(state="detached")
    shown.page.evaluate(SETTLED)
    assert shown.page.evaluate("document.activeElement.tagName") == "BODY"
    shown.python("studio.state.status = 'finished'")


def test_a_grid_of_pictures_is_one_stop(shown):
    shown.python("studio.prompt_box._chips.all = True")
    shown.page.locator(".mechstyle-sheet button:visible").nth(40).wait_for()
    grids = shown.page.locator(".mechstyle-studio .mechstyle-pictures:visible")
    stops = "grid => [...grid.querySelectorAll('button')].filter(one => !one.hidden && one.tabIndex >= 0).length"
    assert [grid.evaluate(stops) for grid in grids.all()] == [1] * grids.count()
    shown.python("studio.prompt_box._chips.all = False")


def test_every_name_under_a_picture_is_whole_chosen_or_not(shown):
    choices = ("studio.part_picker._gallery", "studio.prompt_box._chips")
    shown.python("; ".join(f"{choice}.all = True" for choice in choices))
    buttons = shown.page.locator(".mechstyle-studio .mechstyle-pictures button:visible")
    buttons.nth(30 + 40).wait_for()
    assert buttons.evaluate_all(CUT) == []
    shown.python("; ".join(f"{choice}.all = False" for choice in choices))


def test_nothing_moves_for_those_who_asked_for_that(shown):
    shown.page.add_style_tag(content=".mechstyle-studio button { transition: color 1s; }")
    assert shown.page.evaluate(MOVING) != []
    shown.page.emulate_media(reduced_motion="reduce")
    assert shown.page.evaluate(MOVING) == []


def test_words_of_a_table_stay_whole_beside_sentences(visitor):
    """What two iterations were compared in stood there one letter a line, beside a sentence that ran out of the panel."""
    page = visitor.new_page()
    sheet = (files("mechstyle_widgets.jupyter") / "static" / "frame.css").read_text(encoding="utf-8")
    rows = [("tested because", "correction: all of the held-back relief put back", "last iteration"), ("flat", "1.08 m", "1.10 m")]
    page.set_content(f'<style>{sheet}</style><div style="width: 300px">{table(("", "cautious · 12", "MechStyle · 12"), rows)}</div>')
    lines = page.locator("td:first-child").evaluate_all(LINES)
    wide = page.locator("table").evaluate("table => table.scrollWidth")
    page.close()
    assert wide <= 300
    assert max(lines) <= 2
