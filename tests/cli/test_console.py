"""Tables as they are printed on a narrow terminal, and the headings of the help."""

import io

import pytest
from rich.console import Console
from typer.main import get_command
from typer.testing import CliRunner

from mechstyle.cli import console
from mechstyle.cli.app import PANELS, app
from mechstyle.cli.console import COLOURS, report_verdict, table, verdict_text
from mechstyle.cli.console import out as stdout
from mechstyle.records import Doubt, sentences
from support.records import UNKNOWN, row, verdict

ROWS = {
    sentences.COLUMNS: ("tilted 3° to the left front", "0.22 mm", "0.25 mm", "0.27 mm", "1.4%", "NO WORSE (not sure)"),
    ("test", "plain", "Freestyle", "MechStyle", "allowed"): ("flat", "0.22 mm", "1.20 mm, cracks FAILS", "0.25 mm NO WORSE", "0.27 mm"),
}


@pytest.mark.parametrize("width", [40, 60, 80, 100, 120])
@pytest.mark.parametrize("columns", ROWS)
def test_no_word_of_a_table_is_broken(columns, width):
    rows = table(*columns, width=width)
    rows.add_row(*ROWS[columns])
    page = io.StringIO()
    Console(file=page, width=width).print(rows)
    words = page.getvalue().split()
    assert all(word in words for cell in (*columns, *ROWS[columns]) for word in cell.split())
    assert max(map(len, page.getvalue().splitlines())) <= width


@pytest.mark.parametrize("width", [20, 120])
def test_units_stand_in_the_headings_of_a_table(width):
    rows = table("density [g/mm³]", "name [/red]", width=width)
    rows.add_row("0.00124", "PLA")
    page = io.StringIO()
    Console(file=page, width=width).print(rows)
    assert {"density", "[g/mm³]", "[/red]"} <= set(page.getvalue().split())


@pytest.mark.parametrize(("width", "whole"), [(80, True), (40, False)])
def test_headings_stand_in_one_line_where_the_table_fits(width, whole):
    rows = table(*sentences.COLUMNS[:1], "stays bent", *sentences.COLUMNS[3:], width=width)
    rows.add_row("nearly flat, worst of 6", "0.04 mm", "0.20 mm", "1.1%", "HOLDS")
    page = io.StringIO()
    Console(file=page, width=width).print(rows)
    assert ("stays bent" in page.getvalue()) is whole


def printed(judged):
    with stdout.capture() as said:
        report_verdict(judged)
    return " ".join(said.get().split())


def test_a_verdict_is_its_head_its_table_and_its_doubt():
    doubt = Doubt(about="limit", value=1.01, test="nearly flat", landing="tilted")
    nearly = row(0.27, test="nearly flat", landing="tilted", outcome="NO WORSE", plain_permanent_set=0.23, allowed=0.28)
    judged = verdict(row(0.06), nearly, doubts=(doubt,))
    said = printed(judged)
    assert said.startswith(judged.head)
    assert said.endswith(judged.doubt)
    assert "test plain styled allowed strain outcome flat 0 mm 0.06 mm 0.20 mm 0.0% HOLDS" in said
    assert "tilted 0.23 mm 0.27 mm 0.28 mm 0.0% NO WORSE (not sure)" in said


def test_each_kind_of_landing_has_one_row_its_worst_and_details_have_all():
    tilts = [row(bend, test="nearly flat", landing=f"tilted {bend}") for bend in (0.06, 0.31, 0.12)]
    judged = verdict(row(0.05), *tilts, row(0.01, test="load", load="hand"), row(0.02, test="load", load="foot"))
    said = printed(judged)
    assert "nearly flat, worst of 3 0 mm 0.31 mm" in said
    assert all(one in said for one in ("flat 0 mm 0.05 mm", "load hand", "load foot"))
    assert "tilted 0.06" not in said
    with stdout.capture() as whole:
        report_verdict(judged, details=True)
    assert all(one.landing in whole.get() for one in tilts)


def test_a_part_that_is_tested_by_itself_has_one_column_of_figures():
    said = printed(verdict(row(0.06, plain_permanent_set=None)))
    assert "allowed strain outcome flat 0.06 mm 0.20 mm 0.0% HOLDS" in said
    assert "plain" not in said


def test_what_gave_no_answer_has_no_table():
    assert printed(UNKNOWN) == "UNKNOWN: the integration blew up."


def test_every_outcome_has_a_colour_of_its_own_and_a_doubt_that_of_unknown():
    assert set(COLOURS) == set(sentences.MEANINGS)
    assert len(set(COLOURS.values())) == len(COLOURS)
    assert verdict_text("HOLDS", sure=False) == "[bold green]HOLDS[/][yellow] (not sure)[/]"
    assert verdict_text("UNKNOWN", sure=False) == "[bold yellow]UNKNOWN[/]"


def test_what_was_said_of_a_stage_is_not_taken_back_when_its_next_drop_begins(capsys):
    """41 %, then 3 %: each landing that was dropped by itself, and each tetrahedron that was asked whether to go on, began anew."""
    with console.progress_shown(30, quiet=False) as teller:
        teller.stage("drop test at 20")
        for done in (0.2, 0.41, 0.0, 0.03):
            teller.fraction(done)
        teller.line()
        teller.stage("drop test at 30")
        teller.fraction(0.1)
        teller.line()
    first, second = (line for line in capsys.readouterr().err.splitlines() if "drop test" in line)
    assert "drop test at 20  41%" in first
    assert "drop test at 30  10%" in second


def test_where_no_bar_is_shown_each_stage_has_a_line_and_a_long_one_a_line_a_minute(capsys):
    answers = iter([False] * 8 + [True])
    waited = []

    def over(seconds):
        waited.append(seconds)
        return next(answers)

    with console.progress_shown(30, quiet=False) as teller:
        teller.stage("filling it with tetrahedra")
        console.lines(teller.line, over)
    assert waited == [10.0] * 9
    assert capsys.readouterr().err.count("s: filling it with tetrahedra, 0 of 30") == 2


def test_nothing_is_said_where_figures_are_asked_for(capsys):
    with console.progress_shown(30, quiet=True) as teller:
        teller.stage("filling it with tetrahedra")
        teller.line()
    assert capsys.readouterr().err == ""


def test_every_command_has_one_heading_in_the_help():
    assert sorted(name for names in PANELS.values() for name in names) == sorted(get_command(app).commands)
    shown = CliRunner().invoke(app, ["--help"]).stdout
    assert [shown.index(panel) for panel in PANELS] == sorted(shown.index(panel) for panel in PANELS)
