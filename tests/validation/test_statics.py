"""Elements at rest: what must hold exactly, and the same matrices in CalculiX."""

import pytest

from support.cases import held, quick
from validation import statics


@pytest.mark.parametrize("name", quick(statics))
def test_the_simulation_holds(name):
    held(name)
