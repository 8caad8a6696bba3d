"""Nothing asks the network, unless it is asked to: every command and the Studio, in processes that have none."""

from __future__ import annotations

import os
import pkgutil
import subprocess
import sys

import pytest
import typer

import mechstyle as package
import mechstyle_widgets
from cli.conftest import BOX
from mechstyle.cli.app import app

CLOSED = """
import sys

def refused(event, arguments):
    if event in ("socket.connect", "socket.getaddrinfo", "socket.gethostbyname", "socket.bind", "socket.sendto", "urllib.Request"):
        raise OSError(101, f"the network was asked for: {event}")

sys.addaudithook(refused)
"""
"""Read by every Python process before anything else, workers included; a hook that was added stays."""


@pytest.fixture
def offline(mechstyle, monkeypatch):
    """The command line without a network."""
    closed = mechstyle.folder / ".closed"
    closed.mkdir()
    (closed / "sitecustomize.py").write_text(CLOSED)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(closed), os.environ.get("PYTHONPATH", "")]))
    return mechstyle


def in_python(script):
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)


def test_the_network_is_closed_indeed(offline):
    done = in_python("import socket; socket.create_connection(('127.0.0.1', 9))")
    assert "the network was asked for: socket.getaddrinfo" in done.stderr


def test_what_asks_for_the_network_says_so_in_a_sentence(offline):
    """The one command that does, so that the others are known not to."""
    said = offline("weights", "fetch", code=2)
    assert said.stderr.startswith(("fetching", "error"))
    assert "Traceback" not in said.stderr


COMMANDS = """
import sys
from mechstyle.cli.app import app
for words in {commands!r}:
    try:
        app(args=words, standalone_mode=True)
    except SystemExit as left:
        assert not left.code, words
"""


LONG = {"demo", "studio"}
"""Commands that take minutes, each of them runs as `run` and `freestyle` make them; or that serve until they are ended: tests/browser."""


def test_every_command_works_without_a_network(finished, offline):
    """One after the other in one process; the tetrahedra are made in processes of their own, or found where other tests left theirs."""
    _, root, _ = finished
    out = offline.folder
    small = ("vertices=600", "iterations=12", "orientations=1", "set=element=tet4", "set=window=0.05", "set=nearly_flat=False")
    quick = [f"--{one}" for one in small]
    commands = [
        ["--help"], ["materials"], ["styles"], ["gallery"], ["doctor"], ["weights", "list"], ["log", f"{root}"],
        ["show", f"{root}", "--out", f"{out}/picture.png"], ["export", f"{root}", "--out", f"{out}/part.glb"],
        ["report", f"{root}", "--out", f"{out}/page.html"], ["class", "collect", f"{out}/page.html"],
        ["film", f"{root}", "--no-plain", "--frames=8", "--size=160", "--out", f"{out}/fall.gif"],
        ["run", f"{BOX}", "--prompt", "brick", *quick, "--out", f"{out}/run"], ["gc", f"{out}/run"],
        ["freestyle", f"{BOX}", "--prompt", "brick", *quick, "--out", f"{out}/free"],
        ["branch", f"{out}/run@1", "--control", "frozen"], ["rerun", f"{out}/run"], ["orient", f"{out}/run"],
        ["simulate", f"{out}/part.glb", "--vertices=600", "--orientations=1", "--no-nearly-flat", "--window=0.05", "--out", f"{out}"],
        ["protect", "gallery:pen_holder", "--protect", "rim", "--vertices", "2000", "--out", f"{out}/rim.png"],
    ]  # fmt: skip
    assert {words[0] for words in commands} | LONG >= set(typer.main.get_command(app).commands)
    done = in_python(COMMANDS.format(commands=commands))
    assert done.returncode == 0, done.stderr[-2000:]
    assert "the network was asked for" not in done.stdout + done.stderr


def test_nothing_asks_for_the_network_as_it_is_imported_and_the_studio_opens(offline):
    modules = [
        module.name
        for one in (package, mechstyle_widgets)
        for module in pkgutil.walk_packages(one.__path__, f"{one.__name__}.")
        if not module.name.endswith("__main__")
    ]
    assert len(modules) > 150
    imports = f"import importlib\nfor name in {modules!r}:\n    importlib.import_module(name)\n"
    done = in_python(f"{imports}from mechstyle_widgets import Studio\nStudio()\nprint('open')")
    assert (done.returncode, done.stdout.strip().splitlines()[-1:]) == (0, ["open"]), done.stderr[-2000:]
