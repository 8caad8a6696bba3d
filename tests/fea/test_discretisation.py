"""Numbering, masses and what is refused."""

import numpy as np
import pytest
from scipy.sparse import diags_array
from scipy.sparse.linalg import eigsh

from mechstyle.errors import BadInput
from mechstyle.fea.discretisation import Relative, bound, discretise
from mechstyle.fea.elasticity import lumped_masses, stiffness_matrix
from mechstyle.fea.elements import ELEMENTS, LINEAR, QUADRATIC
from mechstyle.fea.explicit import damped_step
from mechstyle.records.mesh import TetMesh

each_element = pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)


@pytest.fixture(scope="module")
def sliver(block) -> TetMesh:
    """The block with an inner vertex moved until one of its tetrahedra is almost flat."""
    inner = np.setdiff1d(np.arange(len(block.vertices)), block.boundary_faces)[0]
    around = block.tets[(block.tets == inner).any(axis=1)][0]
    target = block.vertices[around[around != inner]].mean(axis=0)
    vertices = block.vertices.copy()
    vertices[inner] += 0.98 * (target - vertices[inner])
    mesh = block.moved(vertices)
    assert mesh.volumes.min() > 0
    return mesh


@each_element
def test_orders_lead_back_to_the_callers_numbering(element, block, pla):
    body = discretise(block, pla, 0.0, element)
    np.testing.assert_array_equal(body.mesh.nodes[: len(block.vertices)], block.vertices[body.vertices])
    np.testing.assert_array_equal(body.positions[body.place], body.mesh.nodes)
    np.testing.assert_array_equal(body.place[body.mesh.connectivity][body.tet_order], body.connectivity)
    np.testing.assert_array_equal(body.positions[body.connectivity[:, :4]], block.vertices[block.tets[body.tet_order]])


@each_element
def test_nodes_that_share_an_element_lie_close_in_memory(element, block, pla):
    body = discretise(block, pla, 0.0, element)
    spread = np.ptp(body.connectivity, axis=1)
    assert spread.max() < 0.5 * len(body.masses)
    assert (np.diff(body.connectivity.min(axis=1)) >= 0).all()


@each_element
def test_every_share_of_a_force_has_a_slot_and_those_of_a_node_follow_each_other(element, block, pla):
    body = discretise(block, pla, 0.0, element)
    assert sorted(body.slots.ravel()) == list(range(element.nodes * len(block.tets)))
    tet_of_slot = np.argsort(body.slots.ravel()) // element.nodes
    for node in range(0, len(body.masses), 17):
        mine = slice(body.first_slot[node], body.first_slot[node + 1])
        assert (np.diff(tet_of_slot[mine]) > 0).all()
        assert (body.connectivity[tet_of_slot[mine]] == node).sum() == mine.stop - mine.start


@each_element
def test_unused_vertices_are_left_out(element, block, pla):
    crowded = TetMesh(np.vstack([[[99.0, 99.0, -99.0]], block.vertices]), block.tets + 1)
    body, plain = discretise(crowded, pla, 0.0, element), discretise(block, pla, 0.0, element)
    assert len(body.masses) == len(plain.masses)
    np.testing.assert_array_equal(body.vertices, plain.vertices + 1)


def test_mass_goes_where_it_lengthens_the_step_and_the_allowance_is_used_up(sliver, pla):
    plain, body = (discretise(sliver, pla, share, LINEAR) for share in (0.0, 0.005))
    assert body.masses.sum() / plain.masses.sum() - 1.0 == pytest.approx(0.005, rel=1e-9) == pytest.approx(body.added_mass, rel=1e-9)
    of_the_sliver = body.connectivity[np.argmin(body.volumes)]
    assert set(np.flatnonzero(body.masses > plain.masses)) & set(of_the_sliver)
    steps = [damped_step(one, 0.0)[0] for one in (plain, body)]
    assert steps[1] > 1.25 * steps[0]


def test_slivers_of_a_print_get_as_heavy_as_in_the_solid(sliver, pla):
    """They lie in its walls: else a print, being lighter, had a shorter step."""
    worst = sliver.tets[np.argmin(sliver.volumes)]
    wall = np.isin(sliver.tets, sliver.tets[np.isin(sliver.tets, worst).any(axis=1)]).any(axis=1)[:, None] | np.zeros(4, bool)
    relative = Relative(*(np.where(wall, 1.0, of) for of in (0.15, 0.05, 0.05)))
    solid, printed = (discretise(sliver, pla, 0.003, QUADRATIC, each) for each in (None, relative))
    assert printed.masses.sum() < 0.9 * solid.masses.sum()
    assert damped_step(printed, 0.1)[0] == pytest.approx(damped_step(solid, 0.1)[0], rel=0.01)


@each_element
def test_no_allowance_means_true_masses(element, sliver, pla):
    body = discretise(sliver, pla, 0.0, element)
    np.testing.assert_array_equal(body.masses[body.place], lumped_masses(body.mesh, pla.density * body.mesh.tets.volumes))
    assert body.added_mass == 0.0
    assert body.masses.sum() == pytest.approx(pla.density * sliver.volumes.sum())


@each_element
def test_masses_prove_the_bound_of_the_highest_frequency(element, sliver, pla):
    """Against the eigenvalues of the reference's matrices."""
    body = discretise(sliver, pla, 0.005, element)
    masses = np.repeat(body.masses[body.place], 3)
    highest = eigsh(stiffness_matrix(body.mesh, pla), k=1, M=diags_array(masses).tocsc(), return_eigenvectors=False)[0]
    limit = bound(body.stiffness.norms, body.masses, body.highest)
    assert highest <= limit < 1.6 * highest
    assert body.frequencies.max() <= np.sqrt(limit) * (1.0 + 1e-9)


def test_unusable_tetrahedra_are_refused_with_a_reason(block, pla):
    with pytest.raises(BadInput, match="no tetrahedra"):
        discretise(TetMesh(block.vertices, np.empty((0, 4))), pla, 0.0)
    with pytest.raises(BadInput, match=r"1 tetrahedra have no positive volume, the first at \("):
        discretise(TetMesh(block.vertices, np.vstack([block.tets, block.tets[:1, [0, 2, 1, 3]]])), pla, 0.0)
    broken = block.vertices.copy()
    broken[3, 1] = np.nan
    with pytest.raises(BadInput, match="1 vertices of the tetrahedra are not finite"):
        discretise(block.moved(broken), pla, 0.0)
