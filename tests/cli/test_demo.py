"""The demo on the command line, as far as no simulation is needed."""

import shlex
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from mechstyle import teaching
from mechstyle.cli import demo
from mechstyle.cli import run as commands
from mechstyle.cli.app import app
from support.records import row, verdict


def test_the_demo_ends_with_one_table_of_what_stays_bent_of_both(pair, capsys, tmp_path):
    demo.tell(pair, tmp_path, as_json=False)
    *_, headings, flat, kept, _next = (" ".join(line.split()) for line in capsys.readouterr().out.splitlines() if line)
    assert headings == "test plain Freestyle MechStyle allowed"
    assert flat == "flat 0.03 mm 0.43 mm FAILS 0.08 mm HOLDS 0.20 mm"
    assert kept == "style kept – 91% 91% –"


def test_the_demo_shows_the_runs_of_lesson_1(monkeypatch, tmp_path):
    monkeypatch.setattr(commands, "finish", lambda run, *_: run)
    shown = {}
    monkeypatch.setattr(demo, "tell", lambda runs, folder, **_: shown.update({str(folder): runs}))
    for words in ([], ["--prompt", "stone", "--height", "75 cm", "--tolerance", "0.3 mm"]):
        out = tmp_path / f"demo-{len(words)}"
        assert CliRunner().invoke(app, ["demo", "--out", str(out), "--device", "cpu", *words]).exit_code == 0
        free, fed = shown[str(out)].values()
        changes = {"prompt": "stone", "height": "75 cm", "tolerance": 0.3} if words else {}
        assert free.recipe == teaching.settled(freely=True, **changes)
        assert fed.recipe == teaching.settled(**changes)
        assert [run.part.tets.digest for run in (free, fed)] == [teaching.trophy().tets.digest] * 2


def test_vertices_of_the_trophy_are_refused_in_one_sentence(mechstyle):
    assert "leave it out" in mechstyle.here("demo", "--vertices", "900", "--json", code=2).json["error"]


NEXT = "mechstyle run YOUR_PART.stl --prompt brick"


@pytest.fixture
def environment(tmp_path, monkeypatch):
    """A virtual environment with the command, in the folder one is in, not activated."""
    folder = tmp_path / "a project" / ".venv"
    (folder / "bin").mkdir(parents=True)
    (folder / "bin" / "activate").write_text(f"PATH={shlex.quote(str(folder / 'bin'))}:$PATH\n")
    command = folder / "bin" / "mechstyle"
    command.write_text("#!/bin/sh\necho ran $*\n")
    command.chmod(0o755)
    monkeypatch.setattr(sys, "prefix", str(folder))
    monkeypatch.setenv("PATH", "/usr/bin:/bin")
    monkeypatch.chdir(folder.parent)
    return folder


@pytest.fixture
def pair(monkeypatch):
    """Two finished runs, as far as they are printed."""
    monkeypatch.setattr(teaching, "bent", lambda _: SimpleNamespace(save=lambda path: path))
    summary = SimpleNamespace(kept=0.91, files={"model": "part.3mf"}, notes=())
    found = (verdict(row(bend, plain_permanent_set=0.03)) for bend in (0.43, 0.08))
    return dict(zip(("Freestyle", "MechStyle"), (SimpleNamespace(summary=summary, verdict=one) for one in found), strict=True))


def last_line(pair, capsys):
    demo.tell(pair, Path("demo-out"), as_json=False)
    return capsys.readouterr().out.splitlines()[-1]


def test_the_next_command_is_printed_as_it_can_be_pasted(environment, pair, capsys, monkeypatch):
    assert last_line(pair, capsys) == f"next: source .venv/bin/activate && {NEXT}"
    for folder in (environment.parent, environment.parent.parent, environment / "bin"):  # the second names the folder with a blank in it
        monkeypatch.chdir(folder)
        line = last_line(pair, capsys).removeprefix("next: ")
        done = subprocess.run(["bash", "-c", line], cwd=folder, capture_output=True, text=True, check=True)
        assert done.stdout == f"ran {NEXT.removeprefix('mechstyle ')}\n"


def test_without_an_environment_there_is_nothing_to_activate(pair, capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    assert last_line(pair, capsys) == f"next: {NEXT}"
