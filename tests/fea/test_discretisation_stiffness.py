"""Tests for the stiffness by blocks."""

import numpy as np
import pytest

from mechstyle.fea.discretisation import discretise, spectral_norms
from mechstyle.fea.elements import ELEMENTS

RANDOM = np.random.default_rng(0).normal(size=(500, 3, 3))
MATRICES = {
    "any": RANDOM,
    "symmetric": RANDOM + RANDOM.swapaxes(1, 2),
    "rank one": RANDOM[:, :, :1] * RANDOM[:, None, 0],
    "rotations": np.linalg.svd(RANDOM)[0],
    "nearly alike": 1e4 * np.eye(3) + 1e-9 * RANDOM,
    "stiff": 1e7 * RANDOM,
    "soft": 1e-7 * RANDOM,
}


@pytest.mark.parametrize("kind", MATRICES)
def test_spectral_norms_are_singular_values_from_above(kind):
    matrices = MATRICES[kind]
    exact = np.linalg.svd(matrices, compute_uv=False)[:, 0]
    found = spectral_norms(matrices.reshape(-1, 9))
    assert (found >= exact).all()
    np.testing.assert_allclose(found, exact, rtol=3e-7)


def test_the_norm_of_nothing_is_nothing():
    np.testing.assert_array_equal(spectral_norms(np.zeros((2, 9))), 0.0)


@pytest.mark.parametrize("element", ELEMENTS)
def test_norms_are_those_of_the_blocks_of_the_stiffness(element, block, pla):
    stiffness = discretise(block, pla, 0.0, ELEMENTS[element]).stiffness
    count = stiffness.pairs.node_count
    blocks = stiffness.matrix().toarray().reshape(count, 3, count, 3).swapaxes(1, 2)
    np.testing.assert_allclose(stiffness.norms.toarray(), np.linalg.norm(blocks, ord=2, axis=(2, 3)), rtol=1e-6, atol=1e-6)
    twice = stiffness.weighted_norms(np.full(len(stiffness.volumes), 2.0))
    np.testing.assert_allclose(twice.toarray(), 2.0 * stiffness.norms.toarray(), rtol=1e-6, atol=1e-6)
