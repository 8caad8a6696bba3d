"""The impact on the surface: rigid motion is told from deformation, and what was worked out is remembered."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mechstyle.simulation.impact import Impact, nearest_rigid


@pytest.fixture
def turned(sphere):
    """The sphere turned, shifted and then stretched along z by 1 %."""
    stretched = sphere.vertices * [1.0, 1.0, 1.01]
    rotation = Rotation.from_rotvec([0.1, -0.2, 0.3])
    return rotation, rotation.apply(stretched) + np.array([3.0, -1.0, 2.0])


def test_a_rigid_motion_is_found_again(sphere):
    moved = Rotation.from_rotvec([0.5, 0.1, -0.7]).apply(np.array(sphere.vertices)) + np.array([1.0, 2.0, 3.0])
    assert np.allclose(nearest_rigid(sphere.vertices, moved), moved, atol=1e-9)


def test_a_mirror_image_is_no_rigid_motion(sphere):
    bent = sphere.vertices * [-1.0, 1.0, 1.2]
    turned = nearest_rigid(sphere.vertices, bent)
    a, b, c, d = (turned[index] - turned.mean(axis=0) for index in (0, 100, 2000, 3000))
    e, f, g, h = (sphere.vertices[index] for index in (0, 100, 2000, 3000))
    assert np.linalg.det([a - d, b - d, c - d]) == pytest.approx(np.linalg.det([e - h, f - h, g - h]), abs=1e-6)


def test_only_the_deformation_is_exaggerated(sphere, turned):
    rotation, moved = turned
    impact = Impact(np.array([0.0]), (moved - sphere.vertices)[None].astype(np.float32), np.zeros((1, len(moved)), np.float32))
    assert np.allclose(impact.shape(sphere, 0, 1.0).vertices, moved, atol=1e-5)
    stretched = rotation.apply(sphere.vertices * [1.0, 1.0, 1.0 + 0.01 * 30]) + np.array([3.0, -1.0, 2.0])
    assert np.allclose(impact.shape(sphere, 0, 30.0).vertices, stretched, atol=0.02)
