"""What the report and the widgets cost, in headless Chromium with software WebGL: figures, not a test.

    python benchmarks/widgets.py [RUN]

RUN is a run directory; without one a pen holder of 25k vertices is stylized for 200 iterations first, which takes minutes.
Software WebGL draws far slower than any graphics card, and everything here shares the machine's cores: the figures are upper bounds.
"""

from __future__ import annotations

import argparse
import base64
import shutil
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from playwright.sync_api import Browser, sync_playwright
from rich.console import Console
from rich.table import Table

from mechstyle.gallery import make
from mechstyle.runs.report.markup import bundle
from mechstyle.runs.report.replay_data import replay_data
from mechstyle.runs.run import Run, stylize

ARGUMENTS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
ARGUMENTS += ["--enable-precise-memory-info", "--js-flags=--expose-gc"]
RERUNS = 50
SIZE_BUDGET, READY_BUDGET = 20.0, 8.0  # [MB], [s], for 200 iterations of 25k vertices

SCRUB = """async () => {
    const slider = document.querySelector('.ms-scrub input'), times = [];
    for (let frame = 0; frame <= Number(slider.max); frame++) {
        slider.value = frame;
        const start = performance.now();
        slider.dispatchEvent(new Event('input'));
        await new Promise(requestAnimationFrame);
        const gl = document.querySelector('.ms-canvas').getContext('webgl2');
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // waits until it is drawn
        times.push(performance.now() - start);
    }
    return times;
}"""
"""Milliseconds from the slider to the finished picture, for every frame: what a user waits for."""

STEP = """() => {
    const { player } = window, times = [];
    for (let frame = 0; frame < player.replay.frames.length; frame++) {
        const start = performance.now();
        player.scene.current.show(frame, 'stress');
        times.push(performance.now() - start);
    }
    return times;
}"""
"""Milliseconds to decode and upload a frame, without drawing it: what is left of it on a graphics card."""

REOPEN = "open_player().then(close_player)"
"""Shows the replay and closes it again, as running its cell again does."""

HARNESS = """
window.take_replay = ([header, payload]) => {
    window.replay_of = [header, Uint8Array.from(atob(payload), (letter) => letter.charCodeAt(0))];
};
window.open_player = async () => {
    const root = document.createElement('div');
    document.body.append(root);
    window.player = new Player(root, await unpack(...window.replay_of));
    await new Promise(requestAnimationFrame);
    await new Promise(requestAnimationFrame);
};
window.close_player = () => { const { root } = window.player; window.player.dispose(); root.remove(); window.player = null; };
window.heap = async () => {
    gc();
    await new Promise((done) => setTimeout(done, 200));
    gc();
    return performance.memory.usedJSHeapSize / 1e6;
};
"""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("run", nargs="?", type=Path, help="a run directory")
    given = parser.parse_args()
    path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if path is None:
        sys.exit("there is no chromium on PATH (Debian: apt-get install chromium)")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        run = Run.open(given.run, "cpu") if given.run else stylize(make("pen_holder"), "brick", out=Path(folder) / "run")
        browser = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        rows = [*of_report(browser, run, Path(folder) / "report.html"), *of_replay(browser, run)]
        browser.close()
    table = Table("what", "measured", "budget", title=f"{run!r}, {len(run.part.surface.vertices)} vertices", title_justify="left")
    for row in rows:
        table.add_row(*row)
    Console().print(table)


def of_report(browser: Browser, run: Run, path: Path) -> list[tuple[str, str, str]]:
    """Size, time to write, time until it can be used, and time a step of the slider takes."""
    start = time.perf_counter()
    run.report(path)
    written = time.perf_counter() - start
    page = browser.new_context(viewport={"width": 1100, "height": 900}, offline=True).new_page()
    start = time.perf_counter()
    page.goto(path.as_uri())
    page.locator("body[data-ready]").wait_for(timeout=120_000)
    ready = time.perf_counter() - start
    steps = page.evaluate(SCRUB)
    page.context.close()
    return [
        ("report: size", f"{path.stat().st_size / 1e6:.1f} MB", f"{SIZE_BUDGET:g} MB"),
        ("report: written in", f"{written:.1f} s", ""),
        ("report: ready after", f"{ready:.1f} s", f"{READY_BUDGET:g} s"),
        ("report: a step of the slider, drawn", spread(steps), ""),
    ]


def of_replay(browser: Browser, run: Run) -> list[tuple[str, str, str]]:
    """A frame without its drawing, and what opening and closing it over and over leaves behind."""
    played = replay_data(run)
    page = browser.new_page()
    page.set_content("<!doctype html><title>replay</title>")
    page.add_script_tag(content=bundle(HARNESS), type="module")
    page.evaluate("replay => take_replay(replay)", [played.header, base64.b64encode(played.payload).decode("ascii")])
    page.evaluate(REOPEN)
    first = page.evaluate("heap()")
    for _ in range(RERUNS):
        page.evaluate(REOPEN)
    last = page.evaluate("heap()")
    page.evaluate("open_player()")
    frames = page.evaluate(STEP)
    page.close()
    return [
        ("replay: data", f"{len(played.payload) / 1e6:.1f} MB", ""),
        ("replay: a frame decoded and uploaded, not drawn", spread(frames), "16.7 ms"),
        (f"replay: heap after 1 and after {RERUNS + 1} runs of a cell", f"{first:.1f} and {last:.1f} MB", ""),
    ]


def spread(times: list[float]) -> str:
    """Median and the slowest but one in twenty [ms]."""
    return f"median {median(times):.1f} ms, 95 % within {sorted(times)[int(0.95 * len(times))]:.1f} ms"


if __name__ == "__main__":
    main()
