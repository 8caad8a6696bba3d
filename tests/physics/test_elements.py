"""Quadratic tetrahedra: nodes in the middle of the edges, shape functions that reproduce every quadratic field."""

import itertools

import numpy as np
import pytest

from mechstyle.fea.elements import EDGES, GAUSS_POINTS, quadratic_nodes, shape_functions, shape_slopes


@pytest.fixture(scope="module")
def points():
    """Barycentric coordinates of points inside a tetrahedron."""
    return np.random.default_rng(0).dirichlet(np.ones(4), 20)


def quadratic(x):
    return 1.0 + x @ [1.0, -2.0, 0.5] + x[:, 0] * x[:, 1] - 3.0 * x[:, 2] ** 2 + x[:, 1] * x[:, 2]


def test_the_corners_come_first_and_every_middle_is_midway(block):
    nodes, elements = quadratic_nodes(block)
    assert np.array_equal(nodes[: len(block.vertices)], block.vertices)
    assert np.array_equal(elements[:, :4], block.tets)
    assert elements.dtype == np.int32
    middles = 0.5 * (nodes[elements[:, EDGES[:, 0]]] + nodes[elements[:, EDGES[:, 1]]])
    assert nodes[elements[:, 4:]] == pytest.approx(middles, abs=1e-12)


def test_an_edge_has_one_middle_however_many_elements_share_it(block):
    nodes, elements = quadratic_nodes(block)
    edges = {tuple(sorted(pair)) for tet in block.tets.tolist() for pair in itertools.combinations(tet, 2)}
    assert len(nodes) == len(block.vertices) + len(edges)
    assert np.array_equal(np.unique(elements), np.arange(len(nodes)))


def test_shape_functions_are_one_at_their_node_and_zero_at_the_others():
    corners = np.eye(4)
    assert shape_functions(np.concatenate([corners, corners[EDGES].mean(axis=1)])) == pytest.approx(np.eye(10))


def test_shape_functions_reproduce_a_quadratic_field_exactly(block, points):
    nodes, elements = quadratic_nodes(block)
    tet = elements[17]
    assert shape_functions(points) @ quadratic(nodes[tet]) == pytest.approx(quadratic(points @ nodes[tet[:4]]), rel=1e-12)


def test_slopes_are_the_derivatives_of_the_shape_functions(points):
    step = 1e-6
    for k in range(4):
        ahead, behind = (shape_functions(points + sign * step * np.eye(4)[k]) for sign in (1.0, -1.0))
        assert shape_slopes(points)[:, :, k] == pytest.approx((ahead - behind) / (2.0 * step), abs=1e-8)


def test_gauss_points_integrate_quadratics_exactly():
    """∫ L_i L_j dV = V/20 for i ≠ j, V/10 for i = j; ∫ L_i dV = V/4 (Zienkiewicz and Taylor, §8.8.2)."""
    assert GAUSS_POINTS.mean(axis=0) == pytest.approx(np.full(4, 0.25))
    products = GAUSS_POINTS.T @ GAUSS_POINTS / 4.0
    assert products == pytest.approx((np.ones((4, 4)) + np.eye(4)) / 20.0)
