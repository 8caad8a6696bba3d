"""A run directory of another version is refused in one sentence, whatever is asked of it, and stays as it is.

`data/earlier_run.zip` is a lane on a sheet with a branch at iteration 6, both finished, with settings and verdicts that are no more.
"""

import re
import zipfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mechstyle.cli.app import app
from mechstyle.errors import BadInput
from mechstyle.runs.run import Run

EARLIER = Path(__file__).parent / "data" / "earlier_run.zip"


@pytest.fixture
def earlier(tmp_path) -> Path:
    """The directory, unpacked."""
    with zipfile.ZipFile(EARLIER) as packed:
        packed.extractall(tmp_path / "earlier")
    return tmp_path / "earlier"


COMMANDS = (["log"], ["show"], ["export"], ["report"], ["rerun"], ["branch", "--iterations", "30"])


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_a_command_refuses_it_in_one_sentence(earlier, command):
    before = {path: path.read_bytes() for path in earlier.rglob("*") if path.is_file()}
    name, *options = command
    done = CliRunner().invoke(app, [name, f"{earlier}@6" if name == "branch" else str(earlier), *options])
    assert done.exit_code == 2
    said = " ".join(done.output.split())
    assert re.fullmatch(r"error: \S+: this run was made by another version of MechStyle; run it again in another folder", said)
    assert {path: path.read_bytes() for path in earlier.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize("ask", [lambda run: run.recipe, lambda run: run.history, lambda run: run.verdict, lambda run: run.summary])
def test_python_refuses_it_in_the_same_sentence(earlier, ask):
    with pytest.raises(BadInput, match="made by another version of MechStyle; run it again"):
        ask(Run.open(earlier, "cpu"))


def test_a_line_shows_it_with_the_same_sentence(earlier):
    assert re.search(r"which cannot be read: .*made by another version of MechStyle; run it again", repr(Run.open(earlier, "cpu")))
