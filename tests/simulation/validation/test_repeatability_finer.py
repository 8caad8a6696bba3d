"""Contact over a plane on finer meshes."""

import pytest

from mechstyle.simulation.validation import repeatability
from support.cases import held, quick


@pytest.mark.parametrize("name", quick(repeatability))
def test_the_simulation_holds(name):
    held(name)
