"""`--amplitude auto`: the deepest relief that holds, and what is told of it."""

import json

import pytest
from typer.testing import CliRunner

from cli.conftest import BOX, SMALL
from mechstyle.cli.app import app
from mechstyle.errors import BadInput
from mechstyle.runs import deepest


def test_what_limits_the_relief_is_among_what_a_run_tells(monkeypatch, tmp_path):
    """With --json nothing else said it."""
    monkeypatch.setattr(deepest, "deepest", lambda *_, **__: deepest.Depth(0.25, "0.25 of the wall is the deepest relief that holds"))
    asked = ["run", str(BOX), "-p", "brick", *SMALL, "--amplitude", "auto", "--json"]
    outcome = CliRunner().invoke(app, [*asked, "--out", str(tmp_path / "run")])
    assert "amplitude auto: 0.25 of the wall is the deepest relief that holds" in json.loads(outcome.stdout)["notes"]


@pytest.mark.parametrize(("command", "base", "control"), [("freestyle", "free", "none"), ("run", "plain", "exponential")])
def test_depths_are_tried_as_the_command_styles_the_part(monkeypatch, command, base, control):
    """Freestyle's trials stood on a level base, which its part does not."""

    def tried(_mesh, **settings):
        recipe = deepest.draft(**{name: value for name, value in settings.items() if name in ("prompt", "base", "control")})
        raise BadInput(f"tried with base {recipe.restraint.base} and control {recipe.restraint.control}")

    monkeypatch.setattr(deepest, "deepest", tried)
    outcome = CliRunner().invoke(app, [command, "gallery:drawer_knob", "-p", "brick", "--amplitude", "auto"])
    assert f"tried with base {base} and control {control}" in " ".join(outcome.output.split())
