"""`mechstyle studio`: the page without a notebook, on this machine alone."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from .conftest import PATIENCE, SETTLED, private

pytestmark = pytest.mark.browser
ADDRESS = re.compile(r"The Studio is at (http\S+)")
SIZES = """() => {
    const box = (name) => document.querySelector(name).getBoundingClientRect();
    const [studio, canvas, tools] = ['.mechstyle-studio', '.mechstyle-viewer canvas', '.mechstyle-toolbar'].map(box);
    return {studio: [studio.x, studio.y, studio.width, studio.height], picture: canvas.width * canvas.height, tools: tools.height};
}"""
SCROLLED = """() => ['.mechstyle-setup', '.mechstyle-middle', '.mechstyle-inspect'].map(name => {
    const column = document.querySelector(name);
    return [getComputedStyle(column).overflowY, column.getBoundingClientRect().bottom <= innerHeight];
})"""


@pytest.fixture
def address(tmp_path: Path, chromium_path: str, thumbnails_drawn: None) -> Iterator[str]:
    command = [sys.executable, "-m", "mechstyle", "studio", "gallery:pen_holder", "--no-browser", "--port", "8930"]
    with subprocess.Popen(command, cwd=tmp_path, env=private(tmp_path), stdout=subprocess.PIPE, text=True) as served:
        try:
            assert served.stdout is not None
            found = next((one for line in served.stdout if (one := ADDRESS.search(line))), None)
            assert found is not None, "it ended without an address"
            yield found[1]
        finally:
            served.send_signal(signal.SIGTERM)


def test_the_studio_fills_a_page_that_asks_nothing_outside(chromium: Any, address: str) -> None:
    assert address.startswith("http://127.0.0.1:")
    page = chromium.new_context(viewport={"width": 1440, "height": 900}).new_page()
    page.set_default_timeout(PATIENCE)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(address, wait_until="domcontentloaded")
    page.locator(".mechstyle-viewer canvas").first.wait_for()
    page.wait_for_function("() => document.querySelector('.mechstyle-viewer canvas').clientHeight > 600")
    page.evaluate(SETTLED)
    found = page.evaluate(SIZES)
    assert found["studio"] == [0, 0, 1440, 900]
    assert found["picture"] >= 0.45 * 1440 * 900
    assert found["tools"] < 50, "one row of tools"
    assert page.evaluate(SCROLLED) == [["auto", True]] * 3
    assert [url for url in asked if not url.startswith(("http://127.0.0.1:", "ws://127.0.0.1:", "data:", "blob:"))] == []
    page.get_by_role("button", name="Full window").click()
    page.wait_for_function("() => !document.querySelector('.mechstyle-studio').matches(':popover-open')")
    page.close()
