"""How far one reads from a click on Run until the run goes: files that are entered, and returns to one that was left before."""

from __future__ import annotations

import sys
import threading
from itertools import groupby
from pathlib import Path

import pytest

import mechstyle
import mechstyle_widgets
from mechstyle.runs import run as module
from mechstyle_widgets.state.studio_state import StudioState
from mechstyle_widgets.studio import Studio

pytestmark = pytest.mark.slow
ROOTS = tuple(Path(package.__file__).parent for package in (mechstyle, mechstyle_widgets))
FILES, RETURNS = 25, 40
PATIENCE = 120.0  # seconds before the test gives up; nothing waits this long


def place_of(path: str) -> str:
    """A file of either package as `package/room/file.py`, "" for any other."""
    return next((Path(path).relative_to(root.parent).as_posix() for root in ROOTS if path.startswith(str(root))), "")


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """Files of the first call of every function on the way, in order; what the process that prepares the part does is its own affair."""
    studio = Studio("gallery:drawer_knob", vertices=500, device="cpu", folder=str(tmp_path_factory.mktemp("walk") / "run"))
    gone, seen, found = threading.Event(), set(), list[str]()

    def entered(frame, event, _):
        code = frame.f_code
        if event == "call" and not gone.is_set() and code not in seen and not code.co_name.startswith("<") and place_of(code.co_filename):
            seen.add(code)
            found.append(place_of(code.co_filename))

    def goes(_run, _progress):
        gone.set()
        yield from ()

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(module.Run, "events", goes)
        threading.setprofile(entered)
        sys.setprofile(entered)
        try:
            studio.run_controls._buttons["run"].click()
        finally:
            sys.setprofile(None)
            threading.setprofile(None)
        assert gone.wait(PATIENCE), studio.state.message
        studio.state.session.wait(PATIENCE)
    studio.close()
    return found


def test_from_a_click_to_the_run_few_files_are_entered(walk):
    assert {place_of(module.__file__), place_of(sys.modules[StudioState.__module__].__file__)} <= set(walk)
    assert len(set(walk)) <= FILES, sorted(set(walk))


def test_from_a_click_to_the_run_one_seldom_returns_to_a_file(walk):
    stays = [place for place, _ in groupby(walk)]
    assert len(stays) - len(set(stays)) <= RETURNS, stays
