"""The element arithmetic of `mechstyle.fea.backends.simd_code` in lanes: sixteen tetrahedra at once, some of them inside out."""

import numpy as np
import pytest

from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.elasticity import LAWS, law_named
from mechstyle.fea.elements import ELEMENTS
from support import hyperelasticity


@pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)
@pytest.mark.parametrize("name", LAWS)
def test_a_tetrahedron_that_is_inside_out_pushes_back_as_in_the_reference_and_spoils_no_other(name, element, box, pla):
    body, law = discretise(box((1, 1, 4), (4.0, 4.0, 16.0)), pla, 0.0, element), law_named(name, pla)
    u = 1e-3 * np.random.default_rng(5).standard_normal(body.positions.shape)
    u[np.argmax(body.positions[:, 2])] -= (0.0, 0.0, 12.0)  # one corner through the body
    moved = body.mesh.tets.moved(body.mesh.tets.vertices + u[body.place][: len(body.mesh.tets.vertices)])
    assert 0 < (moved.volumes < 0.0).sum() < len(moved.volumes)
    expected = np.empty_like(u)
    expected[body.place] = hyperelasticity.internal_forces(body.mesh, law, u[body.place])
    found = CoreBody(body).internal_forces(law, u)
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5 * np.abs(expected).max())
