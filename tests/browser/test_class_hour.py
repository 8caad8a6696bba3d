"""A short class hour in one Studio: three parts, painted, run, paused, stepped, branched, compared, taken away, reloaded and reopened.

Its runs take no time, for what they come to is the matter of other tests: a part that is run becomes a sheet here.
"""

from __future__ import annotations

import re
import zipfile

import pytest

from mechstyle.gallery import names
from mechstyle.geometry.files import save
from support import ROOT

pytestmark = pytest.mark.browser

WITHOUT_PHYSICS = f"""
import sys
sys.path.insert(0, {str(ROOT / "tests")!r})
import pytest
from support.sheet_studio import without_physics
without_physics(pytest.MonkeyPatch())
from mechstyle_widgets import Studio
"""
CELL = f"""{WITHOUT_PHYSICS}
studio = Studio("gallery:pen_holder", prompt="brick", folder="hour", vertices=900, iterations=8, schedule="every", every=4)
studio
"""
OUTCOME = re.compile("HOLDS|NO WORSE|FAILS")
SETTLING = 20_000  # a width and all that follows it [ms]
CELLS = "() => window.jupyterapp.shell.currentWidget.content.widgets.length"
MARKS = "() => document.querySelectorAll('.mechstyle-studio .js-plotly-plot path.point').length"
TESTED = """() => { const told = document.querySelector('.mechstyle-studio .js-plotly-plot').textContent;
    return /HOLDS|NO WORSE|FAILS/.test(told) && !told.includes('Nothing has run yet'); }"""
"""Whether the timeline shows what was simulated, not the plan."""
UNRULY = """() => {
    const root = document.querySelector('.mechstyle-studio'), edge = root.getBoundingClientRect().right + 1, found = [];
    for (const one of root.querySelectorAll('*')) {
        const box = one.getBoundingClientRect(), mayScroll = /auto|scroll/.test(getComputedStyle(one).overflowY), name = one.className;
        if (box.width && box.right > edge && !one.closest('svg')) found.push(`beyond the edge: ${name}`);
        if (mayScroll && one.scrollHeight > one.clientHeight + 2 && one.tagName !== 'TEXTAREA') found.push(`scrolls: ${name}`);
    }
    return found;
}"""


@pytest.fixture(scope="module")
def hour(notebook):
    opened = notebook.open(CELL)
    studio(opened).wait_for()
    return opened


def studio(hour):
    return hour.page.locator(".mechstyle-studio")


def press(hour, title):
    studio(hour).locator(f"button[title^='{title}']").click()


def choose(hour, words):
    hour.page.get_by_role("button", name=words, exact=True).first.click()


def badge(hour):
    return studio(hour).locator(".mechstyle-badge")


def test_the_style_stands_on_the_part_before_it_is_run(hour):
    hour.drawn()
    badge(hour).get_by_text("NOT TESTED").wait_for()
    brick = hour.drawn()
    choose(hour, "bamboo")
    bamboo = hour.changed(hour.canvas(), brick, 0.05)
    hour.python("studio.prompt_box.prompt = 'small blue stones'")
    hour.changed(hour.canvas(), bamboo)
    assert hour.page.evaluate(MARKS) >= 3, "the marks of the plan stay when settings change"
    hour.python("studio.prompt_box.prompt = 'brick'")


def test_no_key_reaches_the_notebook_and_arrows_turn_the_part(hour):
    cells, before = hour.page.evaluate(CELLS), hour.drawn()
    studio(hour).locator("button[title^='Bring the whole part']").focus()
    for key in ("b", "d", "d", "x", "x", "a", "a"):
        hour.page.keyboard.press(key)
    hour.canvas().focus()
    for key in ("ArrowRight", "ArrowRight", "b"):
        hour.page.keyboard.press(key)
    hour.changed(hour.canvas(), before, 0.02)
    assert hour.page.evaluate(CELLS) == cells
    hour.page.keyboard.press("Home")


def test_what_is_painted_is_kept_plain(hour):
    before = hour.drawn()
    hour.python("studio.regions_picker.radius, studio.regions_picker.paint = 12.0, True")
    hour.canvas().click()
    hour.until("len(studio.regions_picker.protect)", 1)
    hour.changed(hour.canvas(), before, 0.005)
    hour.canvas().click()
    hour.until("len(studio.regions_picker.protect)", 0)
    hour.python("studio.regions_picker.paint = False")


def test_a_run_is_stepped_paused_and_gone_on_with(hour):
    before = hour.drawn()
    press(hour, "One iteration")
    hour.until("studio.state.status", "paused")
    press(hour, "On to the next simulation")
    hour.until("(studio.state.status, studio.state.iteration)", "('paused', 4)")
    hour.changed(hour.canvas(), before, 0.02)
    press(hour, "Run to the end")
    hour.until("(studio.state.status, studio.state.iteration)", "('finished', 8)")
    badge(hour).get_by_text(hour.python("print(studio.state.row().verdict.short)")).wait_for()
    before = hour.drawn()
    badge(hour).get_by_role("button", name="worst place").click()
    hour.changed(hour.canvas(), before, 0.05)
    hour.keep("hour-worst-place", studio(hour))


def test_it_is_branched_and_compared(hour):
    hour.python("studio.state.iteration, studio.state.layer, studio.control_selector.threshold = 4, 'restraint', 0.1")
    hour.page.get_by_role("tab", name="Branches").click()
    hour.page.get_by_role("button", name="compare others with iteration 4").click()
    hour.page.get_by_role("button", name="branch from iteration 4").click()
    hour.until("(studio.state.lane, studio.state.status, studio.state.iteration)", "('branch-1', 'finished', 8)")
    hour.page.locator(".mechstyle-viewer canvas").nth(1).wait_for()
    assert hour.drawn(0).shape == hour.drawn(1).shape
    hour.page.get_by_role("button", name="stop comparing").count()
    hour.python("studio.branches.pinned = None")


def test_freestyle_stands_beside_it_in_one_press(hour):
    hour.python("studio.state.lane = 'main'; studio.control_selector.threshold = studio.run.recipe.restraint.threshold")
    hour.python("studio._take_recipe(studio.run.recipe)")
    press(hour, "MechStyle to the end, then Freestyle")
    hour.until("(studio.state.status, studio.state.lane, studio.state.pinned)", "('finished', 'main', ('freestyle', 8))")
    hour.page.get_by_text("stays bent most").wait_for()
    hour.page.locator(".mechstyle-viewer canvas").nth(1).wait_for()
    assert hour.drawn(0).shape == hour.drawn(1).shape
    hour.drag(hour.canvas(0), (0.5, 0.6), (0.7, 0.6))
    hour.keep("hour-both", studio(hour))
    hour.python("studio.branches.pinned = None")


def test_the_part_is_taken_away(hour, tmp_path):
    with hour.page.expect_download() as saved:
        press(hour, "The part in colour, for the slicer")
    path = tmp_path / saved.value.suggested_filename
    saved.value.save_as(path)
    assert path.name == "pen_holder-8.3mf"
    assert zipfile.is_zipfile(path)


@pytest.mark.parametrize("part", ["wall_hook", "block"])
def test_another_part_in_the_same_studio(hour, cube, part):
    before = hour.drawn()
    hour.python("studio.drop_options.folder = ''")
    if part == "block":  # a file of one's own
        save(cube.moved(3.0 * cube.vertices), hour.lab.folder / "block.stl")
        studio(hour).get_by_placeholder("part.stl").fill("block.stl")
        studio(hour).get_by_placeholder("part.stl").press("Enter")
    else:
        choose(hour, f"all {len(names())} parts")
        choose(hour, "wall hook")
    badge(hour).get_by_text("NOT TESTED").wait_for()
    hour.changed(hour.canvas(), before, 0.05)
    press(hour, "Run to the end")
    hour.until("(studio.state.status, studio.run.record.name, studio._viewer.iteration)", f"('finished', {part!r}, 8)")
    badge(hour).get_by_text(OUTCOME).wait_for()
    hour.drawn()


SAYS = """html => {
    const said = document.createElement('div');
    said.innerHTML = html;
    return document.querySelector('.mechstyle-badge').textContent.includes(said.textContent);
}"""
"""Whether the badge of the page, which hears of the end later than the kernel, has these words."""


def test_after_a_reload_it_is_what_the_kernel_has(hour):
    hour.page.wait_for_function(SAYS, arg=hour.python("print(studio._viewer.badge._words.value.partition('</style>')[2])").strip())
    told, now = badge(hour).inner_text(), hour.python("print(studio.state.lane, studio.state.iteration)")
    hour.page.evaluate("() => window.jupyterapp.commands.execute('docmanager:save')")
    hour.page.reload(wait_until="domcontentloaded")
    badge(hour).get_by_text(OUTCOME).wait_for()
    assert badge(hour).inner_text() == told
    hour.drawn()
    hour.page.wait_for_function(f"({MARKS})() >= 3")
    hour.page.wait_for_function(TESTED)  # what a figure was given before this page heard of it may be lost
    assert hour.python("print(studio.state.lane, studio.state.iteration)") == now


@pytest.mark.parametrize("width", [760, 900, 1280, 1400, 1900, 2500])
def test_it_fits_whatever_width_it_has(hour, width):
    hour.page.set_viewport_size({"width": width, "height": 1200})
    hour.page.wait_for_function("""() => { const view = document.querySelector('.mechstyle-view'), drawn = view.querySelector('canvas');
        return Math.abs(view.clientWidth - drawn.clientWidth) <= 2; }""")
    hour.page.wait_for_function(f"({UNRULY})().length === 0", timeout=SETTLING)
    hour.keep(f"hour-{width}", studio(hour))


def test_a_run_of_that_hour_is_opened_again(hour):
    hour.python("again = Studio('hour').state")
    assert hour.python("print((again.status, again.iteration, len(again.branches)))") == "('finished', 8, 3)"
