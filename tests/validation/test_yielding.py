"""Bodies that yield, against theory and published figures."""

import pytest

from support.cases import held, quick
from validation import yielding


@pytest.mark.parametrize("name", quick(yielding))
def test_the_simulation_holds(name):
    held(name)


@pytest.mark.slow
def test_a_neck_bears_what_calculix_says():
    held("neck")
