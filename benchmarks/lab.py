"""What the Studio and the Viewer cost in JupyterLab, in headless Chromium with software WebGL: figures, not a test.

    python benchmarks/lab.py

Says what running the Studio's cell over and over leaves behind in the page and in the kernel, garbage collected before each reading;
how long a new field takes from the kernel to the finished picture of a part of 25k vertices; and how many of its iterations a second
a slider passes that is dragged. Software WebGL draws far slower than any
graphics card, and everything here shares the machine's cores: the figures are upper bounds.
"""

from __future__ import annotations

import importlib.util
import shutil
import sys
import tempfile
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

RERUNS, BETWEEN = 50, 10
SIDE, ITERATIONS = 158, 200  # of the sheet that is dragged through: 25k vertices
UPDATES = 30
STUDIO = """
from mechstyle_widgets import Studio
studio = Studio("gallery:pen_holder")
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
SCRUB = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parents[1] / "tests")!r})
from pathlib import Path
from support.lanes import lane_on_a_sheet
from mechstyle_widgets import Studio
studio = Studio(lane_on_a_sheet(Path("scrubbed"), side={SIDE}, iterations={ITERATIONS}))
studio.state.layer = "stress"
studio
"""
PACKED = f"document.querySelector('.mechstyle-scrubber')?.dataset.ready === '{ITERATIONS + 1}'"
DRAG = """async last => {
    const slider = document.querySelector('.mechstyle-scrubber input'), passed = [], messages = [], send = WebSocket.prototype.send;
    document.addEventListener('mechstyle-scrubbed', event => passed.push([performance.now(), event.detail.took]));
    WebSocket.prototype.send = function (data) { messages.push(data); return send.call(this, data); };
    slider.dispatchEvent(new Event('pointerdown'));
    const began = performance.now();
    for (let at = last; at >= 0; at--) {
        slider.value = String(at);
        slider.dispatchEvent(new Event('input'));
        await new Promise(done => requestAnimationFrame(done));
    }
    WebSocket.prototype.send = send;
    slider.dispatchEvent(new Event('pointerup'));
    const middle = values => values.sort((a, b) => a - b)[values.length >> 1];
    const gaps = passed.slice(1).map(([time], k) => time - passed[k][0]);
    return {count: passed.length, messages: messages.length, gap: middle(gaps), work: middle(passed.map(([, took]) => took))};
}"""
UNDRAWN = """() => { for (const gl of [WebGLRenderingContext.prototype, WebGL2RenderingContext.prototype])
    for (const name of ['drawElements', 'drawArrays']) gl[name] = () => {}; }"""
"""A graphics card that takes no time."""
WIDGETS = "from ipywidgets.widgets.widget import _instances; print(len(_instances))"
WATCH = """() => {
    window.drawn = [];
    for (const gl of [WebGLRenderingContext.prototype, WebGL2RenderingContext.prototype])
        for (const name of ['drawElements', 'drawArrays']) {
            const draw = gl[name];
            gl[name] = function (...given) {
                draw.apply(this, given);
                if (given[name === 'drawArrays' ? 2 : 1] < 10000) return;
                this.readPixels(0, 0, 1, 1, this.RGBA, this.UNSIGNED_BYTE, new Uint8Array(4)); // waits until it is drawn
                window.drawn.push(performance.timeOrigin + performance.now());
            };
        }
}"""
"""Notes when the part itself has been drawn [ms since 1970, as the kernel counts]."""


class Page:
    """A notebook with one cell in a page of its own."""

    def __init__(self, chromium: Any, lab: Any, name: str, cell: str) -> None:
        self.page = chromium.new_context(viewport={"width": 1280, "height": 1200}).new_page()
        self.page.set_default_timeout(browser.PATIENCE)
        self.notebook = browser.Notebook(self.page, lab, name)
        self.devtools = self.page.context.new_cdp_session(self.page)
        self.notebook.open(cell)
        self.notebook.canvas().wait_for()

    def rerun(self) -> None:
        """Run the cell once more and wait until the new view is there and the old one gone."""
        old = self.page.locator(".mechstyle-viewer").first.element_handle()
        self.notebook.run_all()
        self.page.wait_for_function("old => !old.isConnected && document.querySelector('.mechstyle-viewer canvas')", arg=old)
        self.page.evaluate(browser.SETTLED)

    def heap(self) -> float:
        """JavaScript memory still in use after garbage collections [MB]."""
        for _ in range(3):  # what one finalises, the next collects
            self.devtools.send("HeapProfiler.collectGarbage")
        return self.devtools.send("Runtime.getHeapUsage")["usedSize"] / 1e6


def main() -> None:
    """Measure and print."""
    path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if path is None:
        sys.exit("there is no chromium on PATH (Debian: apt-get install chromium)")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        home, notebooks = Path(folder) / "home", Path(folder) / "notebooks"
        home.mkdir()
        notebooks.mkdir()
        chromium = playwright.chromium.launch(executable_path=path, args=browser.ARGUMENTS)
        with browser.jupyter_lab(home, notebooks) as lab:
            rows = [*of_scrubbing(Page(chromium, lab, "scrub", SCRUB))]
            rows += [*of_viewer(Page(chromium, lab, "viewer", VIEWER)), *of_studio(Page(chromium, lab, "studio", STUDIO))]
        chromium.close()
    table = Table("what", "measured")
    for row in rows:
        table.add_row(*row)
    Console().print(table)


def of_viewer(shown: Page) -> list[tuple[str, str]]:
    """From setting a field in the kernel until it is drawn."""
    shown.notebook.drawn()
    shown.page.evaluate(WATCH)
    times = []
    for _ in range(UPDATES):
        sent = float(shown.notebook.python(UPDATE))
        shown.page.wait_for_function("sent => window.drawn.some(time => time > sent)", arg=sent)
        times.append(shown.page.evaluate("sent => window.drawn.find(time => time > sent)", sent) - sent)
    shown.page.context.close()
    times.sort()
    return [("Viewer: a new field, from the kernel to the picture", f"median {median(times):.0f} ms, 95 % within {times[-2]:.0f} ms")]


def of_scrubbing(shown: Page) -> list[tuple[str, str]]:
    """How long an iteration takes that a dragged slider passes, with software WebGL and with a graphics card that takes no time."""
    shown.page.wait_for_function(PACKED)
    rows = []
    for how in ("software WebGL", "nothing rasterised"):
        found = shown.page.evaluate(DRAG, ITERATIONS)
        work = f"{found['work']:.1f} ms of it the page's own work (medians)"
        told = f"one each {found['gap']:.0f} ms, {work}; {found['messages']} messages to the kernel"
        rows.append((f"Studio: {found['count']} iterations passed while dragging, {how}", told))
        shown.page.evaluate(UNDRAWN)
    shown.page.context.close()
    return rows


def of_studio(shown: Page) -> list[tuple[str, str]]:
    """What is left in page and kernel after so many runs of the cell."""
    rows = [("Studio: first run of the cell", f"heap {shown.heap():.0f} MB, {shown.notebook.python(WIDGETS)} widgets")]
    for number in range(1, RERUNS + 1):
        shown.rerun()
        if number in (1, *range(BETWEEN, RERUNS + 1, BETWEEN)):
            rows.append((f"Studio: run {number} more times", f"heap {shown.heap():.0f} MB, {shown.notebook.python(WIDGETS)} widgets"))
    return rows


if __name__ == "__main__":
    main()
