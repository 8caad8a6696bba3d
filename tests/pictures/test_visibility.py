import numpy as np
import pytest
from scipy.spatial import Delaunay

from mechstyle.pictures.camera import Camera
from mechstyle.pictures.visibility import visible


def flat(points, depth=1.0):
    return np.column_stack([points, np.full(len(points), depth)])


def test_faces_that_share_edges_cover_every_pixel_exactly_once():
    # Random triangles, and a lattice whose edges and corners run exactly through pixel centres.
    random = np.random.default_rng(3).uniform(-1, 1, (40, 2))
    lattice = np.stack(np.meshgrid(np.arange(-7, 8, 2), np.arange(-7, 8, 2)), axis=-1).reshape(-1, 2) / 8
    frame = np.array([(-1.2, -1.2), (1.2, -1.2), (1.2, 1.2), (-1.2, 1.2)])
    for inner, size in ((random, 96), (lattice, 8)):
        points = np.vstack([frame, inner])
        faces = Delaunay(points).simplices
        times = sum((visible(flat(points), faces[k : k + 1], size, size).face >= 0).astype(int) for k in range(len(faces)))
        assert (times == 1).all()
        assert (visible(flat(points), faces, size, size).face >= 0).all()


def test_what_is_seen_of_a_sphere_lies_on_the_sphere(sphere):
    camera = Camera.named("three_quarter", sphere.vertices)
    seen = visible(camera.project(sphere.vertices), sphere.faces, 200, 200)
    hit = seen.face >= 0
    spots = np.einsum("ij,ijk->ik", seen.barycentrics[hit], sphere.corners[seen.face[hit]])
    assert np.linalg.norm(spots, axis=1) == pytest.approx(10.0, abs=0.02)  # sagitta of its faces: below 0.02 mm
    assert (spots - camera.eye) @ -camera.axes[2] == pytest.approx(seen.depth[hit], rel=1e-5)
    along = camera.directions(200, 200)[hit] * seen.depth[hit][:, None] + camera.eye
    assert np.abs(spots - along).max() < 0.01  # a sub-pixel step is 1e-4 mm here, magnified where the ball turns away
    assert seen.barycentrics[hit].sum(axis=1) == pytest.approx(1.0, abs=1e-5)
    assert (seen.barycentrics[~hit] == 0).all()
    assert np.isinf(seen.depth[~hit]).all()


def test_perspective_correct_weights_halve_a_receding_edge_where_space_does():
    points = np.array([(-0.5, -0.5, 1.0), (0.5, -0.5, 1.0), (0.0, 0.5 / 3, 3.0)])  # the apex is three times as far
    seen = visible(points, [[0, 1, 2]], 301, 301)
    column = np.flatnonzero(seen.face[:, 150] >= 0)
    apex = seen.barycentrics[column, 150, 2]
    depth = seen.depth[column, 150]
    assert depth == pytest.approx(1.0 + 2.0 * apex, rel=1e-5)


@pytest.mark.parametrize(("width", "height"), [(12, 31), (31, 12)])
def test_in_tall_and_wide_pictures_each_pixel_shows_the_place_it_lies_on(width, height):
    frame = np.array([(-1.1, -1.1), (1.1, -1.1), (1.1, 1.1), (-1.1, 1.1)])
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    views = np.stack([flat(frame), flat(frame + 0.05)])
    seen = visible(views, faces, width, height)
    across, up = (np.arange(width) + 0.5) / width * 2.0 - 1.0, 1.0 - (np.arange(height) + 0.5) / height * 2.0
    for view, points in enumerate(views):
        places = np.einsum("rck,rckx->rcx", seen.barycentrics[view], points[faces[seen.face[view]]])
        np.testing.assert_allclose(places[..., 0], np.broadcast_to(across, (height, width)), atol=1e-3)
        np.testing.assert_allclose(places[..., 1], np.broadcast_to(up[:, None], (height, width)), atol=1e-3)


def test_the_nearest_face_wins_and_ties_go_to_the_first():
    corners = [(-2, -2), (2, -2), (0, 4)]
    points = np.vstack([flat(np.array(corners, float), depth) for depth in (2.0, 1.5, 1.5)])
    faces = np.arange(9).reshape(3, 3)
    assert (visible(points, faces, 16, 16).face == 1).all()
    assert (visible(points, faces[[0]], 16, 16).face == 0).all()


@pytest.mark.parametrize("depth", [0.0, -1.0, np.nan])
def test_a_face_with_a_corner_behind_the_viewer_is_left_out(depth):
    points = flat(np.array([(-2, -2), (2, -2), (0, 4)], float))
    points[1, 2] = depth
    assert (visible(points, [[0, 1, 2]], 8, 8).face == -1).all()
