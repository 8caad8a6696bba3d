"""Prints with walls and infill, against theory and against infill that is meshed."""

import numpy as np
import pytest

from support.cases import held, quick
from validation import infill


@pytest.mark.parametrize("name", quick(infill))
def test_the_simulation_holds(name):
    held(name)


def test_lines_fill_the_share_of_a_grid():
    """15 % of the inside, walls and skins apart; a whole number of lines is a little more or less."""
    tets = infill.line_by_line((48.0, 48.0, 16.0))
    core = (48.0 - 4.0 * infill.LINE) ** 2 * 14.4
    inside = tets.volumes.sum() - (48.0**2 * 16.0 - core)
    assert inside / core == pytest.approx(0.15, abs=0.02)
    assert np.all(tets.volumes > 0.0)


def test_a_full_cell_is_as_stiff_as_its_solid():
    assert infill.cell_stiffness(infill.gyroid_sheet(6, 1.0)) == pytest.approx(1.0, rel=1e-3)
