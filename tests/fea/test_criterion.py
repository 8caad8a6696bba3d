"""Averages and percentiles on fields whose answers are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mechstyle.fea.criterion import BallAverage, exceedance, measures, percentile, robust_field
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


@pytest.mark.parametrize(("count", "points"), [(7.9, 8), (8.1, 1)])
@pytest.mark.parametrize("size", [1.0, 6.0])
def test_a_tetrahedron_is_taken_as_one_point_where_the_ball_holds_eight_of_them(box, size, count, points):
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


def test_the_robust_field_is_the_largest_average_around_a_vertex_and_its_maximum_the_peak(block, average):
    values = np.random.default_rng(0).uniform(0.0, 50.0, (len(block.tets), 4))
    field, averaged = robust_field(block, values, average), average(block, values)
    for vertex in (0, 40, 99):
        assert field[vertex] == averaged[(block.tets == vertex).any(axis=1)].max()
    assert field.max() == measures(block, values, average).peak


def test_a_part_without_stress_has_a_robust_field_of_nothing(block, average):
    assert not robust_field(block, np.zeros((len(block.tets), 4)), average).any()


def test_exceedance_is_the_probability_of_the_orientations_in_which_more_than_the_allowable_is_reached():
    fields = [[10.0, 50.0, 45.6], [46.0, 50.0, 45.6], [0.0, 60.0, 45.7]]
    assert exceedance(fields, [0.5, 0.3, 0.2], 45.6) == pytest.approx([0.3, 1.0, 0.2])


def test_percentiles_of_known_arrays():
    assert percentile([1.0, 2.0, 3.0, 4.0], [1.0, 1.0, 1.0, 1.0], 0.5) == 2.0
    assert percentile([4.0, 1.0, 3.0, 2.0], [1.0, 1.0, 1.0, 1.0], 0.75) == 3.0
    assert percentile([1.0, 100.0], [99.0, 1.0], 0.99) == 1.0
    assert percentile([1.0, 100.0], [99.0, 1.0], 1.0) == 100.0
    assert percentile([1.0, 3.0], [1.0, 1.0], 0.75) == 2.0


@given(values=st.lists(st.floats(0.0, 1e3), min_size=1, max_size=30), share=st.floats(0.01, 1.0), factor=st.floats(0.1, 10.0))
def test_percentiles_lie_among_the_values_and_do_not_see_the_unit_of_weight(values, share, factor):
    weights = np.linspace(1.0, 2.0, len(values))
    found = percentile(values, weights, share)
    assert min(values) <= found <= max(values)
    assert percentile(values, factor * weights, share) == pytest.approx(found, rel=1e-6, abs=1e-6)


def test_measures_find_peak_place_and_volume(block, average):
    values = np.zeros((len(block.tets), 4))
    values[123] = 40.0
    found = measures(block, values, average)
    assert found.maximum == 40.0
    assert 0.0 < found.peak < 40.0
    assert np.linalg.norm(np.array(found.where) - block.vertices[block.tets[123]].mean(axis=0)) <= 2.0
    assert found.volume == pytest.approx(12.0 * 10.0 * 16.0)
    assert found.p99 <= found.p999 <= found.maximum


def test_measures_weigh_percentiles_by_volume(box):
    """Where the stress is the share of the volume that has less, each percentile is its own share."""
    fine = box((8, 8, 8), (6.0, 6.0, 6.0), shake=0.3)
    order = np.random.default_rng(0).permutation(len(fine.tets))
    share = np.empty(len(order))
    share[order] = np.cumsum(fine.volumes[order]) / fine.volumes.sum()
    found = measures(fine, np.repeat(share[:, None], 4, axis=1), BallAverage(fine))
    assert found.p99 == pytest.approx(0.99, abs=5e-4)
    assert found.p999 == pytest.approx(0.999, abs=5e-4)
    assert found.maximum == pytest.approx(1.0)
