"""What the Studio and the Viewer cost in JupyterLab, in headless Chromium with software WebGL: figures, not a test.

    python benchmarks/lab.py [opening|clicks|viewer|preview|busy|reruns ...]

Says how soon a Studio of nothing shows its comparison, another layer and another iteration of it, and how many clicks lead from there to a
file of one's own; what running the Studio's cell over and over leaves behind in the page and in the kernel, garbage collected before each
reading; how long a new field takes from the kernel to the finished picture of a part of 25k vertices; how soon a Studio shows its style and
another one, and how soon the kernel answers while a run goes on.
Software WebGL draws far slower than any graphics card, and everything here shares the machine's cores: the figures are upper bounds.
"""

from __future__ import annotations

import argparse
import base64
import contextlib
import importlib.util
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from playwright.sync_api import sync_playwright
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
_SPEC = importlib.util.spec_from_file_location("browser", Path(__file__).parents[1] / "tests" / "browser" / "conftest.py")
assert _SPEC is not None
assert _SPEC.loader is not None
browser = importlib.util.module_from_spec(_SPEC)
sys.modules[_SPEC.name] = browser  # dataclasses look their module up
_SPEC.loader.exec_module(browser)
from mechstyle.geometry.files import save  # noqa: E402
from support.knob import knob  # noqa: E402 — of the tests, too

RERUNS, BETWEEN, OPENINGS = 50, 10, 5
UPDATES, STYLES, ANSWERS = 30, ("wood", "knit", "wave", "scales", "bamboo"), 60
OPENED, PREVIEW, LAYER, ANSWER, LEFT, CLICKS = 2000.0, 600.0, 150.0, 200.0, 1.0, 4
"""What is allowed: a Studio with its comparison or a style on its part, another style, another layer or iteration, an answer of the kernel
[ms]; memory of a further run [MB]; clicks to a file of one's own."""
EMPTY = """
from mechstyle.gallery import make
from mechstyle_widgets import Viewer
Viewer(make("pen_holder"))
"""
OPENING = """
from mechstyle_widgets import Studio
studio = Studio()
studio
"""
WITHOUT_PHYSICS = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parents[1] / "tests")!r})
import pytest
from support.sheet_studio import without_physics
without_physics(pytest.MonkeyPatch())
{OPENING}
"""
RUN = "() => { window.jupyterapp.commands.execute('notebook:run-all-cells'); }"
DROP = """([place, name, data]) => {
    const bytes = Uint8Array.from(atob(data), (one) => one.charCodeAt(0)), given = new DataTransfer();
    given.items.add(new File([bytes], name));
    document.querySelector(place).dispatchEvent(new DragEvent('drop', {dataTransfer: given, bubbles: true, cancelable: true}));
}"""
WRITE = "code => window.jupyterapp.shell.currentWidget.content.activeCell.model.sharedModel.setSource(code)"
STUDIO = """
from mechstyle_widgets import Studio
studio = Studio("gallery:pen_holder")
studio
"""
FINE = """
import time
began = time.time()
from mechstyle_widgets import Studio
loaded = time.time()
studio = Studio("gallery:wall_hook", vertices=25_000)
made, arrived = time.time(), []
hang = studio.previewer._arrived
def noted(preview):
    arrived.append(1000.0 * time.time())
    hang(preview)
studio.previewer._arrived = noted
studio
"""
PARTS = "print(1000.0 * (loaded - began), 1000.0 * (made - loaded), arrived[0] - 1000.0 * made, arrived[0])"
"""Of opening a Studio in the kernel: loading, making its controls, drawing the style [ms]; and when that was done, by its clock."""
RUNNING = """
from mechstyle_widgets import Studio
quick = {"vertices": 8000, "orientations": 1, "nearly_flat": False, "window": 0.3, "element": "tet4", "schedule": "every", "every": 10}
studio = Studio("gallery:pen_holder", prompt="brick", iterations=400, folder="busy", **quick)
studio
"""
VIEWER = """
import time
import numpy as np
from mechstyle.gallery import make
from mechstyle_widgets import Layer, Viewer
part = make("pen_holder")
values = np.linspace(0.0, 1.0, len(part.vertices), dtype=np.float32)
viewer = Viewer(part, [Layer("field", values, "field", "", (0.0, 1.0), None, "")])
viewer
"""
UPDATE = """
sent = 1000.0 * time.time()
values = np.roll(values, 500)
viewer.put(Layer("field", values, "field", "", (0.0, 1.0), None, ""))
print(sent)
"""
UNDRAWN = """() => { for (const gl of [WebGLRenderingContext.prototype, WebGL2RenderingContext.prototype])
    for (const name of ['drawElements', 'drawArrays']) gl[name] = () => {}; }"""
"""A graphics card that takes no time."""
Row = tuple[str, str, str]
"""What was measured, the figure, and what is allowed."""
PATIENCE = 300_000  # to the first iteration of a run [ms]
HELD = """
import asyncio, time
held, run = [], asyncio.Handle._run
def timed(handle):
    began = time.thread_time()
    run(handle)
    held.append(1000.0 * (time.thread_time() - began))
asyncio.Handle._run, done = timed, studio.state.iterations_done
"""
"""Notes for how long the kernel's event loop is held, in its own CPU time, whatever else the machine does [ms]."""
LONG = "long = [one for one in held if one > 5.0]; print(max(held), sum(long), studio.state.iterations_done - done)"
WIDGETS = "from ipywidgets.widgets import widget; print(len(widget._instances))"
WATCH = """() => {
    window.drawn = [];
    for (const gl of [WebGLRenderingContext.prototype, WebGL2RenderingContext.prototype])
        for (const name of ['drawElements', 'drawArrays']) {
            const draw = gl[name];
            gl[name] = function (...given) {
                draw.apply(this, given);
                if (given[name === 'drawArrays' ? 2 : 1] < 5000) return; // the shipped comparison's parts have 2760 triangles each
                this.readPixels(0, 0, 1, 1, this.RGBA, this.UNSIGNED_BYTE, new Uint8Array(4)); // waits until it is drawn
                window.drawn.push(performance.timeOrigin + performance.now());
            };
        }
}"""
"""Notes when the part itself has been drawn [ms since 1970, as the kernel counts]."""
QUIET = "() => performance.timeOrigin + performance.now() - (window.drawn.at(-1) ?? 0) > 500"


class Page:
    """A notebook with one cell in a page of its own."""

    def __init__(self, chromium: Any, lab: Any, name: str, cell: str) -> None:
        self.page = chromium.new_context(viewport={"width": 1280, "height": 1200}).new_page()
        self.page.set_default_timeout(browser.PATIENCE)
        self.notebook = browser.Notebook(self.page, lab, name)
        self.devtools = self.page.context.new_cdp_session(self.page)
        self.devtools.send("Network.enable")
        self.notebook.open(cell)
        self.notebook.canvas().wait_for()

    def rerun(self) -> None:
        """Run the cell once more and wait until the new view is there and the old one gone."""
        old = self.page.locator(".mechstyle-viewer").first.element_handle()
        self.notebook.run_all()
        self.page.wait_for_function("old => !old.isConnected && document.querySelector('.mechstyle-viewer canvas')", arg=old)
        assert old is not None
        old.dispose()  # or the page keeps all that was shown for our sake
        self.page.evaluate(browser.SETTLED)

    def heap(self) -> float:
        """JavaScript memory still in use after garbage collections [MB]."""
        for _ in range(3):  # what one finalises, the next collects
            self.devtools.send("HeapProfiler.collectGarbage")
        return self.devtools.send("Runtime.getHeapUsage")["usedSize"] / 1e6


@contextlib.contextmanager
def laboratory() -> Iterator[tuple[Any, Any, Path]]:
    """A browser, a JupyterLab that knows nothing of its user, and the folder of its notebooks."""
    path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if path is None:
        sys.exit("there is no chromium on PATH (Debian: apt-get install chromium)")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        home, notebooks = Path(folder) / "home", Path(folder) / "notebooks"
        home.mkdir()
        notebooks.mkdir()
        chromium = playwright.chromium.launch(executable_path=path, args=browser.ARGUMENTS)
        with browser.jupyter_lab(home, notebooks) as lab:
            yield chromium, lab, notebooks
        chromium.close()


def main() -> None:
    """Measure and print."""
    parts = {
        "opening": (EMPTY, of_opening), "clicks": (WITHOUT_PHYSICS, of_clicks), "viewer": (VIEWER, of_viewer),
        "preview": (FINE, of_preview), "busy": (RUNNING, of_a_run), "reruns": (STUDIO, of_reruns),
    }  # fmt: skip
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    none: list[str] = []  # is a choice, too
    parser.add_argument("parts", nargs="*", choices=[*parts, none], help="what to measure; everything if nothing is named")
    table = Table("what", "measured", "budget")
    with laboratory() as (chromium, lab, _):
        for name in parser.parse_args().parts or parts:
            cell, measured = parts[name]
            shown = Page(chromium, lab, name, cell)
            for row in measured(shown):
                table.add_row(*row)
            shown.page.context.close()
    Console().print(table)


def of_opening(shown: Page) -> Iterator[Row]:
    """From running the first cell of a kernel until both parts of the comparison are drawn, and from an action to its picture."""
    notebook, times = shown.notebook, []
    for _ in range(OPENINGS):
        notebook.open("pass")
        shown.page.evaluate(WRITE, OPENING)
        shown.page.evaluate(WATCH)
        times.append(_until_drawn(shown, lambda: shown.page.evaluate(RUN), views=2))
    yield "Studio(): its cell is run in a new kernel, until the comparison is drawn", best(times), f"{OPENED:g} ms"
    layers, line = shown.page.get_by_label("layer", exact=True).first, shown.page.get_by_role("slider", name="iteration")
    times = [_until_drawn(shown, lambda name=name: layers.select_option(label=name)) for name in OPENINGS * ("style", "stress")]
    yield "Studio(): another layer, from the menu to the picture", best(times), f"{LAYER:g} ms"
    line.focus()
    times = [_until_drawn(shown, lambda: shown.page.keyboard.press("ArrowLeft")) for _ in range(2 * OPENINGS)]
    yield "Studio(): another iteration, from the key to the picture", best(times), f"{LAYER:g} ms"


def _until_drawn(shown: Page, act: Callable[[], object], *, views: int = 1) -> float:
    """From an action until so many views have drawn what came of it [ms]; what came of the one before is drawn by then."""
    shown.page.wait_for_function(QUIET)
    shown.page.evaluate("() => { window.drawn = []; }")
    began = 1000.0 * time.time()
    act()
    shown.page.wait_for_function("views => window.drawn.length >= views", arg=views)
    return shown.page.evaluate("views => window.drawn[views - 1]", views) - began


def of_clicks(shown: Page) -> Iterator[Row]:
    """Clicks from the opening to the file of one's own part, styled and tested; the file is dropped on the view."""
    page, clicks = shown.page, 0
    with tempfile.TemporaryDirectory() as folder:
        made = save(knob(), Path(folder) / "mine.stl").read_bytes()
    for name in ("Make yours", "bamboo", "Run", "3MF"):
        button = page.locator(".mechstyle-studio button").filter(has_text=re.compile(rf"^\s*{name}\s*$")).first  # as it reads
        if name == "bamboo":
            page.evaluate(DROP, [".mechstyle-stage", "mine.stl", base64.b64encode(made).decode()])
            shown.notebook.until("studio.part_picker.name", "mine")
        if name == "3MF":
            shown.notebook.until("studio.state.status", "finished")
            with page.expect_download() as taken:
                button.click()
            assert taken.value.suggested_filename.endswith(".3mf")
        else:
            button.click()
        clicks += 1
    yield "Studio(): clicks to one's own STL styled, tested and taken as 3MF", str(clicks), str(CLICKS)


def of_viewer(shown: Page) -> Iterator[Row]:
    """From setting a field in the kernel until it is drawn."""
    shown.notebook.drawn()
    shown.page.evaluate(WATCH)
    times = [drawn_after(shown, float(shown.notebook.python(UPDATE))) for _ in range(UPDATES)]
    yield "Viewer: a new field, from the kernel to the picture", spread(times), f"{LAYER:g} ms"


def of_preview(shown: Page) -> Iterator[Row]:
    """From running the cell until the style stands on the part, its parts, and from choosing another style, for a run of 25k vertices."""
    there = shown.page.get_by_text("Changes as you choose").first
    there.wait_for()
    loaded, made, drawn, _ = map(float, shown.notebook.python(PARTS).split())
    yield "Kernel: first Studio loaded, made, style drawn", f"{loaded:.0f}, {made:.0f}, {drawn:.0f} ms", ""
    yield from of_reopening(shown, "software WebGL")
    shown.page.evaluate(WATCH)
    times = []
    for count, style in enumerate(STYLES, start=2):
        sent = float(shown.notebook.python(f"print(1000.0 * time.time()); studio.prompt_box.prompt = {style!r}"))
        shown.notebook.until("len(arrived)", count)
        came = float(shown.notebook.python("print(arrived[-1])"))
        times.append(came - sent + drawn_after(shown, came))
    yield "Studio: another style on the part", spread(times), f"{PREVIEW:g} ms"
    shown.page.evaluate(UNDRAWN)
    yield from of_reopening(shown, "nothing rasterised")


def of_reopening(shown: Page, how: str) -> Iterator[Row]:
    """From running a Studio's cell again until the style stands on the part, and what that is made of."""
    times, parts = [], []
    for _ in range(OPENINGS):
        received: list[int] = []
        heard = partial(_count, received)
        shown.devtools.on("Network.webSocketFrameReceived", heard)
        began = time.time()
        shown.rerun()
        shown.page.get_by_text("Changes as you choose").first.wait_for()
        times.append(1000.0 * (time.time() - began))
        shown.devtools.remove_listener("Network.webSocketFrameReceived", heard)
        _, made, drawn, done = map(float, shown.notebook.python(PARTS).split())
        parts.append((made, drawn, 1000.0 * began + times[-1] - done, sum(received) / 1e6))
    yield f"Studio: its cell is run again, until the style is on the part, {how}", spread(times), f"{OPENED:g} ms"
    made, drawn, page, sent = (median(column) for column in zip(*parts, strict=True))
    yield "of it", f"kernel: {made:.0f} ms to make, {drawn:.0f} ms to its style; page: {page:.0f} ms more; {sent:.1f} MB sent", ""


def _count(received: list[int], frame: dict[str, Any]) -> None:
    """Note the bytes of a message from the kernel."""
    data = frame["response"]["payloadData"]
    received.append(len(data) if frame["response"]["opcode"] == 1 else len(data) * 3 // 4)


def of_a_run(shown: Page) -> Iterator[Row]:
    """How soon the kernel answers while a run goes on, its drop tests among it."""
    shown.notebook.python("studio.controller.run()")
    shown.notebook.until("studio.state.iterations_done > 0", True, PATIENCE)
    shown.notebook.python(HELD)
    times = []
    for _ in range(ANSWERS):
        began = time.perf_counter()
        shown.notebook.python("pass")
        times.append(1000.0 * (time.perf_counter() - began))
        shown.page.evaluate(browser.SETTLED)
    longest, long, iterations = map(float, shown.notebook.python(LONG).split())
    done = shown.notebook.python("print(studio.state.status, studio.state.iterations_done)")
    shown.notebook.python("studio.controller.stop()")
    yield f"Studio: an answer of the kernel during a run ({done})", spread(times), f"{ANSWER:g} ms"
    yield "Studio: its event loop is held, CPU", f"{long / max(iterations, 1.0):.0f} ms an iteration, {longest:.0f} ms at a time", ""


def of_reruns(shown: Page) -> Iterator[Row]:
    """What is left in page and kernel after so many runs of the cell."""
    heaps = [shown.heap()]
    yield "Studio: first run of the cell", f"heap {heaps[0]:.0f} MB, {shown.notebook.python(WIDGETS)} widgets", ""
    for number in range(1, RERUNS + 1):
        shown.rerun()
        if number in (1, *range(BETWEEN, RERUNS + 1, BETWEEN)):
            heaps.append(shown.heap())
            yield f"Studio: run {number} more times", f"heap {heaps[-1]:.0f} MB, {shown.notebook.python(WIDGETS)} widgets", ""
    yield "Studio: a further run of the cell", f"{(heaps[-1] - heaps[1]) / (RERUNS - 1):.2f} MB", f"{LEFT:g} MB"


def drawn_after(shown: Page, sent: float) -> float:
    """From a moment of the kernel's clock until the part is drawn next [ms]."""
    shown.page.wait_for_function("sent => window.drawn.some(time => time > sent)", arg=sent)
    return shown.page.evaluate("sent => window.drawn.find(time => time > sent)", sent) - sent


def best(times: list[float]) -> str:
    """The fastest and the median of several: what the machine does besides is in all of them [ms]."""
    return f"best {min(times):.0f} ms, median {median(times):.0f} ms of {len(times)}"


def spread(times: list[float]) -> str:
    """Median and the slowest but one in twenty [ms]."""
    return f"median {median(times):.0f} ms, 95 % within {sorted(times)[int(0.95 * (len(times) - 1))]:.0f} ms"


if __name__ == "__main__":
    main()
