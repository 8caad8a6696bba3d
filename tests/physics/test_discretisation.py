"""Numbering, masses and what is refused."""

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.fea.discretisation import discretise, sliver_scale
from mechstyle.fea.elasticity import element_frequencies
from mechstyle.mesh import TetMesh


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


def test_orders_lead_back_to_the_callers_numbering(block, pla):
    body = discretise(block, pla, 0.0)
    np.testing.assert_array_equal(body.tets.vertices, block.vertices[body.vertex_order])
    np.testing.assert_array_equal(body.vertex_order[body.tets.tets], block.tets[body.tet_order])


def test_corner_lists_name_every_corner_once_in_ascending_order(block, pla):
    body = discretise(block, pla, 0.0)
    assert sorted(body.corners) == list(range(4 * len(block.tets)))
    for vertex in range(0, len(block.vertices), 17):
        mine = body.corners[body.first_corner[vertex] : body.first_corner[vertex + 1]]
        assert (np.diff(mine) > 0).all()
        assert (body.tets.tets.ravel()[mine] == vertex).all()


def test_unused_vertices_are_left_out(block, pla):
    crowded = TetMesh(np.vstack([block.vertices, [[99.0, 99.0, -99.0]]]), block.tets)
    body = discretise(crowded, pla, 0.0)
    assert len(body.tets.vertices) == len(block.vertices)
    assert len(block.vertices) not in body.vertex_order


def test_sliver_scaling_uses_the_allowance_and_no_more(sliver, pla):
    scale = sliver_scale(sliver, pla, 0.005)
    added = sliver.volumes @ scale / sliver.volumes.sum() - 1.0
    assert added == pytest.approx(0.005, rel=1e-9)
    frequency = element_frequencies(sliver, pla)
    scaled = frequency / np.sqrt(scale)
    # Every element that was made heavier sits exactly at the common target, the others below it.
    np.testing.assert_allclose(scaled[scale > 1.0], scaled.max(), rtol=1e-9)
    assert scaled.max() < 0.5 * frequency.max()


def test_no_allowance_means_no_scaling(sliver, pla):
    np.testing.assert_array_equal(sliver_scale(sliver, pla, 0.0), 1.0)


def test_added_mass_is_what_the_masses_say(sliver, pla):
    body = discretise(sliver, pla, 0.005)
    true_mass = pla.density * sliver.volumes.sum()
    assert body.masses.sum() / true_mass - 1.0 == pytest.approx(body.added_mass, rel=1e-9)
    assert body.added_mass <= 0.005 * (1 + 1e-9)


def test_unusable_tetrahedra_are_refused_with_a_reason(block, pla):
    with pytest.raises(BadInput, match="no tetrahedra"):
        discretise(TetMesh(block.vertices, np.empty((0, 4))), pla, 0.0)
    with pytest.raises(BadInput, match=r"1 tetrahedra have no positive volume, the first at \("):
        discretise(TetMesh(block.vertices, np.vstack([block.tets, block.tets[:1, [0, 2, 1, 3]]])), pla, 0.0)
    broken = block.vertices.copy()
    broken[3, 1] = np.nan
    with pytest.raises(BadInput, match="1 vertices of the tetrahedra are not finite"):
        discretise(block.moved(broken), pla, 0.0)
