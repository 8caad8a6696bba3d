"""A page that is loaded anew while the kernel goes on: it shows what the kernel has, not what it had when the cell was run."""

from __future__ import annotations

import pytest

from support.lanes import lane_on_a_sheet

pytestmark = pytest.mark.browser

PREVIEWED = "Changes as you choose"


STALE_LIST = """
import asyncio
from ipywidgets import Widget
from mechstyle_widgets.viewer.viewer import STALE
answered, loop = Widget._handle_control_comm_msg.__func__, asyncio.get_running_loop()
class Late:
    def send(self, *states, **buffers):
        async def after_a_choice():
            {choice}
            while STALE in studio._viewer._dom_classes:
                await asyncio.sleep(0.05)
            page.send(*states, **buffers)
        page, Widget._control_comm = Widget._control_comm.page, None
        asyncio.run_coroutine_threadsafe(after_a_choice(), loop)
    def __init__(self, page):
        self.page = page
def answered_late(cls, message):
    cls._control_comm = Late(cls._control_comm)
    answered(cls, message)
Widget._handle_control_comm_msg = classmethod(answered_late)
"""
"""What was chosen and drawn while a page was told of all models as they were before: it has none of them yet, and hears nothing of it."""


LATE = """() => {
    const wait = window.setTimeout;
    window.setTimeout = (act, time, ...given) => wait(act, time === 100 ? 6000 : time, ...given);
}"""
"""A page so busy that JupyterLab, which looks for a model each 100 ms, for two seconds, looks once and again when the time is over."""


DEAF = """() => {
    const timeout = AbortSignal.timeout.bind(AbortSignal);
    AbortSignal.timeout = (time) => {
        if (time !== 2000) return timeout(time);
        return { addEventListener: (_, act) => act(), aborted: true };
    };
}"""
"""A page so busy that no script of a widget comes within anywidget's two seconds."""


SLOWLY = """
import time
from mechstyle_widgets.state import preview
drawn = preview.finished_style
preview.finished_style = lambda *given: time.sleep(2.0) or drawn(*given)
studio.prompt_box.prompt = 'knit'
"""
"""A style that takes longer to draw than a page to go."""


@pytest.fixture(scope="module")
def both(notebook):
    """Two views of one Studio, on show and saved."""
    notebook.open("from mechstyle_widgets import Studio\nstudio = Studio(prompt='brick')\nstudio", "studio")
    notebook.drawn(1)
    # The list is answered while a preview is drawn (tests/widgets/jupyter/test_one_thread.py), which may close what it names.
    notebook.page.get_by_text(PREVIEWED).first.wait_for()
    notebook.page.evaluate("() => window.jupyterapp.commands.execute('docmanager:save')")
    return notebook


def test_a_page_that_is_loaded_anew_while_a_style_is_drawn_shows_that_style(both):
    both.python(SLOWLY)
    both.page.reload(wait_until="domcontentloaded")
    studio = both.page.locator(".mechstyle-studio").first
    studio.locator("[aria-pressed=true]", has_text="knit").first.wait_for()
    studio.get_by_text(PREVIEWED).first.wait_for()
    both.drawn(0)
    assert both.page.get_by_text("Error displaying widget").count() == 0
    both.python("preview.finished_style = drawn")


@pytest.mark.parametrize(
    ("choice", "chosen"), [("studio.prompt_box.prompt = 'wood'", "wood"), ("studio.part_picker.choose('gallery:pen_holder')", "pen holder")]
)
def test_what_is_said_while_a_page_makes_its_models_is_shown_once_it_has(both, choice, chosen):
    both.python(STALE_LIST.format(choice=choice))
    both.page.reload(wait_until="domcontentloaded")
    studio = both.page.locator(".mechstyle-studio").first
    studio.locator("[aria-pressed=true]", has_text=chosen).first.wait_for()
    studio.get_by_text(PREVIEWED).first.wait_for()
    both.drawn(0)
    assert both.page.get_by_text("Error displaying widget").count() == 0
    both.python("Widget._handle_control_comm_msg = classmethod(answered)")


def test_two_views_of_one_studio_are_there_again_after_a_reload_of_a_busy_page(both):
    both.page.evaluate("() => window.jupyterapp.commands.execute('docmanager:save')")
    for busy in (LATE, DEAF):
        both.page.add_init_script(f"({busy})()")
    both.page.reload(wait_until="domcontentloaded")
    for number in range(2):
        both.page.locator(".mechstyle-studio").nth(number).locator(".js-plotly-plot .main-svg").first.wait_for()
        both.drawn(number)
    both.python("studio.prompt_box.prompt = 'wood'")
    for number in range(2):
        both.page.locator(".mechstyle-studio").nth(number).locator("[aria-pressed=true]", has_text="wood").first.wait_for()
    assert both.page.get_by_text("Error displaying widget").count() == 0


OUTPUTS = """() => [...document.querySelectorAll('.jp-OutputArea-child')].map(one => [
    one.querySelector('img')?.naturalWidth ?? 0, one.offsetHeight, one.querySelector('.mechstyle-studio') !== null])"""
"""Of every output: how wide its picture is, how high it is shown, and whether it holds a Studio."""


def test_a_notebook_that_is_opened_without_its_kernel_shows_a_picture(notebook, tmp_path_factory):
    """It said "model not found", trusted as it was."""
    root = lane_on_a_sheet(tmp_path_factory.mktemp("run") / "run", iterations=12).store.root
    notebook.open(
        f"""
import logging
from mechstyle_widgets import Studio
logged, told = [], logging.Handler()
told.emit = lambda record: logged.append(record.getMessage())
logging.getLogger("Comm").addHandler(told)
studio = Studio({str(root)!r})
studio
"""
    )
    notebook.drawn()
    notebook.page.wait_for_function(f"(({OUTPUTS})().at(-1)[0]) > 100")
    (_, high, alive), (_, hidden, _) = notebook.page.evaluate(OUTPUTS)
    assert (alive, hidden) == (True, 0)
    assert high > 300
    assert notebook.python("print(logged)") == "[]", "JupyterLab shows a red number for these"
    notebook.page.evaluate("() => window.jupyterapp.commands.execute('docmanager:save')")
    notebook.page.evaluate("() => window.jupyterapp.shell.currentWidget.sessionContext.shutdown()")
    notebook.page.reload(wait_until="domcontentloaded")
    notebook.page.wait_for_function(f"(({OUTPUTS})().at(-1) ?? [0, 0])[1] > 300")
    assert [alive for *_, alive in notebook.page.evaluate(OUTPUTS)] == [False, False]
