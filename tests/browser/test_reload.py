"""A page that is loaded anew while the kernel goes on: it shows what the kernel has, not what it had when the cell was run."""

from __future__ import annotations

import pytest

from support.lanes import lane_on_a_sheet

pytestmark = pytest.mark.browser

TEXT = "document.querySelector('.mechstyle-timeline .js-plotly-plot')?.textContent ?? ''"


@pytest.fixture(scope="module")
def shown(notebook, tmp_path_factory):
    root = lane_on_a_sheet(tmp_path_factory.mktemp("run") / "run", iterations=12).store.root
    return notebook.open(
        """
from mechstyle import Run
from mechstyle_widgets import StudioState
from mechstyle_widgets import Timeline
state = StudioState()
timeline = Timeline(state)
timeline
""",
        f"""
run = Run.open({str(root)!r})
""",
    )


def test_the_timeline_after_a_reload_is_that_of_the_kernel(shown):
    shown.page.wait_for_function(f"({TEXT}).includes('Nothing has run yet')")
    shown.python("state.open(run)")
    shown.page.wait_for_function(f"({TEXT}).includes('VIABLE') && !({TEXT}).includes('Nothing has run yet')")
    shown.page.evaluate("() => window.jupyterapp.commands.execute('docmanager:save')")
    shown.page.reload(wait_until="domcontentloaded")
    shown.page.wait_for_function(f"({TEXT}).includes('VIABLE') && !({TEXT}).includes('Nothing has run yet')")
