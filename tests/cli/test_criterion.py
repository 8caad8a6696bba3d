"""What the command line says of the criterion in force."""

import pytest
from typer.testing import CliRunner

from mechstyle.cli import run as commands
from mechstyle.cli.app import app
from mechstyle.cli.console import out
from mechstyle.cli.run import report
from mechstyle.errors import BadInput


@pytest.mark.parametrize(
    ("criterion", "shown"), [("robust", "HOLDS a fall of 1.5 m: "), ("paper", "by the published rule: the largest element stress")]
)
def test_the_published_rule_is_judged_only_where_it_decides(sheet, criterion, shown):
    with out.capture() as said:
        report(sheet(criterion=criterion), as_json=False)
    words = " ".join(said.get().split())
    assert shown in words
    assert ("published rule" in words) is (criterion == "paper")


def test_what_the_published_method_leaves_is_said_before_anything_slow(monkeypatch):
    def no_further(*_, **__):
        raise BadInput("no further")

    monkeypatch.setattr(commands, "read_model", no_further)
    outcome = CliRunner().invoke(app, ["run", "gallery:drawer_knob", "-p", "brick", "--criterion", "paper"])
    assert "29 % was kept once" in " ".join(outcome.output.split())
