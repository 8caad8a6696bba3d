"""Averages over a ball, on fields whose answers are known."""

import numpy as np
import pytest

from mechstyle.fea.ball_average import BallAverage, largest_around
from mechstyle.fea.elements import GAUSS_A, GAUSS_B


@pytest.fixture(scope="module")
def average(block):
    return BallAverage(block)


def test_the_average_of_a_constant_field_is_the_constant(block, average):
    np.testing.assert_allclose(average(block, np.full((len(block.tets), 4), 7.0)), 7.0, rtol=1e-6)


def test_the_average_is_the_volume_weighted_mean_over_the_ball(block, average):
    values = np.random.default_rng(0).uniform(0.0, 50.0, (len(block.tets), 1))
    points, averaged = average.points(block), average(block, values)
    assert points.shape == (len(block.tets), 8, 3)
    for tet, point in ((0, 0), (57, 3), (200, 7)):
        near = np.linalg.norm(points - points[tet, point], axis=2) <= 2.0
        assert near.sum() > 1
        weights = np.repeat(block.volumes[:, None], 8, axis=1)[near]
        assert averaged[tet, point] == pytest.approx(np.average(np.repeat(values, 8, axis=1)[near], weights=weights), rel=1e-5)


def test_sub_points_are_shares_of_the_volume_between_which_stress_is_linear(block):
    tiny = BallAverage(block, radius=1e-6)  # the value at the point itself
    gauss = np.full((4, 4), GAUSS_B) + (GAUSS_A - GAUSS_B) * np.eye(4)
    slope = np.array([1.0, -2.0, 0.5])
    at_gauss = np.einsum("qk,nkx,x->nq", gauss, block.vertices[block.tets], slope)
    np.testing.assert_allclose(tiny(block, at_gauss), tiny.points(block) @ slope, atol=1e-9)
    np.testing.assert_allclose(tiny.points(block).mean(axis=1), block.vertices[block.tets].mean(axis=1), atol=1e-12)


def test_a_fine_mesh_is_averaged_tetrahedron_by_tetrahedron(box):
    fine = box((8, 8, 8), (6.0, 6.0, 6.0))
    average, values = BallAverage(fine), np.random.default_rng(0).uniform(0.0, 50.0, (len(fine.tets), 4))
    assert average(fine, values).shape == (len(fine.tets), 1)
    centroids = fine.vertices[fine.tets].mean(axis=1)
    near = np.linalg.norm(centroids - centroids[100], axis=1) <= 2.0
    assert average(fine, values)[100, 0] == pytest.approx(values[near].mean(), rel=1e-5)


@pytest.mark.parametrize(("count", "points"), [(6.2, 8), (6.3, 4), (24.9, 4), (25.1, 1)])
@pytest.mark.parametrize("size", [1.0, 6.0])
def test_a_tetrahedron_is_taken_as_so_many_points_that_the_ball_holds_enough(box, size, count, points):
    """A ball of so many times the mean volume of a tetrahedron."""
    mesh = box((4, 4, 4), (size, size, 2.0 * size))
    radius = (count * mesh.volumes.mean() / (4.0 / 3.0 * np.pi)) ** (1.0 / 3.0)
    assert BallAverage(mesh, radius).points(mesh).shape == (len(mesh.tets), points, 3)


def test_the_average_keeps_its_neighbours_on_a_morph_but_weighs_with_its_volumes(block, average):
    values = np.random.default_rng(0).uniform(0.0, 50.0, (len(block.tets), 4))
    stretched = block.moved(block.vertices * [3.0, 1.0, 1.0])
    np.testing.assert_allclose(average(stretched, values), average(block, values), rtol=1e-5)
    bulged = block.moved(block.vertices * (1.0 + 0.05 * block.vertices[:, 2:]))
    assert np.abs(average(bulged, values) / average(block, values) - 1.0).max() > 1e-3


def test_what_is_largest_around_a_vertex_is_the_largest_average_of_its_tetrahedra(block, average):
    values = np.random.default_rng(0).uniform(0.0, 50.0, (len(block.tets), 4))
    field, averaged = largest_around(block, values, average), average(block, values)
    for vertex in (0, 40, 99):
        assert field[vertex] == averaged[(block.tets == vertex).any(axis=1)].max()
    assert field.max() == averaged.max()
    assert not largest_around(block, np.zeros((len(block.tets), 4)), average).any()


@pytest.mark.parametrize("counts", [(5, 5, 2), (6, 6, 2), (7, 7, 3), (8, 8, 3), (10, 10, 4)])
def test_the_average_of_bending_in_a_plate_of_6_mm_does_not_hang_on_the_edges_of_the_mesh(box, counts):
    """At its surface the centre of a half ball of 2 mm lies 0.75 mm deep, where three quarters of the bending stress are left."""
    plate = box(counts, (15.0, 15.0, 6.0))
    average = BallAverage(plate)
    gauss = np.full((4, 4), GAUSS_B) + (GAUSS_A - GAUSS_B) * np.eye(4)
    bending = np.abs(np.einsum("qk,nk->nq", gauss, plate.vertices[plate.tets][..., 2]) - 3.0) / 3.0
    inner = (np.abs(average.points(plate)[..., :2] - 7.5) < 3.5).all(axis=-1)
    assert average(plate, bending)[inner].max() == pytest.approx(0.75, rel=0.12)
