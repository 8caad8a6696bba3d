"""Load factors against beam theory; details of the part that must count, and those of the mesh that must not."""

import pytest

from support.cases import held, quick
from validation import details


@pytest.mark.parametrize("name", quick(details))
def test_the_simulation_holds(name):
    held(name)
