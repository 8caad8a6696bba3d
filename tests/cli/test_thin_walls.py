"""Walls too thin to print: said before the minutes of meshing, not after them."""

from __future__ import annotations

import pytest

import mechstyle as ms
from mechstyle.cli.app import app
from mechstyle.cli.console import progress_shown
from mechstyle.errors import SimulationFailed


@pytest.mark.parametrize("command", ["run", "freestyle", "simulate"])
@pytest.mark.parametrize("as_json", [False, True])
def test_walls_too_thin_are_warned_of_before_the_minutes_of_meshing(command, as_json, tmp_path, monkeypatch, capsys):
    """… but not where nothing but JSON is wanted."""

    def never(*_: object) -> None:
        raise SimulationFailed("meshed too soon, or at all")

    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path / "cache"))
    for name in ("undeformed_mesh", "mesh_for_relief"):
        monkeypatch.setattr(f"mechstyle.simulation.part.{name}", never)
    style = () if command == "simulate" else ("--prompt", "brick")
    words = [command, "gallery:pen_holder", *style, "--vertices", "1500", "--minimum-wall", "5", "--out", str(tmp_path / "part")]
    with pytest.raises(SystemExit):
        app([*words, *(["--json"] if as_json else [])])
    said = " ".join(capsys.readouterr().err.split())
    before, _, after = said.partition("thinner than the 5 mm minimum: it may not print")
    assert ("warning: the part itself has a wall of" in before) is not as_json
    assert ("error: meshed too soon, or at all" in after) is not as_json


def test_walls_too_thin_are_logged_before_the_minutes_of_meshing_where_python_asks(tmp_path, monkeypatch, caplog):
    """A program learned of them from the notes of the finished run."""

    def never(*_: object) -> None:
        raise SimulationFailed("meshed too soon, or at all")

    monkeypatch.setenv("MECHSTYLE_CACHE", str(tmp_path / "cache"))
    for name in ("undeformed_mesh", "mesh_for_relief"):
        monkeypatch.setattr(f"mechstyle.simulation.part.{name}", never)
    part = ms.load("gallery:pen_holder")
    with pytest.raises(SimulationFailed, match="meshed too soon"):
        ms.stylize(part, "brick", vertices=1500, minimum_wall=5.0, out=tmp_path / "run", device="cpu")
    assert ["thinner than the 5 mm minimum: it may not print" in one.getMessage() for one in caplog.records] == [True]


def test_a_warning_is_given_once_however_often_a_part_is_prepared(capsys):
    with progress_shown(3, quiet=False) as teller:
        teller.warn(["a wall is thin [1]"])
        teller.warn(["a wall is thin [1]", "so is another"])
    assert capsys.readouterr().err.count("warning: a wall is thin [1]") == 1
