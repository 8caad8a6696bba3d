import numpy as np
import pytest

from mechstyle.pictures.camera import Camera
from mechstyle.pictures.scene import corner_normals, floor_shadow, hollows, lit


def test_a_cube_keeps_its_edges(block):
    assert corner_normals(block) == pytest.approx(np.repeat(block.face_normals[:, None], 3, axis=1), abs=1e-12)


def test_a_ball_is_smooth(ball):
    radial = (ball.corners - (0, 0, 10)) / 10.0
    assert np.einsum("ijk,ijk->ij", corner_normals(ball), radial).min() > np.cos(np.radians(1.0))  # facets turn by 2.8 degrees


def test_faces_turned_to_the_key_lamp_are_brightest_and_none_is_black(ball):
    camera = Camera.named("front", ball.vertices)
    light = lit(ball.vertex_normals.astype(np.float32), camera)
    brightest = ball.vertex_normals[light.argmax()] @ camera.axes.T
    assert brightest[0] < 0 < brightest[1]
    assert brightest[2] > 0
    assert 0.1 < light.min() < light.max() < 1.2


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
