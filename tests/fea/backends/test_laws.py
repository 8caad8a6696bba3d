"""`mechstyle.fea.backends.laws`, one tetrahedron at a time, against the laws that are written to be read."""

import numpy as np
import pytest

from mechstyle._warp import wp
from mechstyle.fea.backends.kernels import linear_forces
from mechstyle.fea.backends.sampling_kernels import PEAK, STRAIN, sample_elements
from mechstyle.fea.elasticity import LAWS, equivalent_stress, law_named
from mechstyle.fea.explicit import ELASTIC, QUANTITIES, law_number, limits
from support import hyperelasticity

MANY = 24
NO_SHARES = wp.zeros(0, dtype=float, device="cpu")
NO_FLOW = wp.zeros((0, 0, 0, 0), dtype=float, device="cpu")
NODES = np.array([[0, 1, 2, 3]], np.int32)
each_law = pytest.mark.parametrize("name", LAWS)


@pytest.fixture(scope="module", params=[1e-3, 0.1, 0.6], ids=["small", "large", "inverting"])
def gradients(request):
    """Displacement gradients, shape [MANY, 3, 3]; the largest turn some of the tetrahedra inside out."""
    found = request.param * np.random.default_rng(0).uniform(-1.0, 1.0, (MANY, 3, 3))
    if request.param > 0.5:
        found[0] = np.diag([-1.3, 0.0, 0.0])
        assert (np.linalg.det(np.eye(3) + found) < 0.0).any()
    return found


def moved(gradients):
    """Displacements of the corners 0, e_1, e_2, e_3 with these gradients, shape [4, MANY, 3]."""
    return np.concatenate([np.zeros((1, MANY, 3)), gradients.transpose(2, 0, 1)]).astype(np.float32)


def on_cpu(values, dtype=float):
    return wp.array(np.ascontiguousarray(values), dtype=dtype, device="cpu")


LIMITS = on_cpu(limits(ELASTIC, 0.0, None)[None, None], wp.vec3f)


def body():
    return [on_cpu(NODES, int), on_cpu(np.eye(3, dtype=np.float32)[None], wp.mat33f), on_cpu(np.array([[1.0 / 6.0]], np.float32))]


@each_law
@pytest.mark.parametrize("across", [(0.0, 0.0, 0.0), (0.6, -1.0, 1.5)], ids=["solid", "layers"])
def test_energy_and_stress_are_those_of_the_reference(gradients, name, across, pla):
    law, u = law_named(name, pla), on_cpu(moved(gradients), wp.vec3f)
    parts = wp.zeros((len(QUANTITIES), 1, MANY), dtype=float, device="cpu")
    asked = [*body(), law_number(law), law.mu, law.la, wp.vec3f(*across), LIMITS, 0.0, u, wp.zeros_like(u), NO_SHARES, NO_FLOW, parts]
    wp.launch(sample_elements, dim=(1, MANY), inputs=asked, device="cpu")
    energy = hyperelasticity.energy_density(law, gradients) / 6.0
    stress = equivalent_stress(hyperelasticity.cauchy_stress(gradients, hyperelasticity.first_piola(law, gradients)), across)
    found = parts.numpy()[:, 0]
    np.testing.assert_allclose(found[STRAIN], energy, rtol=2e-5, atol=2e-6 * np.abs(energy).max())
    # Stress divides by J, which is near nothing in a few: float32 keeps six digits of the sums before.
    volume_left = np.abs(np.linalg.det(np.eye(3) + gradients))
    np.testing.assert_allclose(np.sqrt(found[PEAK]) * volume_left, stress * volume_left, rtol=1e-3, atol=1e-5 * stress.max())


@each_law
def test_forces_are_those_of_the_first_piola_stress(gradients, name, pla):
    law, u = law_named(name, pla), on_cpu(moved(gradients), wp.vec3f)
    forces, peak = wp.zeros((4, MANY), dtype=wp.vec3f, device="cpu"), wp.zeros((1, 1, MANY), dtype=float, device="cpu")
    damping = on_cpu(np.zeros(1, np.float32))
    constants = [law_number(law), law.mu, law.la, wp.vec3f(), LIMITS]
    asked = [*body(), on_cpu(NODES, int), damping, u, wp.zeros_like(u), *constants, 0, forces, damping, NO_FLOW, peak]
    wp.launch(linear_forces, dim=(1, MANY), inputs=asked, device="cpu")
    stress = hyperelasticity.first_piola(law, gradients)
    expected = np.concatenate([stress.sum(axis=2)[None], -stress.transpose(2, 0, 1)]) / 6.0
    np.testing.assert_allclose(forces.numpy(), expected, rtol=0, atol=3e-6 * np.abs(expected).max())
    assert not peak.numpy().any(), "nothing is recorded unless it is asked for"
