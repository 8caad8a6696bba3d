"""The structured bodies: closed, of the volume and area of the shape they stand for."""

import numpy as np
import pytest

from validation.meshes import (
    ball,
    box,
    bracket,
    carved,
    cup,
    grooved_bar,
    necked_bar,
    open_ring,
    refined,
    roller,
    round_bar,
    square_cup,
    upright_bar,
)


def boundary_area(tets):
    corners = tets.vertices[tets.boundary_faces]
    return 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()


def edges_are_shared_by_two(tets):
    faces = tets.boundary_faces
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


CUP = {"volume": np.pi * (15.0**2 * 2.0 + (15.0**2 - 13.0**2) * 23.0)}
CUP["area"] = np.pi * (15.0**2 + 2 * 15.0 * 25.0 + (15.0**2 - 13.0**2) + 2 * 13.0 * 23.0 + 13.0**2)


@pytest.mark.parametrize(
    ("tets", "volume", "area", "tolerance"),
    [
        (box((3, 2, 4), (12.0, 10.0, 16.0)), 1920.0, 944.0, 1e-9),
        (ball(20.0, 12, 4.0), 4 / 3 * np.pi * 20.0**3, 4 * np.pi * 20.0**2, 0.02),
        (square_cup(24.0, 24.0, 2.0), 24.0**3 - 20.0**2 * 22.0, 2 * 24.0**2 + 4 * 24.0**2 + 4 * 20.0 * 22.0, 1e-9),
        (bracket(20.0, 8.0, 4.0, 4.0), 8.0 * (20.0**2 - 16.0**2), 8.0 * 80.0 + 2 * (20.0**2 - 16.0**2), 1e-9),
        (open_ring(30.0, 30.0, 6.0, 60), 36.0 * 1.8 * np.pi * 30.0, 4 * 6.0 * 1.8 * np.pi * 30.0 + 2 * 36.0, 0.01),
        (round_bar(4.0, 40.0, 10, 20), np.pi * 4.0 * 40.0, 4.0 * np.pi * 40.0 + 8.0 * np.pi, 0.01),
        (upright_bar(4.0, 40.0, 10, 20), np.pi * 16.0 * 40.0, 2.0 * np.pi * 16.0 + 8.0 * np.pi * 40.0, 0.01),
        (grooved_bar(), 64.0 * 30.6 + 16.0 * 1.4, 128.0 + 32.0 * 30.6 + 16.0 * 1.4 + 96.0, 1e-9),
        (necked_bar(), 1000.0 + 16.0, 400.0 + 400.0 - 32.0 + 16.0, 1e-9),
        (roller(8.0, 24.0, 12, 6, 4.0), np.pi * 64.0 * 24.0, 16.0 * np.pi * 24.0 + 128.0 * np.pi, 0.02),
        (cup(15.0, 25.0, 2.0), CUP["volume"], CUP["area"], 0.01),  # a face inside, where cells do not fit, would add to the area
    ],
)
def test_bodies_are_whole_and_of_the_size_they_should_be(tets, volume, area, tolerance):
    assert (tets.volumes > 0.0).all()
    assert edges_are_shared_by_two(tets)
    assert tets.volumes.sum() == pytest.approx(volume, rel=tolerance)
    assert boundary_area(tets) == pytest.approx(area, rel=tolerance)


def test_the_ball_touches_the_floor_at_one_point_where_it_is_finer():
    tets = ball(20.0, 12, 4.0)
    assert tets.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)
    assert (np.abs(tets.vertices[tets.vertices[:, 2] < 1e-6]) < 1e-6).all()
    centre = tets.vertices[tets.tets].mean(axis=1)
    near, far = (np.linalg.norm(centre - pole, axis=1) < 5.0 for pole in ([0.0, 0.0, 0.0], [0.0, 0.0, 40.0]))
    assert near.sum() > 1.4 * far.sum()
    assert np.median(tets.volumes[near]) < 0.5 * np.median(tets.volumes)


def test_the_round_bar_lies_on_the_floor_along_one_line():
    tets = roller(8.0, 24.0, 8, 4, 4.0)
    lowest = tets.vertices[tets.vertices[:, 2] < 1e-6]
    assert tets.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-9)
    assert lowest[:, 1] == pytest.approx(np.zeros(5), abs=1e-9)
    assert sorted(lowest[:, 0]) == pytest.approx([0.0, 6.0, 12.0, 18.0, 24.0])


def test_carving_keeps_whole_cells_by_their_middles():
    axis = np.array([0.0, 1.0, 2.0, 4.0])
    tets = carved(axis, axis, axis, lambda x, y, z: ~((x > 2.0) & (y > 2.0) & (z > 2.0)))
    assert tets.volumes.sum() == pytest.approx(64.0 - 8.0)
    assert edges_are_shared_by_two(tets)


def test_refinement_keeps_the_shape_and_cuts_every_tetrahedron_into_eight():
    coarse = cup(15.0, 25.0, 2.0, (12, 3, 2))
    fine = refined(coarse)
    assert len(fine.tets) == 8 * len(coarse.tets)
    np.testing.assert_allclose(fine.volumes.reshape(8, -1), np.broadcast_to(coarse.volumes / 8.0, (8, len(coarse.tets))))
    assert boundary_area(fine) == pytest.approx(boundary_area(coarse), rel=1e-12)
