"""The command line as a user meets it: one process, one small run shared by the tests that only look at it."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mechstyle.cli.app import app
from support.lanes import lane_on_a_sheet

QUICK = ("--set", "element=tet4", "--set", "window=0.4", "--set", "nearly_flat=False")
BOX = Path(__file__).with_name("box.obj")
SMALL = ("--vertices", "600", "--iterations", "12", "--orientations", "2", *QUICK)


@dataclass(frozen=True)
class Outcome:
    code: int
    stdout: str
    stderr: str

    @property
    def json(self):
        return json.loads(self.stdout)


@dataclass(frozen=True)
class CommandLine:
    folder: Path
    small: tuple[str, ...] = SMALL
    styled: tuple[str, ...] = ("run", str(BOX), "--prompt", "brick", *SMALL)

    def start(self, *arguments: object) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "mechstyle", *map(str, arguments)]
        return subprocess.Popen(command, cwd=self.folder, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    @property
    def environment(self) -> dict[str, str]:
        return {**os.environ, "COLUMNS": "160", "NO_COLOR": "1"}

    def __call__(self, *arguments: object, code: int | None = 0) -> Outcome:
        command = [sys.executable, "-m", "mechstyle", *map(str, arguments)]
        done = subprocess.run(command, cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=600, check=False)
        if code is not None:
            assert done.returncode == code, done.stdout + done.stderr
        return Outcome(done.returncode, done.stdout, done.stderr)

    def here(self, *arguments: object, code: int = 0) -> Outcome:
        """The same without the start-up of a process, for what only looks, or is refused."""
        with contextlib.chdir(self.folder):
            done = CliRunner().invoke(app, [*map(str, arguments)], env={"COLUMNS": "160", "NO_COLOR": "1"})
        assert done.exit_code == code, done.output
        return Outcome(done.exit_code, done.stdout, done.stderr)


@pytest.fixture
def mechstyle(tmp_path) -> CommandLine:
    return CommandLine(tmp_path)


@pytest.fixture(scope="session")
def finished(made_once) -> tuple[CommandLine, Path, dict]:
    """A finished small run: the command line, its directory and the JSON it printed."""

    def carry_out(folder: Path) -> None:
        folder.mkdir()
        line = CommandLine(folder)
        (folder / "printed.json").write_text(line(*line.styled, "--out", "part", "--json").stdout)

    folder = made_once("finished", carry_out)
    return CommandLine(folder), folder / "part", json.loads((folder / "printed.json").read_text())


@pytest.fixture
def sheet(tmp_path):
    """Makes a lane without physics: name, origin, gain and any setting of the recipe may be given."""
    return lambda **settings: lane_on_a_sheet(tmp_path / "run", **settings)
