"""Subdivision: the same shape in more and smaller faces."""

from __future__ import annotations

import numpy as np
import pytest

from mechstyle.geometry.subdivision import halved, refined_to, subdivided


def test_normals_of_the_vertices_that_were_there_stay_what_they_were(cup):
    assert np.allclose(subdivided(cup).vertex_normals[: len(cup.vertices)], cup.vertex_normals, atol=1e-9)


@pytest.mark.parametrize("parts", [1, 2, 3, 4])
def test_an_edge_in_so_many_parts_makes_their_square_of_faces(cup, parts):
    fine = subdivided(cup, parts)
    assert len(fine.faces) == parts**2 * len(cup.faces)
    assert fine.is_closed
    assert fine.volume == pytest.approx(cup.volume, rel=1e-12)
    assert fine.face_areas.reshape(len(cup.faces), -1) == pytest.approx(np.repeat(cup.face_areas[:, None], parts**2, 1) / parts**2)
    assert np.array_equal(fine.vertices[: len(cup.vertices)], cup.vertices)


def test_the_longest_edges_are_halved_and_none_shares_a_face(cup):
    count, fine = len(cup.vertices), halved(cup, 50)
    assert len(fine.vertices) == count + 50
    assert fine.is_closed
    assert fine.volume == pytest.approx(cup.volume, rel=1e-12)
    assert fine.vertex_normals[:count] == pytest.approx(cup.vertex_normals, abs=1e-9)
    ends = cup.vertices[cup.edges]
    length, middles = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1), ends.mean(axis=1)
    cut = [length[np.linalg.norm(middles - new, axis=1).argmin()] for new in fine.vertices[count:]]
    assert min(cut) > np.median(length)
    assert max(cut) == length.max()


@pytest.mark.parametrize(("share", "parts"), [(3.99, 2), (4.05, 2), (4.3, 2), (5.0, 3), (9.1, 3)])
def test_a_surface_gets_the_vertices_that_were_asked_for_and_not_many_more(cup, share, parts):
    wanted = round(share * len(cup.vertices))
    found = len(refined_to(cup, wanted, most_parts=4).vertices)
    assert wanted <= found
    assert found < max(1.01 * wanted, parts**2 * len(cup.vertices))


def test_an_edge_is_cut_into_no_more_parts_than_it_may(cup):
    assert len(refined_to(cup, 10**6, most_parts=2).faces) == 4 * len(cup.faces)


def test_colours_lie_between_those_around(cube):
    coloured = subdivided(cube.coloured(cube.vertices / 10.0))
    assert np.allclose(coloured.colours, coloured.vertices / 10.0)
