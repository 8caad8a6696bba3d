"""The Studio as a user meets it: a small run, its timeline, its mask, a branch."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from support import ROOT

pytestmark = pytest.mark.browser

RUN = 300_000  # a small run, where others want the cores too [ms]
EVERYWHERE = "(studio.state.iteration, studio._timeline.iteration, studio._viewer.iteration, studio.state.checkpoint.iteration)"
PLACE = """([x, y]) => {
    const plot = document.querySelector('.mechstyle-studio .js-plotly-plot'), full = plot._fullLayout, box = plot.getBoundingClientRect();
    return [box.x + full.xaxis._offset + full.xaxis.d2p(x), box.y + full.yaxis._offset + full.yaxis.d2p(y)];
}"""


@pytest.fixture(scope="module")
def studio(notebook):
    opened = notebook.open(
        f"""
import sys
sys.path.insert(0, {str(ROOT / "tests")!r})
from mechstyle_widgets import Studio
from support.knob import SETTINGS, knob
part = knob()
studio = Studio(part, vertices=len(part.vertices), folder="small", **SETTINGS)
studio
"""
    )
    opened.page.locator(".mechstyle-studio").wait_for()
    return opened


def whole(studio):
    return studio.page.locator(".mechstyle-studio")


def click(studio, x, y):
    whole(studio).locator(".js-plotly-plot").scroll_into_view_if_needed()
    studio.page.mouse.click(*studio.page.evaluate(PLACE, [x, y]))


def test_a_click_paints_and_the_same_click_takes_it_away(studio):
    studio.until("studio._viewer.original is not None", True)  # a preview is on show, with the inside and the underside hatched
    spared = int(studio.python("print(studio._viewer.protected.sum())"))
    assert spared > 0
    studio.python("studio.regions_picker.radius, studio.regions_picker.paint = 12.0, True")
    before = studio.drawn()  # the page has heard of it
    studio.canvas().click()
    studio.until(f"(len(studio.regions_picker.protect), bool(studio._viewer.protected.sum() > {spared}))", "(1, True)")
    studio.changed(studio.canvas(), before, 0.005)
    studio.canvas().click()
    studio.until("(len(studio.regions_picker.protect), int(studio._viewer.protected.sum()))", (0, spared))
    studio.python("studio.regions_picker.paint = False")


def test_it_appears_with_the_part_in_it_and_can_be_turned(studio):
    before = studio.drawn()
    studio.keep("studio-start", whole(studio))
    assert "(0)" not in whole(studio).inner_text(), "of files to upload"
    studio.drag(studio.canvas(), (0.5, 0.5), (0.7, 0.5))
    studio.changed(studio.canvas(), before, 0.005)


def test_a_picture_is_chosen_from_a_file_and_left_again(studio, tmp_path):
    shades = np.add.outer(np.arange(64), np.arange(64)).astype(np.uint8) * 2
    Image.fromarray(np.dstack([shades, 255 - shades, shades])).save(tmp_path / "mine.png")
    with studio.page.expect_file_chooser() as asked:
        whole(studio).locator("button[title^='A PNG or JPEG']").click()
    asked.value.set_files(str(tmp_path / "mine.png"))
    studio.until("(studio.prompt_box.prompt, studio.prompt_box.reading.words)", ("picture", "picture"))
    whole(studio).locator(".widget-image").wait_for()
    studio.keep("studio-picture", whole(studio))
    whole(studio).locator("button[title^='Go on without']").click()
    studio.until("(studio.prompt_box.prompt, studio.prompt_box.image)", ("brick", ""))


def test_a_prompt_that_names_no_style_is_answered_under_its_field_with_styles_to_press(studio):
    field = whole(studio).get_by_label("style", exact=True).first
    field.fill("my own idea")
    answer = whole(studio).get_by_role("alert").filter(has_text="names no style")
    answer.wait_for()
    assert 0 < answer.bounding_box()["y"] - field.bounding_box()["y"] < 60, "right under it"
    studio.until("studio.run_controls._buttons['run'].button_style", "")
    nearest = studio.python("print(studio.prompt_box._chips.few[0].replace('_', ' '))")
    whole(studio).get_by_role("button", name=nearest, exact=True).first.click()
    studio.until("studio.prompt_box.prompt", nearest)
    answer.wait_for(state="detached")


@pytest.mark.parametrize("close", ["Escape", "a click elsewhere", "a choice"])
def test_the_sheet_of_all_styles_is_searched_and_closes(studio, close):
    more, sheet = whole(studio).get_by_role("button", name="all 77 styles"), whole(studio).get_by_role("dialog", name="all 77 styles")
    more.click()
    sheet.wait_for()
    sheet.get_by_label("search styles").fill("scale")
    sheet.get_by_role("button", name="brick", exact=True).wait_for(state="hidden")
    sheet.get_by_role("button", name="fish scales").wait_for()
    studio.keep("studio-sheet", whole(studio))
    if close == "Escape":
        studio.page.keyboard.press("Escape")
    elif close == "a choice":
        sheet.get_by_role("button", name="fish scales").click()
        studio.until("studio.prompt_box.prompt", "fish scales")
    else:
        whole(studio).locator(".mechstyle-result").click()
    sheet.wait_for(state="hidden")
    studio.python("studio.prompt_box.prompt = 'brick'")


def test_a_small_run_completes_while_the_kernel_answers(studio):
    whole(studio).locator("button[title^='Run to the end']").click()
    studio.until("studio.state.status in ('preparing', 'running')", True)
    studio.until("studio.state.status", "finished", RUN)
    studio.until("(studio.state.iterations_done, studio.run.finished)", "(12, True)")
    studio.page.get_by_text("finished, iteration 12 of 12").wait_for()
    studio.drawn()
    studio.keep("studio-finished", whole(studio))


def test_a_click_on_the_timeline_moves_everything(studio):
    before = studio.drawn()
    click(studio, 4, "main")
    studio.until(EVERYWHERE, "(4, 4, 4, 4)")
    studio.changed(studio.canvas(), before, 0.003)
    studio.page.get_by_role("tab", name="Branches").click()
    studio.page.get_by_role("button", name="branch from iteration 4").wait_for()


def test_the_threshold_changes_the_picture_of_the_mask(studio):
    """Stress over yield is some tenths all over this part, so that a threshold of a tenth freezes it."""
    studio.page.get_by_role("tab", name="What if").click()
    studio.python("studio.mask_inspector.selector.normalisation = 'sigma_c'")
    studio.python("studio.mask_inspector.selector._lambda.value = 1.0")
    before = studio.drawn()
    studio.page.get_by_role("button", name="show it").click()
    studio.until("studio.state.layer", "what_if")
    pale = studio.changed(studio.canvas(), before, 0.05)
    slider = whole(studio).locator(".mechstyle-careful .noUi-handle")
    slider.focus()
    was = float(studio.python("print(studio.mask_inspector.selector.threshold)"))
    slider.press("Home")
    studio.until(f"studio.mask_inspector.selector.threshold < {was}", True)
    studio.changed(studio.canvas(), pale, 0.05)
    studio.keep("studio-mask", whole(studio))


def test_using_it_begins_a_branch(studio):
    studio.page.get_by_role("button", name="use this").click()
    studio.until("(len(studio.state.branches), studio.state.status)", "(2, 'finished')", RUN)
    studio.until("(studio.state.lane, studio.state.branches[1].parent, studio.state.branches[1].forked_at)", "('branch-1', 'main', 4)")
    studio.page.wait_for_function("document.querySelector('.mechstyle-studio .js-plotly-plot')._fullLayout.yaxis._categories.length === 2")
    studio.page.get_by_role("tab", name="Branches").click()
    studio.drawn()
    studio.keep("studio-branch", whole(studio))
