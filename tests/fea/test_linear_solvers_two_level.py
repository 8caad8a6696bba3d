"""The preconditioner against what makes one: linear fields are exact, it is symmetric and positive, and it is near the inverse."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import csr_array

from mechstyle.errors import SimulationFailed
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.elasticity import stiffness_matrix
from mechstyle.fea.elements import LINEAR, QUADRATIC
from mechstyle.fea.linear_solvers import TwoLevel, linear_fields

SHIFT = 1.0  # [N/mm] per unit of the fields' own product: far below what deforms a block costs


@pytest.fixture(scope="module")
def body(box, pla):
    return discretise(box((3, 2, 1), (30.0, 20.0, 8.0)), pla, 0.0, QUADRATIC)


@pytest.fixture(scope="module")
def matrix(body, pla):
    return body.stiffness.matrix()


def test_fields_that_are_linear_in_space_are_among_the_linear_ones(body):
    fields, corners = linear_fields(body.connectivity, len(body.masses)), np.unique(body.connectivity[:, :4])
    slope, start = np.random.default_rng(1).normal(size=(3, 3)), np.array([1.0, -2.0, 3.0])
    wanted = body.positions @ slope + start
    assert np.allclose(fields @ wanted[corners].ravel(), wanted.ravel())


def test_the_stiffness_is_that_of_the_elements(body, matrix, pla):
    """The same as `elasticity.stiffness_matrix`, which is written to be read, in the order of computation."""
    plain = stiffness_matrix(body.mesh, pla).toarray()
    unknowns = (3 * np.argsort(body.place)[:, None] + np.arange(3)).ravel()
    assert np.allclose(matrix.toarray(), plain[np.ix_(unknowns, unknowns)], atol=1e-9 * plain.max())


def test_it_is_symmetric_and_near_the_inverse_of_what_deforms(body, matrix):
    nearly = TwoLevel(matrix, linear_fields(body.connectivity, len(body.masses)), SHIFT)
    size = matrix.shape[0]
    inverse = nearly(np.eye(size))
    assert np.allclose(inverse, inverse.T, atol=1e-4 * np.abs(inverse).max())
    stiff = matrix.toarray()
    values, vectors = np.linalg.eigh(stiff)
    elastic = vectors[:, values > 1e-9 * values[-1]]
    assert elastic.shape[1] == size - 6
    # generalised eigenvalues of A against the inverse of the preconditioner, on what deforms: all near 1
    within = eigh(elastic.T @ stiff @ inverse @ stiff @ elastic, elastic.T @ stiff @ elastic, eigvals_only=True)
    assert within[0] > 0.1
    assert within[-1] < 1.5


def test_for_linear_tetrahedra_it_is_a_solver(box, pla):
    body = discretise(box((3, 2, 1), (30.0, 20.0, 4.0)), pla, 0.0, LINEAR)
    matrix, fields = body.stiffness.matrix(), linear_fields(body.connectivity, len(body.masses))
    right = matrix @ np.random.default_rng(2).normal(size=(matrix.shape[0], 2))
    left_over = right - matrix @ TwoLevel(matrix, fields, 1e-6 * SHIFT)(right)
    assert np.linalg.norm(left_over) < 1e-3 * np.linalg.norm(right)


def test_columns_are_solved_for_by_themselves_whatever_their_size(body, matrix):
    nearly = TwoLevel(matrix, linear_fields(body.connectivity, len(body.masses)), SHIFT)
    right = np.random.default_rng(3).normal(size=(matrix.shape[0], 1))
    both = nearly(np.concatenate([1e-12 * right, 0.0 * right, 1e12 * right], axis=1))
    assert np.allclose(both[:, 0] * 1e12, both[:, 2] * 1e-12, rtol=1e-4)
    assert not both[:, 1].any()


def test_a_matrix_that_is_no_stiffness_is_refused(body, matrix):
    nothing = csr_array((matrix.shape[0], 3))
    with pytest.raises(SimulationFailed, match="could not be factorised"):
        TwoLevel(matrix, nothing, SHIFT)
