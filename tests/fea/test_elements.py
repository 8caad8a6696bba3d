"""Shape functions of both tetrahedra: what they interpolate exactly, and that their masses are all there."""

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.fea.elasticity import displacement_gradients
from mechstyle.fea.elements import (
    EDGES,
    ELEMENTS,
    GAUSS_A,
    GAUSS_B,
    OVERSHOOT,
    QUADRATIC,
    at_corners,
    at_vertices,
    element_named,
    with_nodes,
)
from mechstyle.records.mesh import TetMesh
from validation.meshes import box

each_element = pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)
SLOPE = np.random.default_rng(0).uniform(-0.3, 0.3, (3, 3))


@each_element
def test_the_masses_of_the_nodes_are_the_whole_and_none_is_negative(element):
    assert element.mass_shares.sum() == pytest.approx(1.0)
    assert (element.mass_shares > 0.0).all()


@each_element
def test_a_translation_strains_nothing(element, block):
    mesh = with_nodes(block, element)
    assert np.abs(displacement_gradients(mesh, np.tile([1.0, -2.0, 3.0], (len(mesh.nodes), 1)))).max() < 1e-12


@each_element
def test_a_linear_field_has_its_own_gradient_everywhere(element, block):
    mesh = with_nodes(block, element)
    found = displacement_gradients(mesh, mesh.nodes @ SLOPE.T)
    np.testing.assert_allclose(found, np.broadcast_to(SLOPE, found.shape), atol=1e-12)


def test_a_quadratic_field_has_its_own_gradient_at_the_points_of_the_quadratic_element(block):
    """Half of the stress near a clamp hangs on this: a bent plate is a quadratic field."""
    mesh, A = with_nodes(block, QUADRATIC), np.random.default_rng(1).uniform(-0.01, 0.01, (3, 3, 3))
    A = A + A.transpose(0, 2, 1)
    field = 0.5 * np.einsum("kij,ni,nj->nk", A, mesh.nodes, mesh.nodes)
    corners = block.vertices[block.tets]
    weights = np.full((4, 4), GAUSS_B) + (GAUSS_A - GAUSS_B) * np.eye(4)
    places = np.einsum("qi,tik->tqk", weights, corners)
    np.testing.assert_allclose(displacement_gradients(mesh, field), np.einsum("kij,tqi->tqkj", A, places), atol=1e-11)


def test_neighbours_share_the_nodes_in_the_middle_of_their_edges(block):
    mesh = with_nodes(block, QUADRATIC)
    ends = np.sort(block.tets[:, EDGES].reshape(-1, 2), axis=1)
    assert len(mesh.nodes) == len(block.vertices) + len(np.unique(ends, axis=0))
    middles = mesh.nodes[mesh.connectivity[:, 4:]]
    np.testing.assert_allclose(middles, block.vertices[block.tets[:, EDGES]].mean(axis=2))


def test_an_element_nobody_has_is_refused_with_the_nearest():
    assert element_named("tet10") is QUADRATIC
    with pytest.raises(BadInput, match="did you mean 'tet10'"):
        element_named("tet1O")


def test_what_is_linear_in_an_element_is_found_at_its_corners():
    corners = np.array([[5.0, 6.0, 6.0, 5.5], [3.0, 2.5, 3.0, 3.2]])
    at_points = corners @ ((GAUSS_A - GAUSS_B) * np.eye(4) + GAUSS_B)
    np.testing.assert_allclose(at_corners(at_points), corners)
    np.testing.assert_array_equal(at_corners([[7.0], [2.0]]), [[7.0] * 4, [2.0] * 4])


def test_corners_are_kept_between_nothing_and_a_little_more_than_the_largest_point():
    """Of running maxima: each point had its own at another moment."""
    np.testing.assert_allclose(at_corners([10.0, 0.0, 0.0, 0.0]), [10.0 * OVERSHOOT, 0.0, 0.0, 0.0])
    even = np.full((3, 4), 2.0)
    np.testing.assert_allclose(at_corners(even), even)


def test_values_of_a_linear_field_at_gauss_points_are_its_values_at_the_vertices():
    block = box((3, 2, 4), (9.0, 5.0, 12.0))
    nodal = 30.0 + block.vertices @ [1.0, -2.0, 0.5]
    points = nodal[block.tets] @ ((GAUSS_A - GAUSS_B) * np.eye(4) + GAUSS_B)
    assert at_vertices(block, points) == pytest.approx(nodal, rel=1e-12)


def test_a_large_tetrahedron_counts_more_at_a_vertex_it_shares():
    vertices = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -3.0], [9.0, 9.0, 9.0]])
    pair = TetMesh(vertices, np.array([[0, 1, 2, 3], [0, 2, 1, 4]], np.int32))
    assert at_vertices(pair, [[10.0], [50.0]]) == pytest.approx([40.0, 40.0, 40.0, 10.0, 50.0, 0.0])
