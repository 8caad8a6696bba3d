"""Quartering: the same shape in four times as many faces."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.geometry.subdivision import quartered


def test_the_shape_stays_and_the_faces_are_quartered(cup):
    fine = quartered(cup)
    assert len(fine.mesh.faces) == 4 * len(cup.faces)
    assert fine.mesh.is_closed
    assert fine.mesh.volume == pytest.approx(cup.volume, rel=1e-12)
    assert fine.mesh.face_areas.reshape(-1, 4) == pytest.approx(np.repeat(cup.face_areas[:, None] / 4, 4, axis=1))
    assert np.array_equal(fine.mesh.vertices[: len(cup.vertices)], cup.vertices)


def test_normals_of_coarse_vertices_stay_what_they_were(cup):
    """A displacement along normals means the same on both."""
    assert np.allclose(quartered(cup).mesh.vertex_normals[: len(cup.vertices)], cup.vertex_normals, atol=1e-9)


def test_values_are_interpolated_half_way_between_the_parents(cup):
    fine, values = quartered(cup), cup.vertices @ [1.0, 2.0, 3.0]
    assert fine.interpolation @ values == pytest.approx(fine.mesh.vertices @ [1.0, 2.0, 3.0])
    assert np.array_equal(fine.parents[: len(cup.vertices)], np.repeat(np.arange(len(cup.vertices)), 2).reshape(-1, 2))
    middles = 0.5 * (cup.vertices[fine.parents[:, 0]] + cup.vertices[fine.parents[:, 1]])
    assert fine.mesh.vertices == pytest.approx(middles)


def test_colours_go_along(cube):
    coloured = quartered(cube.coloured(cube.vertices / 10.0)).mesh
    assert coloured.colours == pytest.approx(coloured.vertices / 10.0)
