"""Tables as they are printed on a narrow terminal."""

import io

import pytest
from rich.console import Console

from mechstyle.cli import run
from mechstyle.cli.console import table
from mechstyle.study import applications

ROWS = {
    applications.COLUMNS: ("MechStyle", "VIABLE", "27.1", "45.6", "1.68", "0.99 x", "3", "82%"),
    run.COLUMNS: ("original", "VIABLE, MARGINAL", "38.6", "45.6", "44.7", "45.6", "1.07 x", "1.02", "117.7", "97%"),
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
