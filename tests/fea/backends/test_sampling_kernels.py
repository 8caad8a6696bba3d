"""Samples of a body with more nodes and elements than there are partial sums: nothing is left out, nothing counted twice."""

import numpy as np
import pytest

from mechstyle._warp import wp
from mechstyle.fea.backends import sampling_kernels as k
from mechstyle.fea.explicit import ELASTIC, QUANTITIES, limits

COUNT = 2 * int(k.PARTS) + 77
NORMALS = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]], np.float32)


def on_cpu(values, dtype=float):
    return wp.array(np.ascontiguousarray(values, np.float32), dtype=dtype, device="cpu")


@pytest.fixture(scope="module")
def state():
    """Masses, arms, displacements, velocities, impulses and losses of COUNT nodes of two drops, all different."""
    rng = np.random.default_rng(1)
    masses, arms = rng.uniform(0.5, 1.5, COUNT), rng.normal(size=(COUNT, 3))
    u, v = (rng.normal(0.3, 1.0, (COUNT, 2, 3)) for _ in range(2))
    impulse, lost = (rng.uniform(0.0, 1.0, (COUNT, 2)) for _ in range(2))
    return masses, arms, u, v, impulse, lost


@pytest.fixture(scope="module")
def totals(state):
    """What the kernels add up to, shape [quantities, 2]."""
    masses, arms, u, v, impulse, lost = state
    parts = wp.zeros((len(QUANTITIES), int(k.PARTS), 2), dtype=float, device="cpu")
    moving = [on_cpu(u, wp.vec3f), on_cpu(v, wp.vec3f)]
    nodes = [on_cpu(masses), on_cpu(NORMALS, wp.vec3f), *moving, on_cpu(impulse), on_cpu(lost), parts]
    wp.launch(k.sample_nodes, (int(k.PARTS), 2), nodes, device="cpu")
    wp.launch(k.sample_motion, (int(k.PARTS), 2), [on_cpu(masses), on_cpu(arms, wp.vec3f), *moving, parts], device="cpu")
    values = parts.numpy()
    values[k.PEAK] = np.random.default_rng(2).permutation(2 * int(k.PARTS)).reshape(int(k.PARTS), 2)
    groups = wp.zeros((len(QUANTITIES), int(k.GROUPS), 2), dtype=float, device="cpu")
    samples = wp.zeros((3, len(QUANTITIES), 2), dtype=float, device="cpu")
    wp.launch(k.sample_groups, groups.shape, [on_cpu(values), groups], device="cpu")
    wp.launch(k.sample_total, (len(QUANTITIES), 2), [groups, wp.array([1], dtype=int, device="cpu"), samples], device="cpu")
    rows = samples.numpy()
    assert not rows[[0, 2]].any(), "only the current row is written"
    return rows[1], values


def test_sums_over_nodes_are_those_of_numpy(state, totals):
    masses, _, u, v, impulse, lost = state
    found, _ = totals
    weighed = masses[:, None, None]
    expected = {
        k.KINETIC: (0.5 * weighed * v**2).sum(axis=(0, 2)),
        k.IMPULSE: impulse.sum(axis=0),
        k.CONTACT_LOSS: lost.sum(axis=0),
        k.HEIGHT: np.einsum("nbk,bk->b", weighed * u, NORMALS),
        k.MOMENTUM: np.einsum("nbk,bk->b", weighed * v, NORMALS),
    }
    for quantity, wanted in expected.items():
        np.testing.assert_allclose(found[quantity], wanted, rtol=2e-5)


def test_the_motion_as_a_whole_is_that_of_numpy(state, totals):
    masses, arms, u, v, *_ = state
    weighed = masses[:, None, None]
    turn = np.einsum("nbi,nj->ijb", weighed * u, arms).reshape(9, 2)
    spin = (weighed * np.cross(arms[:, None] + u, v)).sum(axis=0).T
    expected = np.concatenate([(weighed * u).sum(axis=0).T, (weighed * v).sum(axis=0).T, spin, turn])
    np.testing.assert_allclose(totals[0][k.MOTION :], expected, atol=2e-5 * COUNT)


def test_of_stresses_the_largest_counts_and_not_the_sum(totals):
    found, values = totals
    assert np.array_equal(found[k.PEAK], values[k.PEAK].max(axis=0))


def test_strain_of_every_element_counts_once(pla):
    """Equal tetrahedra under one gradient: as many energies as there are of them."""
    mu = float(pla.youngs_modulus / 2.6)
    nodes = np.tile(np.arange(4, dtype=np.int32), (COUNT, 1))
    gradients, volumes = np.tile(np.eye(3), (COUNT, 1, 1)), np.ones(COUNT)
    u = on_cpu(1e-2 * np.array([[(0, 0, 0)], [(1, 0, 0)], [(0, 0, 0)], [(0, 0, 0)]], float), wp.vec3f)
    parts = wp.zeros((len(QUANTITIES), int(k.PARTS), 1), dtype=float, device="cpu")
    body = [wp.array(nodes, dtype=int, device="cpu"), on_cpu(gradients, wp.mat33f), on_cpu(volumes[:, None], float)]
    no_flow = wp.zeros((0, 0, 0, 0), dtype=float, device="cpu")
    bounds = on_cpu(np.tile(limits(ELASTIC, 0.0, None), (len(volumes), 1, 1)), wp.vec3f)
    asked = [*body, 0, mu, mu, wp.vec3f(), bounds, 0.0, u, wp.zeros_like(u), wp.zeros(0, dtype=float, device="cpu"), no_flow, parts]
    wp.launch(k.sample_elements, (int(k.PARTS), 1), asked, device="cpu")
    strain = 1e-2 + 0.5e-4  # Green's, of a stretch by 1 %
    assert parts.numpy()[k.STRAIN].sum() == pytest.approx(COUNT * 1.5 * mu * strain**2, rel=1e-4)
