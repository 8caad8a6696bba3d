"""The replay in a real notebook: keys move it without the kernel, traits follow both ways, a cell run again leaves nothing behind."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.browser

READY = ".ms-player[data-ready='replay']"
COUNT = "iteration => document.querySelector('.ms-count').textContent.startsWith(iteration + ' / ')"


@pytest.fixture(scope="module")
def shown(notebook, finished_run):
    opened = notebook.open(
        f"""
from mechstyle import Run
from mechstyle_widgets import Replay
replay = Replay(Run.open({str(finished_run.store.root)!r}))
replay
"""
    )
    opened.page.locator(READY).wait_for()
    return opened


def test_keys_scrub_and_the_trait_follows(shown):
    before = shown.pixels(shown.page.locator(".ms-canvas"))
    shown.page.locator(".ms-scrub input").focus()
    for _ in range(12):
        shown.page.keyboard.press("ArrowLeft")
    shown.page.wait_for_function(COUNT, arg=0)
    shown.until("replay.iteration", 0)
    shown.changed(shown.page.locator(".ms-canvas"), before, 0.02)
    shown.keep("replay")


def test_python_sets_what_the_mouse_sets(shown):
    shown.python("replay.iteration = 8")
    shown.page.wait_for_function(COUNT, arg=8)
    shown.python("replay.layer = 'stress'; replay.threshold = 5.0")
    shown.page.get_by_role("radio", name="Stress", checked=True).wait_for()
    shown.page.wait_for_function("document.querySelector('.ms-label').textContent.includes('above 5 MPa')")


def test_a_layer_chosen_in_the_browser_brings_its_threshold(shown):
    shown.page.get_by_role("radio", name="Demand").click()
    shown.until("(replay.layer, replay.threshold)", "('demand', 1.0)")


def test_it_scrubs_while_the_kernel_is_busy(shown):
    """The kernel waits for the browser here, so whatever moves moves without it."""
    shown.page.evaluate(
        "() => { const k = window.jupyterapp.shell.currentWidget.sessionContext.session.kernel;"
        " const code = 'import pathlib\\nwhile not pathlib.Path(\"go\").exists(): pass';"
        " window.asked = k.requestExecute({code, store_history: false}); }"
    )
    shown.page.locator(".ms-scrub input").focus()
    shown.page.keyboard.press("Home")
    for _ in range(5):
        shown.page.keyboard.press("ArrowRight")
    shown.page.wait_for_function(COUNT, arg=5)
    (shown.lab.folder / "go").touch()
    shown.until("replay.iteration", 5)


def test_a_cell_run_again_leaves_one_canvas_and_gives_its_context_back(shown):
    shown.page.evaluate(
        "() => { window.lost = 0;"
        " document.querySelector('.ms-canvas').addEventListener('webglcontextlost', () => window.lost++); }"
    )
    shown.run_all()
    shown.page.wait_for_function("() => window.lost === 1 && document.querySelectorAll('.ms-canvas').length === 1")
    shown.page.locator(READY).wait_for()
