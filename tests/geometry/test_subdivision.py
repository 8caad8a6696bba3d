"""Subdivision: the same shape in more and smaller faces."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.geometry.subdivision import halved, refined_to, subdivided


def test_normals_of_coarse_vertices_stay_what_they_were(cup):
    """A displacement along normals means the same on both."""
    assert np.allclose(subdivided(cup).mesh.vertex_normals[: len(cup.vertices)], cup.vertex_normals, atol=1e-9)


@pytest.mark.parametrize("parts", [1, 2, 3, 4])
def test_an_edge_in_so_many_parts_makes_their_square_of_faces_and_values_stay_linear(cup, parts):
    fine, values = subdivided(cup, parts), cup.vertices @ [1.0, 2.0, 3.0]
    assert len(fine.mesh.faces) == parts**2 * len(cup.faces)
    assert fine.mesh.is_closed
    assert fine.mesh.volume == pytest.approx(cup.volume, rel=1e-12)
    assert fine.mesh.face_areas.reshape(len(cup.faces), -1) == pytest.approx(np.repeat(cup.face_areas[:, None], parts**2, 1) / parts**2)
    assert np.array_equal(fine.mesh.vertices[: len(cup.vertices)], cup.vertices)
    assert fine.interpolation @ values == pytest.approx(fine.mesh.vertices @ [1.0, 2.0, 3.0])
    assert fine.interpolation.sum(axis=1) == pytest.approx(np.ones(len(fine.mesh.vertices)))


def test_the_nearest_coarse_vertex_is_that_of_the_largest_weight(cup):
    fine, count = subdivided(cup, 3), len(cup.vertices)
    assert np.array_equal(fine.nearest[:count], np.arange(count))
    there = np.linalg.norm(fine.mesh.vertices - cup.vertices[fine.nearest], axis=1)
    on_edges = slice(count, count + 2 * len(cup.edges))
    ends = fine.interpolation[on_edges].indices.reshape(-1, 2)
    away = np.linalg.norm(fine.mesh.vertices[on_edges][:, None] - cup.vertices[ends], axis=2)
    assert there[on_edges] == pytest.approx(away.min(axis=1))


def test_the_longest_edges_are_halved_and_none_shares_a_face(cup):
    count, fine = len(cup.vertices), halved(cup, 50)
    assert len(fine.mesh.vertices) == count + 50
    assert fine.mesh.is_closed
    assert fine.mesh.volume == pytest.approx(cup.volume, rel=1e-12)
    assert fine.mesh.vertex_normals[:count] == pytest.approx(cup.vertex_normals, abs=1e-9)
    length = np.linalg.norm(cup.vertices[cup.edges[:, 0]] - cup.vertices[cup.edges[:, 1]], axis=1)
    ends = np.sort(fine.interpolation.indices[count:].reshape(-1, 2), axis=1)
    cut = np.linalg.norm(cup.vertices[ends[:, 0]] - cup.vertices[ends[:, 1]], axis=1)
    assert cut.min() > np.median(length)
    assert cut.max() == length.max()


@pytest.mark.parametrize(("share", "parts"), [(3.99, 2), (4.05, 2), (4.3, 2), (5.0, 3), (9.1, 3)])
def test_a_surface_gets_the_vertices_that_were_asked_for_and_not_many_more(cup, share, parts):
    wanted = round(share * len(cup.vertices))
    found = len(refined_to(cup, wanted, most_parts=4).mesh.vertices)
    assert wanted <= found
    assert found < max(1.01 * wanted, parts**2 * len(cup.vertices))


def test_an_edge_is_cut_into_no_more_parts_than_it_may(cup):
    assert len(refined_to(cup, 10**6, most_parts=2).mesh.faces) == 4 * len(cup.faces)


def test_colours_go_along(cube):
    coloured = subdivided(cube.coloured(cube.vertices / 10.0)).mesh
    assert coloured.colours == pytest.approx(coloured.vertices / 10.0)
