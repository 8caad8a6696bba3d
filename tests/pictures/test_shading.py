import numpy as np
import pytest

from mechstyle.pictures.camera import Camera
from mechstyle.pictures.scene import corner_normals, floor_shadow, hollows, lit


def test_a_cube_keeps_its_edges(block):
    assert corner_normals(block) == pytest.approx(np.repeat(block.face_normals[:, None], 3, axis=1), abs=1e-12)


def test_a_ball_is_smooth(ball):
    radial = (ball.corners - (0, 0, 10)) / 10.0
    assert np.einsum("ijk,ijk->ij", corner_normals(ball), radial).min() > np.cos(np.radians(1.0))  # facets turn by 2.8 degrees


def test_corners_of_some_faces_are_those_of_all(ball):
    some = np.array([3, 40, 41, len(ball.faces) - 1])
    assert np.array_equal(corner_normals(ball, faces=some), corner_normals(ball)[some])


def test_a_crease_angle_beyond_a_right_angle_rounds_the_cube(block):
    outward = block.corners - (0, 0, 10)
    outward /= np.linalg.norm(outward, axis=2, keepdims=True)
    assert corner_normals(block, crease=100.0) == pytest.approx(outward, abs=1e-12)


def test_faces_turned_to_the_key_lamp_are_brightest_and_none_is_black(ball):
    camera = Camera.named("front", ball.vertices)
    light = lit(ball.vertex_normals.astype(np.float32), camera)
    brightest = ball.vertex_normals[light.argmax()] @ camera.axes.T
    assert brightest[0] < 0 < brightest[1]
    assert brightest[2] > 0
    assert 0.1 < light.min() < light.max() < 1.2


def test_what_faces_down_is_lit_when_seen_from_below():
    camera = Camera(35, -38, (0, 0, 0), 100)
    assert lit(np.array([[0, 0, -1]], np.float32), camera)[0] > 0.5


def test_a_hollow_is_darker_than_its_rim_and_a_plane_is_not_darkened():
    plane = np.full((100, 100), 50.0, np.float32)
    assert hollows(plane, 10.0).max() < 1e-3
    plane[48:52] += 1.0  # a groove
    dark = hollows(plane, 10.0)
    assert dark[50].min() > 0.1
    assert dark[[0, 47, 52, 99]].max() < 1e-3


def test_the_shadow_is_under_the_part_and_fades_before_the_border(block):
    camera = Camera.named("three_quarter", block.vertices)
    dark = floor_shadow(block, camera, 120, 120)
    x, y, _ = camera.project([(0, 0, 0)])[0]
    middle = dark[int((1 - y) * 60), int((x + 1) * 60)]
    assert middle > 0.4
    border = np.concatenate([dark[0], dark[-1], dark[:, 0], dark[:, -1]])
    assert border.max() == 0
    assert dark.min() >= 0
    assert dark.max() < 1


def test_a_raised_part_throws_less_shadow_than_a_standing_one(block):
    table = block.vertices * (1, 1, 0.2) + (0, 0, 16)  # the same footprint, but only a corner reaches the floor
    table[0] = block.vertices[0]
    camera = Camera.named("top", block.vertices)
    assert floor_shadow(block.moved(table), camera, 60, 60).sum() < 0.5 * floor_shadow(block, camera, 60, 60).sum()


def test_there_is_no_floor_to_see_from_below(block):
    assert not floor_shadow(block, Camera.named("below", block.vertices), 30, 30).any()
