"""A run that a queue or a container asks to end (SIGTERM): in a sentence, nothing of it left behind, and the same command goes on."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from mechstyle.loop.store import Store
from support.kills import LEFT_BEHIND, contents

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks for processes where Linux lists them")


def meshing(folder: Path) -> list[int]:
    """Processes that have loaded fTetWild for a request in a folder."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if str(folder) in (process / "cmdline").read_text() and "pytetwild" in (process / "maps").read_text():
                found.append(int(process.name))
        except OSError:  # it has ended
            continue
    return found


@dataclass(frozen=True)
class Ended:
    """A command line that was asked to end as soon as something could be seen."""

    code: int
    said: str
    left: list[str]


@pytest.fixture
def asked_to_end(finished, tmp_path, monkeypatch):
    """Starts a command, asks it to end once `seen(scraps)` holds, where `scraps` is its folder of temporary files."""
    line, scraps = finished[0], tmp_path / "scraps"
    scraps.mkdir()
    monkeypatch.setenv("TMPDIR", str(scraps))

    def started(arguments, seen) -> Ended:
        with line.start(*arguments) as process:
            while process.poll() is None and not seen(scraps):
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(0.02)  # or ends by itself; looking without a pause would take the core it runs on
            process.send_signal(signal.SIGTERM)
            _, said = process.communicate()
        assert not meshing(scraps), "its worker went on alone"
        return Ended(process.returncode, " ".join(said.split()), [path.name for path in scraps.iterdir()])

    return started


def checkpointed(store: Store) -> bool:
    return bool(store.lanes() and store.lane().head) and store.find(None).iteration >= 3


def test_a_run_that_is_asked_to_end_does_so_and_the_same_command_goes_on(asked_to_end, finished, tmp_path, monkeypatch):
    """Between two checkpoints; then, where the cache of prepared parts is empty, while the part is meshed anew."""
    line, whole, _ = finished
    root = tmp_path / "part"
    arguments = (*line.styled, "--out", root)
    sentence = "error: interrupted; what was checkpointed is kept, and the same command goes on from there"
    between = asked_to_end(arguments, lambda _: checkpointed(Store(root)))
    assert (between.code, between.said[-len(sentence) :], between.left) == (130, sentence, [])
    assert not Store(root).is_finished(), "it must have been ended on the way"
    assert not list(root.rglob(f"{LEFT_BEHIND}*"))
    before = contents(root)
    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path / "empty"))
    amid = asked_to_end(arguments, meshing)
    assert (amid.code, amid.said[-len(sentence) :], amid.left) == (130, sentence, [])
    assert contents(root) == before
    monkeypatch.undo()
    line(*arguments)
    assert contents(root) == contents(whole)


@pytest.mark.parametrize("module", ["numpy", "typer", "mechstyle.cli.run"])
def test_who_presses_ctrl_c_while_it_is_loaded_is_not_shown_where_it_was(module):
    program = f"""
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # what runs in the background may be started with it ignored
class Pressed:
    def find_spec(self, name, *_):
        if name == {module!r}:
            signal.raise_signal(signal.SIGINT)
sys.meta_path.insert(0, Pressed())
sys.argv = ["mechstyle", "--help"]
from mechstyle.__main__ import main
main()
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")
