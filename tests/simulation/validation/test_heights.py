"""The critical drop height against drops from other heights: too large a height is the unsafe side."""

import pytest

from mechstyle.simulation.validation import heights
from mechstyle.simulation.validation.meshes import bracket
from support.cases import held, quick


@pytest.mark.parametrize("name", quick(heights))
def test_the_simulation_holds(name, monkeypatch):
    """Of one body in half as many cells; `mechstyle validate` drops two of them."""
    monkeypatch.setattr(heights, "_bodies", lambda: {"bracket": bracket(20.0, 8.0, 4.0, 4.0)})
    held(name)
