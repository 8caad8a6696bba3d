"""Tetrahedra in blocks of lanes: however many there are, each pushes its own nodes and no others."""

import numpy as np
import pytest

from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.backends.simd_by_element import LANES
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.elasticity import law_named
from mechstyle.fea.elements import ELEMENTS
from mechstyle.records.mesh import TetMesh
from support import hyperelasticity


def strip(count: int) -> TetMesh:
    """Some tetrahedra in a row, neighbours joined by a face, each of another shape."""
    steps = np.arange(count + 3)
    spread = np.random.default_rng(3).uniform(-0.1, 0.1, (count + 3, 3))
    vertices = np.stack([np.cos(2.3 * steps), np.sin(2.3 * steps), 0.7 * steps], axis=1) + spread
    tets = np.arange(count)[:, None] + np.arange(4)
    upright = TetMesh(vertices, tets).volumes > 0.0
    return TetMesh(vertices, np.where(upright[:, None], tets, tets[:, [0, 2, 1, 3]]))


@pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)
@pytest.mark.parametrize("count", [1, LANES - 1, LANES, LANES + 1, 3 * LANES + 5])
def test_forces_are_those_of_the_reference_however_full_the_last_block_is(count, element, pla):
    body, law = discretise(strip(count), pla, 0.0, element), law_named("stable_neo_hookean", pla)
    u = 0.2 * np.random.default_rng(4).standard_normal(body.positions.shape)
    expected = np.empty_like(u)
    expected[body.place] = hyperelasticity.internal_forces(body.mesh, law, u[body.place])
    found = CoreBody(body).internal_forces(law, u)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5 * np.abs(expected).max())
