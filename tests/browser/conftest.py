"""A real JupyterLab in a real browser without a screen: started once, on a free port, with folders of its own and no way out.

A test opens a notebook, runs its cells, drags and clicks, and looks at pixels and at traits in the kernel. Nothing sleeps:
what is expected is waited for. Every page that asks for anything outside, or that raises an error, fails its test.
"""

from __future__ import annotations

import asyncio
import contextlib
import io
import os
import re
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import nbformat
import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, BrowserContext, Error, Locator, Page, sync_playwright

from mechstyle.gallery import names
from mechstyle.runs.run import Run, stylize
from mechstyle.styling import library
from mechstyle_widgets.settings import thumbnails
from support import ROOT
from support.forked_kernels import kernel_server
from support.knob import SETTINGS, knob

SCREENSHOTS = ROOT / "build" / "browser"
START = 120  # JupyterLab on two busy cores [s]
PATIENCE = 180_000  # for anything a page is waited for [ms]; only what fails, or a machine that does much else, waits so long
VIEWPORT = {"width": 1280, "height": 1200}
ARGUMENTS = [  # WebGL without a graphics card, and a browser that keeps to itself
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",  # or whole pages are painted through the software GPU, for four times the work of a Studio
    "--disable-gpu-rasterization",
    "--disable-background-networking",
    "--disable-component-update",
]
LAB_IS_IDLE = """() => {
    const session = window.jupyterapp?.shell?.currentWidget?.sessionContext;
    return session?.session?.kernel?.status === 'idle';
}"""
SHUT_DOWN = """async () => {
    try { await window.jupyterapp?.shell?.currentWidget?.sessionContext?.shutdown(); } catch { /* it was killed, and is being started */ }
}"""
EXECUTE = """async code => {
    const kernel = window.jupyterapp.shell.currentWidget.sessionContext.session.kernel;
    const future = kernel.requestExecute({code, store_history: false});
    let out = '';
    future.onIOPub = message => {
        const kind = message.header.msg_type, content = message.content;
        if (kind === 'stream') out += content.text;
        if (kind === 'error') out += content.ename + ': ' + content.evalue;
    };
    await future.done;
    return out.trim();
}"""
UNTIL = """async (execute, code, wanted, patience) => {
    const end = performance.now() + patience;
    for (;;) {
        const said = await execute(code);
        if (said === wanted || performance.now() > end) return said;
        await new Promise(done => setTimeout(done, 50));
    }
}"""
OURS = re.compile("THREE|anywidget|mechstyle", re.IGNORECASE)
"""What an error in a page's console names if it comes from a widget."""
NOT_OURS = ("[anywidget] Failed to initialize model.", "Canceled future for ")
"""What anywidget says of a script that comes after its two seconds, though ours hear nevertheless (`test_reload`), and JupyterLab of what
it had asked a kernel that was killed (`test_reopening`)."""
CUT_SHORT = """() => {
    const pen = document.createElement('canvas').getContext('2d'), found = [];
    const seen = place => [...document.querySelectorAll(`.mechstyle-setup ${place}`)].filter(one => one.checkVisibility());
    for (const one of seen('select:not([size])')) {
        const { font, paddingLeft, paddingRight } = getComputedStyle(one), before = one.value;
        pen.font = font;
        for (const { value, text } of one.options) {
            one.value = value; // it is as wide as what is chosen needs
            if (pen.measureText(text).width > one.clientWidth - parseFloat(paddingLeft) - parseFloat(paddingRight)) found.push(text);
        }
        one.value = before;
    }
    const cut = one => {
        const text = document.createRange(), room = one.getBoundingClientRect();
        text.selectNodeContents(one);
        return [...text.getClientRects()].some(line => line.left < room.left - 1 || line.right > room.right + 1);
    };
    return [...found, ...seen(':not(.mechstyle-unseen) > .widget-label').filter(cut).map(one => one.textContent)];
}"""
"""Labels and choices among the settings of a Studio of which an end is not to be seen."""
SETTLED = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"


@dataclass(frozen=True)
class Lab:
    """A running JupyterLab: where it listens, its token and the folder its notebooks lie in."""

    address: str
    token: str
    folder: Path


@dataclass
class Notebook:
    """A notebook open in a browser."""

    page: Page
    lab: Lab
    name: str
    asked_outside: list[str] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)

    def open(self, *cells: str) -> Notebook:
        """Write the cells into a notebook, open it with a kernel of its own, whose widgets are these alone, and run them all."""
        self.page.evaluate(SHUT_DOWN)
        notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
        notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3", "language": "python"}
        nbformat.write(notebook, self.lab.folder / f"{self.name}.ipynb")
        self.page.goto(f"{self.lab.address}lab/tree/{self.name}.ipynb?token={self.lab.token}&reset", wait_until="domcontentloaded")
        self.page.wait_for_function(LAB_IS_IDLE)
        self.page.evaluate("() => window.jupyterapp.commands.execute('application:toggle-left-area')")
        self.run_all()
        return self

    def run_all(self) -> None:
        """Run all cells and wait until they are done."""
        self.page.evaluate("() => window.jupyterapp.commands.execute('notebook:run-all-cells')")
        self.page.wait_for_function(LAB_IS_IDLE)
        said = self.page.locator('[data-mime-type="application/vnd.jupyter.stderr"], [data-mime-type="application/vnd.jupyter.error"]')
        assert said.count() == 0, said.first.inner_text()

    def python(self, code: str) -> str:
        """Run code in the kernel, outside any cell; what it printed."""
        return self.page.evaluate(EXECUTE, code)

    def until(self, expression: str, expected: object, patience: int = PATIENCE) -> None:
        """Wait until an expression in the kernel prints as expected, at most `patience` [ms]."""
        asked = [f"print({expression})", str(expected), patience]
        said = self.page.evaluate(f"([code, wanted, patience]) => ({UNTIL})({EXECUTE}, code, wanted, patience)", asked)
        assert said == str(expected), f"{expression} is {said}, not {expected}"

    def canvas(self, number: int = 0) -> Locator:
        """A view in three dimensions."""
        return self.page.locator(".mechstyle-viewer canvas").nth(number)

    def pixels(self, what: Locator) -> np.ndarray:
        """What a part of the page looks like, shape [height, width, 3], uint8; where it is made anew meanwhile, the new one."""
        while True:
            self.page.evaluate(SETTLED)
            try:
                return np.asarray(Image.open(io.BytesIO(what.screenshot(animations="disabled"))).convert("RGB"))
            except Error as error:
                if "not attached to the DOM" not in error.message:
                    raise

    def difference(self, one: np.ndarray, other: np.ndarray) -> float:
        """Share of the pixels of two pictures that differ visibly."""
        return difference(one, other)

    def changed(self, what: Locator, before: np.ndarray, share: float = 0.01) -> np.ndarray:
        """Wait until at least a share of the pixels differs from before; what it looks like then."""
        for _ in range(300):
            now = self.pixels(what)
            if now.shape != before.shape or difference(now, before) >= share:
                return now
        pytest.fail(f"the picture stays as it was: {difference(now, before):.2%} of its pixels differ")

    def at_rest(self, viewer: str) -> None:
        """Wait until neither page nor kernel move a viewer's camera: a click right after that would be the end of a drag."""
        before = self.pixels(self.canvas())
        for _ in range(300):
            now = self.pixels(self.canvas())
            if np.array_equal(now, before):
                break
            before = now
        self.until(f"__import__('time').monotonic() - {viewer}._picker._moved > 0.3", True)

    def drawn(self, number: int = 0) -> np.ndarray:
        """Wait until a view shows more than a background; its pixels."""
        self.canvas(number).wait_for()
        for _ in range(300):
            now = self.pixels(self.canvas(number))
            if difference(now, np.broadcast_to(now[2, 2], now.shape)) > 0.05:
                return now
        pytest.fail("the view stays empty")

    def drag(self, what: Locator, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag the mouse between two places, each a share of the width and height."""
        box = what.bounding_box()
        points = [(box["x"] + x * box["width"], box["y"] + y * box["height"]) for x, y in (start, end)]
        self.page.mouse.move(*points[0])
        self.page.mouse.down()
        self.page.mouse.move(*points[1], steps=8)
        self.page.mouse.up()

    def keep(self, name: str, what: Locator | None = None) -> None:
        """Keep a screenshot for people to look at."""
        SCREENSHOTS.mkdir(parents=True, exist_ok=True)
        (what or self.page).screenshot(path=SCREENSHOTS / f"{name}.png")


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """Share of the pixels that differ visibly."""
    return float((np.abs(one.astype(int) - other.astype(int)).max(axis=-1) > 12).mean())


@pytest.fixture(scope="session")
def chromium_path() -> str:
    """Where this machine's browser is; without one these tests are skipped, unless nothing may be."""
    path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if path is None:
        say = pytest.fail if os.environ.get("MECHSTYLE_SKIP_NOTHING") == "1" else pytest.skip
        say("THE WIDGETS ARE NOT TESTED IN A BROWSER: there is no chromium on PATH (Debian: apt-get install chromium)")
    return path


@pytest.fixture(scope="package")
def chromium(chromium_path: str, request: pytest.FixtureRequest) -> Iterator[Browser]:
    """One browser for all tests of this folder.

    Playwright keeps an event loop running in the thread of the tests for as long as it is open. Tests of other folders may need a thread
    without one, so it never outlives these.
    """
    assert isinstance(request.node, pytest.Package), "without tests/browser/__init__.py it would end with the session"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium_path, args=ARGUMENTS)
        yield browser
        browser.close()
    with pytest.raises(RuntimeError, match="no running event loop"):
        asyncio.get_running_loop()


@pytest.fixture(scope="package")
def visitor(chromium: Browser) -> Iterator[BrowserContext]:
    """One visitor of the lab, whose browser keeps JupyterLab's scripts from one notebook to the next."""
    context = chromium.new_context(viewport=VIEWPORT)
    yield context
    context.close()


@pytest.fixture(scope="session")
def thumbnails_drawn(cache: Path) -> None:
    """A hundred pictures of models and styles in the cache, all grey: drawing them takes a core a minute beside what is tested."""
    held = io.BytesIO()
    Image.new("RGB", thumbnails.SIZE, (180, 180, 180)).save(held, "PNG")
    with pytest.MonkeyPatch.context() as patch:
        for kind, known in (("model", names()), ("style", library.names())):
            patch.setitem(thumbnails.DRAWN, kind, lambda _name: held.getvalue())
            for name in known:
                thumbnails.draw(kind, name)
    assert any(cache.rglob("*.png"))


@pytest.fixture(scope="session")
def lab(chromium_path: str, tmp_path_factory: pytest.TempPathFactory, thumbnails_drawn: None) -> Iterator[Lab]:
    """A JupyterLab that knows nothing of its user."""
    with jupyter_lab(tmp_path_factory.mktemp("home"), tmp_path_factory.mktemp("notebooks")) as started:
        yield started


@contextlib.contextmanager
def jupyter_lab(home: Path, folder: Path) -> Iterator[Lab]:
    """A JupyterLab that keeps all it has in one folder, and its notebooks in another."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    token = secrets.token_hex(12)
    settings = home / "jupyterlab_settings_dir" / "@jupyterlab" / "apputils-extension" / "notification.jupyterlab-settings"
    settings.parent.mkdir(parents=True)
    settings.write_text('{"fetchNews": "false", "checkForUpdates": false}')
    command = [sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root", f"--port={port}", "--ServerApp.port_retries=0"]
    command += ["--ServerApp.ip=127.0.0.1", f"--IdentityProvider.token={token}", f"--ServerApp.root_dir={folder}"]
    command += ["--LabApp.expose_app_in_browser=True"]
    lab, own = Lab(f"http://127.0.0.1:{port}/", token, folder), private(home)
    with kernel_server(home, own) as forked, (home / "log").open("w") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log, env={**own, **forked}, start_new_session=True)
        try:
            wait_for(lab, process, home / "log")
            yield lab
        finally:
            os.killpg(process.pid, signal.SIGTERM)
            try:
                process.wait(15)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()


def private(home: Path) -> dict[str, str]:
    """An environment in which Jupyter finds and leaves nothing of its user's."""
    folders = ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR", "JUPYTERLAB_SETTINGS_DIR")
    own = {name: str(home / name.lower()) for name in (*folders, "JUPYTERLAB_WORKSPACES_DIR")}
    return {**os.environ, **own, "OMP_NUM_THREADS": "1", "PYTHONWARNINGS": "ignore"}


def wait_for(lab: Lab, process: subprocess.Popen[bytes], log: Path) -> None:
    """Wait until a server answers; its connection attempts are refused until it listens, so each takes no time."""
    for _ in range(START * 10):
        try:
            urllib.request.urlopen(f"{lab.address}api?token={lab.token}", timeout=10).close()
        except (urllib.error.URLError, ConnectionError):
            if process.poll() is not None:
                break
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(0.1)
        else:
            return
    pytest.fail(f"JupyterLab did not start:\n{log.read_text()[-3000:]}")


@pytest.fixture(scope="module")
def notebook(visitor: BrowserContext, lab: Lab, request: pytest.FixtureRequest) -> Iterator[Notebook]:
    """A page for the notebook of a module; what it asked of the world and what went wrong in it fails the last test."""
    page = visitor.new_page()
    page.set_default_timeout(PATIENCE)
    opened = Notebook(page, lab, Path(request.node.name).stem)
    local = (lab.address, lab.address.replace("http", "ws"), "data:", "blob:")
    page.on("request", lambda asked: None if asked.url.startswith(local) else opened.asked_outside.append(asked.url))
    page.on("pageerror", lambda error: None if any(said in str(error) for said in NOT_OURS) else opened.errors.append(str(error)))
    page.on("console", lambda said: opened.errors.append(said.text) if said.type == "error" and OURS.search(said.text) else None)
    yield opened
    page.evaluate(SHUT_DOWN)
    page.close()
    assert opened.asked_outside == []
    assert opened.errors == []


@pytest.fixture(scope="session")
def finished_run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A small run on disk, with a branch."""
    run = stylize(knob(), out=tmp_path_factory.mktemp("runs") / "part", name="griff", device="cpu", **SETTINGS)
    run.branch(6, lane="frozen", control="frozen").go()
    return run
