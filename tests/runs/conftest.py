"""Parts whose walls are known, without tetrahedra that fill them: recipes and stylizers look at none."""

import numpy as np
import pytest

from mechstyle.records.mesh import TetMesh
from mechstyle.simulation.part import Workpiece


@pytest.fixture
def part(cube):
    """The recipe takes digests from it and nothing else, so these tetrahedra need not fill it."""
    tets = TetMesh(np.vstack([np.zeros(3), 10.0 * np.eye(3)]), [[0, 1, 2, 3]])
    return Workpiece(cube, tets, thickness=np.full(8, 10.0, np.float32), stands=True)


@pytest.fixture(scope="module")
def ball(sphere):
    tets = TetMesh(np.vstack([np.zeros(3), 10.0 * np.eye(3)]), [[0, 1, 2, 3]])
    return Workpiece(sphere, tets, thickness=np.full(len(sphere.vertices), 20.0, np.float32), stands=False)
