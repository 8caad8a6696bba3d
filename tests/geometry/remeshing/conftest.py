"""What is meshed here is meshed anew, not stored: it is what these tests are about."""

import pytest

from mechstyle.geometry.remeshing.filling import fill
from mechstyle.records.mesh import TetMesh


@pytest.fixture(scope="session")
def cup_tets(cup) -> TetMesh:
    return fill(cup, 3000)
