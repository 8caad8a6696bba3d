"""Bringing fields to the surface: linear fields exactly, the paper's variant within its known error."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.geometry.transfer import Transfer
from mechstyle.records.mesh import SurfaceMesh


def test_a_constant_stays_constant(cup, cup_tets):
    for method in ("barycentric", "nearest"):
        field = Transfer(cup, cup_tets, method).to_surface(np.full(len(cup_tets.vertices), 7.0))
        assert field == pytest.approx(7.0)


def test_a_linear_field_is_exact_up_to_the_distance_between_the_meshes(cup, cup_tets):
    slope = np.array([0.3, -0.2, 0.5])
    field = Transfer(cup, cup_tets).to_surface(cup_tets.vertices @ slope)
    assert np.abs(field - cup.vertices @ slope).max() < 0.25 * np.linalg.norm(slope)  # mm between surface and boundary


def test_interpolation_stays_within_what_it_interpolates(cup, cup_tets):
    values = np.random.default_rng(0).random(len(cup_tets.vertices))
    field = Transfer(cup, cup_tets).to_surface(values)
    assert values.min() - 1e-6 <= field.min() <= field.max() <= values.max() + 1e-6


def test_barycentric_is_several_times_better_than_the_published_variant(cup, cup_tets):
    wave = lambda points: np.sin(0.3 * points[:, 0]) * np.cos(0.2 * points[:, 2])  # noqa: E731
    errors = {
        method: np.sqrt(np.mean((Transfer(cup, cup_tets, method).to_surface(wave(cup_tets.vertices)) - wave(cup.vertices)) ** 2))
        for method in ("barycentric", "nearest")
    }
    assert errors["barycentric"] < errors["nearest"] / 3
    assert errors["nearest"] < 0.3


def test_the_published_variant_sees_neither_place_nor_size_nor_proportions(cup_tets):
    """Both fill the unit box, so that a shell moved and stretched along the axes takes its values vertex by vertex."""
    outer, faces = np.unique(cup_tets.boundary_faces, return_inverse=True)
    values = np.random.default_rng(0).random(len(cup_tets.vertices))
    shell = SurfaceMesh(cup_tets.vertices[outer] * [3.0, 0.5, 40.0] + [100.0, -70.0, 30.0], faces.reshape(-1, 3))
    assert np.array_equal(Transfer(shell, cup_tets, "nearest").to_surface(values), values[outer])


def test_a_surface_without_height_takes_values_too(cup_tets):
    floor = SurfaceMesh([[0.0, 0.0, 2.0], [30.0, 0.0, 2.0], [0.0, 30.0, 2.0], [30.0, 30.0, 2.0]], [[0, 1, 3], [0, 3, 2]])
    assert Transfer(floor, cup_tets, "nearest").to_surface(np.full(len(cup_tets.vertices), 7.0)).tolist() == [7.0] * 4


def test_a_wrong_number_of_values_is_refused(cup, cup_tets):
    with pytest.raises(BadInput, match="one for each"):
        Transfer(cup, cup_tets).to_surface(np.zeros(3))


def test_an_unknown_method_is_refused(cup, cup_tets):
    with pytest.raises(BadInput, match="did you mean 'nearest'"):
        Transfer(cup, cup_tets, "nearst")
