"""Tables as they are printed on a narrow terminal."""

import io

import pytest
from rich.console import Console

from mechstyle.cli.console import table
from mechstyle.study.applications import COLUMNS


@pytest.mark.parametrize("width", [80, 100])
def test_no_word_of_a_heading_is_broken(width):
    rows = table(*COLUMNS, width=width)
    rows.add_row("MechStyle", "VIABLE", "27.1", "45.6", "1.68", "0.99 x", "3", "82%")
    page = io.StringIO()
    Console(file=page, width=width).print(rows)
    words = page.getvalue().split()
    assert all(word in words for column in COLUMNS for word in column.split())
    assert max(map(len, page.getvalue().splitlines())) <= width
