"""Bodies that hit the floor, against theory and other arithmetic."""

import pytest

from support.cases import held, quick
from validation import impacts


@pytest.mark.parametrize("name", quick(impacts))
def test_the_simulation_holds(name):
    held(name)


@pytest.mark.slow
def test_the_stress_wave_agrees_with_calculix():
    held("bar_calculix")
