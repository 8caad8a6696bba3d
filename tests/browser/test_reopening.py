"""A kernel killed in the middle of a run: what was made is shown again, and the run goes on."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.browser

RUN = 300_000  # to the first iterations [ms]
# 2000 iterations took 25 s, and were over before a slow page had pressed Stop
BEGUN = """
from mechstyle_widgets import Studio
quick = {"orientations": 1, "nearly_flat": False, "window": 0.2, "element": "tet4"}
studio = Studio(iterations=100_000, schedule="never", folder="killed", **quick)
studio.controller.run()
studio
"""
AGAIN = """
from mechstyle_widgets import Studio
studio = Studio("killed")
studio
"""
KILL = """() => {
    const kernel = window.jupyterapp.shell.currentWidget.sessionContext.session.kernel;
    kernel.requestExecute({code: 'import os, signal; os.kill(os.getpid(), signal.SIGKILL)', store_history: false});
}"""
BROKEN = """() => [...document.querySelectorAll('.mechstyle-studio .jupyter-widgets-disconnected')]
    .filter(one => getComputedStyle(one, '::before').content !== 'none').length"""
"""Signs of a broken link that are seen."""
RESTARTING = """() => {
    const kernel = window.jupyterapp.shell.currentWidget.sessionContext.session.kernel;
    return ['autorestarting', 'restarting', 'starting', 'dead', 'unknown'].includes(kernel.status);
}"""


def test_a_run_whose_kernel_was_killed_is_opened_again_and_goes_on(notebook):
    notebook.open(BEGUN)
    notebook.until("studio.state.iterations_done >= 5", True, RUN)
    reached = int(notebook.python("print(studio.state.iterations_done)"))
    notebook.page.evaluate(KILL)
    notebook.page.wait_for_function(RESTARTING)
    notebook.page.get_by_text("This is a picture of what was. Run the cell to go on.").wait_for()
    assert notebook.page.evaluate(BROKEN) == 0
    notebook.open(AGAIN)
    notebook.drawn()
    at = int(notebook.python("print(studio.state.iterations_done)"))
    assert reached <= at < 100_000
    assert not notebook.page.get_by_text("Error").is_visible()
    notebook.keep("studio-reopened", notebook.page.locator(".mechstyle-studio"))
    notebook.page.locator(".mechstyle-studio button[title^='Run to the end']").click()
    notebook.until(f"studio.state.iterations_done > {at}", True, RUN)
    notebook.page.locator(".mechstyle-studio button[title^='Stop']").click()
    notebook.until("studio.state.status", "stopped")
