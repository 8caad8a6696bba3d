"""Hundreds of random actions on a Studio in JupyterLab, in headless Chromium: clicks, drags, keys and texts leave no error anywhere.

    python benchmarks/walk.py [--actions 300] [--seed 1]

What can be clicked, chosen or written in the page is acted on in an order that the seed decides, faster than a person would; now and then
the page is loaded anew. Runs take no time: a part becomes a sheet, as in tests/widgets/test_random_walk.py, which acts without a page.
Every tenth action badge, Result, pictures and tooltips must say one thing of what is on show, in kernel and page.
At the end the kernel must answer and the view must show something. Errors of the page, of the kernel and in the log of the server are
listed with the actions before them, and make the exit status 1.
"""

from __future__ import annotations

import argparse
import random
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from _pytest.outcomes import Failed
from lab import Page, browser, laboratory
from playwright.sync_api import Error as PageError
from rich.console import Console

TESTS = Path(__file__).parents[1] / "tests"
CELL = f"""
import sys
sys.path.insert(0, {str(TESTS)!r})
import pytest
from support.sheet_studio import without_physics
from support.told import assert_tells_one_truth, outcomes
from mechstyle_widgets import Studio
from mechstyle_widgets.viewer.run_viewer import RunViewer
def shows():
    return isinstance(studio.viewer, RunViewer) and studio.state.checkpoint is not None and (
        not studio.controller.busy or studio.state.status == "paused")
def drawn():
    return not shows() or studio.viewer.up_to_date
def stands():
    state = studio.state
    return shows() and drawn(), state.lane, state.iteration, state.status, state.row() and state.row().digest, state.another
without_physics(pytest.MonkeyPatch())
studio = Studio("gallery:wall_hook", prompt="brick", schedule="every", every=4, iterations=12, vertices=900)
studio
"""
ALL_OF_IT = "studio.viewer.cut_open(on=False); studio.viewer.fit('three_quarter')"
"""Whatever a walk has left of the view."""
LISTEN = """() => {
    const kernel = window.jupyterapp.shell.currentWidget.sessionContext.session.kernel;
    window.complaints = [];
    kernel.anyMessage.connect((_, { msg, direction }) => {
        const { msg_type: kind } = msg.header, { name, text, ename, evalue } = msg.content;
        if (direction === 'recv' && kind === 'error') window.complaints.push(`${ename}: ${evalue}`);
        if (direction === 'recv' && kind === 'stream' && name === 'stderr') window.complaints.push(text);
    });
}"""
"""Notes what the kernel says of errors, in whatever cell or message."""
SEEN = """() => [...document.querySelectorAll('.mechstyle-result, .mechstyle-badge:not(:has(.mechstyle-insight))')]
    .filter(one => one.checkVisibility()).map(one => {
        const unfolded = one.cloneNode(true);
        unfolded.querySelectorAll('details, style').forEach(folded => folded.remove()); // what is known of others, too
        unfolded.querySelectorAll('*').forEach(one => one.append(' ')); // what stands apart in the page
        return unfolded.textContent;
    })"""
"""What the page says of what is on show."""
WITHIN_REACH = """() => {
    const kinds = 'button, select, input, textarea, canvas, .noUi-handle, .nsewdrag, summary';
    const solid = one => one.closest('.jupyter-widgets')?.querySelector('.widget-label')?.textContent === 'thicken [mm]'; // a sheet is not
    const there = one => one.checkVisibility({ visibilityProperty: true }) && !one.disabled && one.type !== 'file' && !solid(one);
    const called = one => one.title || one.ariaLabel || one.placeholder || one.textContent.slice(0, 40);
    window.reached = [...document.querySelectorAll(`.mechstyle-studio :is(${kinds})`)].filter(there);
    return window.reached.map(one => [one.localName, one.type ?? '', called(one)]);
}"""
TEXTS = (
    "brick", "small wood", "outside: stone; rim: gold studs", "my own idea", "", "5 mm bricks, blue", "1.2 m", "abc", "nowhere.stl", "mine",
    "../away", "box 0 0 0 10 10 10", "a circle", "<b>bold</b>",
)  # fmt: skip
NUMBERS = ("0", "1", "4", "12", "64", "900", "-3", "1e9", "0.5", "")
KEYS = [*"rn.123456amxoliwpzyf?", "Escape", "ArrowLeft", "ArrowUp", "Home", "End", "Enter", "Space", "PageUp", "+", "-"]
ALLOWED = ("holds a run with other settings",)
"""What the kernel may say: that is told to the user, too."""
RELOAD, CALM = 0.01, 10
"""How often a page is loaded anew, and after how many actions the kernel is waited for."""
SOON = 1000
"""What cannot be acted on by then lies under something else [ms]."""


LOGGED, STACK = re.compile("Traceback|restart|^\\[E "), 40
"""How an error begins in a log, and how many lines of it are listed."""


class Walker:
    """Acts on a page at random, and notes what it did and what went wrong."""

    def __init__(self, shown: Page, seed: int) -> None:
        """Listen from now on."""
        self.shown, self.page, self.rng = shown, shown.page, random.Random(seed)
        self.done: list[str] = []
        self.wrong: list[str] = []
        self.page.on("pageerror", lambda error: None if any(one in str(error) for one in browser.NOT_OURS) else self.note(f"page: {error}"))
        self.page.on("console", lambda said: self.note(f"page: {said.text}") if self._ours(said) else None)
        self.page.on("dialog", lambda dialog: dialog.accept())
        self.page.evaluate(LISTEN)

    def act(self) -> None:
        """One action, on something that is there."""
        if self.rng.random() < RELOAD:
            self._reload()
            return
        choices = self.page.evaluate(WITHIN_REACH)
        number = self.rng.randrange(len(choices))
        tag, kind, name = choices[number]
        acts: dict[str, Callable[[Any], str]] = {
            "select": self._choose, "textarea": self._write, "canvas": self._on_canvas, "text": self._write, "search": self._write,
            "number": self._count, "range": self._slide, "div": self._slide, "rect": self._press,
        }  # fmt: skip
        element = self.page.evaluate_handle("number => window.reached[number]", number).as_element()
        try:
            how = acts.get(tag if tag in acts else kind, self._press)(element)
        except PageError as error:  # it went away, or lies under something else, as for a person
            how = f"missed ({str(error).splitlines()[0][:60]})"
        self.done.append(f"{how} {name!r}")

    def listen(self) -> None:
        """Wait for the kernel, and note what it complained of."""
        self.shown.notebook.until("1", 1)
        for said in self.page.evaluate("() => window.complaints.splice(0)"):
            if not any(one in said for one in ALLOWED):
                self.note(f"kernel: {said.strip()}")
        self._compare()

    def _compare(self) -> None:
        """Badge, Result, pictures and tooltips say one thing of what is on show."""
        notebook = self.shown.notebook
        notebook.until("drawn()", True)
        self.page.evaluate(browser.SETTLED)
        if said := notebook.python("if shows() and drawn(): assert_tells_one_truth(studio)"):
            self.note(f"not one truth: {said}")
            self.page.evaluate("() => window.complaints.pop()")  # the same, heard
        seen: list[str] = []
        for _ in range(CALM):  # what goes on meanwhile reaches the page word by word
            before, seen = notebook.python("print(stands())"), self.page.evaluate(SEEN)
            if notebook.python("print(stands())") == before:
                break
        else:
            return
        found = notebook.python(f"if shows() and drawn(): print(len({{one for text in {seen!r} for one in outcomes(text)}}) == 1)")
        if found not in ("", "True"):
            self.note(f"not one truth in the page: {found} {seen}")

    def _reload(self) -> None:
        self.listen()
        self.done.append("load the page anew")
        self.page.evaluate("() => window.jupyterapp.commands.execute('docmanager:save')")
        self.page.reload(wait_until="domcontentloaded")
        self.page.wait_for_function(browser.LAB_IS_IDLE)
        self.page.locator(".mechstyle-studio canvas").first.wait_for()
        self.page.evaluate(LISTEN)

    def _press(self, element: Any) -> str:
        element.click(timeout=SOON)
        return "press"

    def _choose(self, element: Any) -> str:
        number = self.rng.randrange(max(element.evaluate("one => one.options.length"), 1))
        element.select_option(index=number, timeout=SOON)
        return f"choose {number} of"

    def _write(self, element: Any) -> str:
        text = self.rng.choice(TEXTS)
        element.fill(text, timeout=SOON)
        element.press("Enter", timeout=SOON)
        return f"write {text!r} into"

    def _count(self, element: Any) -> str:
        number = self.rng.choice(NUMBERS)
        element.fill(number, timeout=SOON)
        element.press("Tab", timeout=SOON)
        return f"write {number!r} into"

    def _slide(self, element: Any) -> str:
        keys = [self.rng.choice(("ArrowLeft", "ArrowRight", "Home", "End", "PageUp", "PageDown")) for _ in range(3)]
        for key in keys:
            element.press(key, timeout=SOON)
        return f"press {keys} on"

    def _on_canvas(self, element: Any) -> str:
        element.scroll_into_view_if_needed(timeout=SOON)
        box = element.bounding_box()
        across, up, more = (self.rng.uniform(0.1, 0.9) for _ in range(3))
        x, y = box["x"] + across * box["width"], box["y"] + up * box["height"]
        how = self.rng.choice(("click", "drag", "wheel", "key"))
        self.page.mouse.move(x, y)
        if how == "click":
            self.page.mouse.click(x, y)
        elif how == "drag":
            self.page.mouse.down()
            self.page.mouse.move(box["x"] + more * box["width"], y, steps=4)
            self.page.mouse.up()
        elif how == "wheel":
            self.page.mouse.wheel(0, self.rng.choice((-300, 300)))
        else:
            how = self.rng.choice(KEYS)
            element.press(how, timeout=SOON)
        return f"{how} on the view"

    def _ours(self, said: Any) -> bool:
        return said.type == "error" and browser.OURS.search(said.text) is not None

    def note(self, what: str) -> None:
        """Say what went wrong, after what."""
        self.wrong.append(f"{what[:200]} … {what[-900:]}\n    after {'; '.join(self.done[-9:])}")
        Console().print(self.wrong[-1], markup=False)


def main() -> None:
    """Walk, and say what went wrong."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--actions", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    with laboratory() as (chromium, lab, notebooks):
        walker = Walker(Page(chromium, lab, "walk", CELL), given.seed)
        try:
            for number in range(1, given.actions + 1):
                walker.act()
                if number % CALM == 0:
                    walker.listen()
            walker.listen()
            walker.shown.notebook.python(ALL_OF_IT)
            walker.shown.notebook.drawn()
        except (Exception, Failed) as error:  # noqa: BLE001 — whatever it is, it is listed with what was done before
            walker.shown.notebook.keep(f"walk-{given.seed}")
            walker.note(f"{type(error).__name__}: {error}")
        log = (notebooks.parent / "home" / "log").read_text(encoding="utf-8")
    lines = log.splitlines()
    logged = ["\n".join(lines[at : at + STACK]) for at, line in enumerate(lines) if LOGGED.search(line)]
    for line in logged:
        Console().print(f"log: {line}", markup=False)
    missed, wrong = sum(one.startswith("missed") for one in walker.done), len(walker.wrong) + len(logged)
    Console().print(f"{len(walker.done)} actions, seed {given.seed}: {missed} missed, {wrong} errors in page, kernel and log")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
