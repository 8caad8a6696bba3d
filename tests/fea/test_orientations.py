"""Ways to land: what each set holds, what its landings are called, and that its weights are the probabilities of geometry."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import trimesh

from mechstyle.errors import BadInput
from mechstyle.fea.orientations import (
    TILT,
    UPRIGHT_CAP,
    directions,
    fibonacci,
    orientation_set,
    resting,
    stable_poses,
    tilted,
)
from mechstyle.records import POSES

ORIGIN = np.zeros(3)
CUBE = np.array(list(itertools.product((-5.0, 5.0), repeat=3)))
SLAB = CUBE * [3.0, 2.0, 1.0] + [4.0, -7.0, 9.0]
TURN = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
ROD = np.concatenate([np.stack([10.0 * np.cos(TURN), 10.0 * np.sin(TURN), np.full(48, z)], axis=1) for z in (-40.0, 40.0)])


def angles(normals):
    """To upright [degrees]."""
    return np.degrees(np.arccos(np.clip(normals[:, 2], -1.0, 1.0)))


@pytest.mark.parametrize("poses", POSES)
@pytest.mark.parametrize("count", [1, 2, 5, 24])
def test_every_set_begins_upright_with_unit_normals_and_probabilities(poses, count):
    found = orientation_set(poses, count, SLAB, SLAB.mean(axis=0))
    np.testing.assert_array_equal(found.normals[0], [0.0, 0.0, 1.0])
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1.0, rtol=1e-12)
    assert len(found.normals) <= count
    assert len(found.normals) == count or poses not in ("fibonacci", "tilts")
    assert len(found.names) == len(set(found.names)) == len(found.normals)
    assert found.names[0].startswith("as placed")
    assert found.weights.sum() == pytest.approx(1.0)
    assert (found.weights >= 0.0).all()
    again = orientation_set(poses, count, SLAB, SLAB.mean(axis=0))
    assert found.normals.tobytes() == again.normals.tobytes()
    assert found.weights.tobytes() == again.weights.tobytes()
    assert found.names == again.names


def test_the_upright_drop_of_a_tumbling_part_weighs_what_its_cap_does():
    found = fibonacci(64)
    assert found.weights[0] == pytest.approx(0.5 * (1.0 - np.cos(np.radians(UPRIGHT_CAP))))
    assert np.ptp(found.weights[1:]) == 0.0
    np.testing.assert_allclose(found.weights @ found.normals, 0.0, atol=0.02)  # a whole sphere has its centre in the middle
    np.testing.assert_array_equal(directions(64), found.normals)


def test_small_tilts_lean_to_all_sides_by_the_same_angle():
    found = tilted(8)
    np.testing.assert_allclose(angles(found.normals[1:]), TILT, rtol=1e-9)
    np.testing.assert_allclose(found.normals[1:].mean(axis=0), [0.0, 0.0, np.cos(np.radians(TILT))], atol=1e-12)
    np.testing.assert_allclose(found.weights, 1.0 / 8.0)
    np.testing.assert_allclose(angles(tilted(3, 10.0).normals[1:]), 10.0, rtol=1e-9)


def test_a_cube_rests_on_each_of_its_sides_alike():
    found = resting(CUBE, ORIGIN, 24)
    assert len(found.normals) == 6
    np.testing.assert_allclose(found.weights, 1.0 / 6.0)
    np.testing.assert_allclose(np.sort(np.abs(found.normals), axis=1), np.tile([0.0, 0.0, 1.0], (6, 1)), atol=1e-12)


def test_the_poses_are_those_trimesh_finds_one_by_one():
    """On a wedge with a corner cut off, whose eight sides include some it does not stay on."""
    base, top = [(0, 0, 0), (60, 0, 0), (60, 20, 0), (0, 20, 0)], [(0, 0, 10), (55, 0, 30), (60, 0, 25), (60, 20, 30), (0, 20, 10)]
    points = np.array([*base, *top], dtype=float)
    hull = trimesh.convex.convex_hull(points)
    normals, chances = stable_poses(hull.vertices, hull.center_mass)
    transforms, expected = trimesh.poses.compute_stable_poses(hull, seed=0)
    tallied = np.array([chances[normals @ transform[2, :3] > 1.0 - 1e-6].sum() for transform in transforms])
    np.testing.assert_allclose(tallied, expected, atol=1e-6)
    assert chances.sum() == pytest.approx(1.0)
    assert len(expected) < len(np.unique(np.round(hull.face_normals, 6), axis=0)), "every side carries it: nothing tips over"


def test_a_part_that_does_not_stay_as_placed_is_dropped_so_without_weight():
    leaning = CUBE @ trimesh.transformations.rotation_matrix(np.radians(30.0), (1.0, 0.0, 0.0))[:3, :3].T
    found = resting(leaning, ORIGIN, 24)
    assert len(found.normals) == 7
    assert found.weights[0] == 0.0
    np.testing.assert_allclose(found.weights[1:], 1.0 / 6.0)


def test_a_part_that_rolls_is_covered_by_as_many_drops_as_asked_for():
    normals, chances = stable_poses(ROD, ORIGIN)
    sides = np.abs(normals[:, 2]) < 0.1
    assert len(normals) > 48
    assert chances[sides].sum() > 0.9
    found = resting(ROD, ORIGIN, 8)
    assert 5 <= len(found.normals) <= 8
    assert found.weights[np.abs(found.normals[:, 2]) < 0.1].sum() == pytest.approx(chances[sides].sum(), abs=0.06)


def test_the_most_likely_pose_is_dropped_first_after_the_one_as_placed():
    found = resting(SLAB, SLAB.mean(axis=0), 24)
    assert found.weights[0] == pytest.approx(found.weights[1])  # upright, and upside down
    assert found.weights[0] > 0.3
    assert (np.diff(found.weights[1:]) <= 1e-12).all()


def test_a_tilt_is_named_by_the_side_that_touches_first():
    found = tilted(9)
    assert found.names[:4] == ("as placed", "tilted 3° towards -x", "tilted 3° towards 225° from +x", "tilted 3° towards -y")
    for name, normal in zip(found.names[1::2], found.normals[1::2], strict=True):
        lowest = CUBE[np.isclose(CUBE @ normal, (CUBE @ normal).min())]
        axis, side = "xy".index(name[-1]), {"+": 1.0, "-": -1.0}[name[-2]]
        assert np.all(np.sign(lowest[:, axis]) == side)


def test_directions_and_resting_poses_are_numbered_as_they_are_dropped():
    assert fibonacci(3).names == ("as placed", "direction 1", "direction 2")
    assert resting(SLAB, SLAB.mean(axis=0), 8).names[:3] == ("as placed", "resting pose 1", "resting pose 2")


@pytest.mark.parametrize(("poses", "drops"), [("box26", 26), ("box10", 10), ("faces6", 6)])
def test_a_box_that_stands_is_not_dropped_on_its_bottom_twice(poses, drops):
    standing = orientation_set(poses, POSES[poses], SLAB, SLAB.mean(axis=0))
    assert len(standing.normals) == drops
    assert standing.names[0] == "as placed, face 3 (bottom)"
    leaning = SLAB @ trimesh.transformations.rotation_matrix(0.2, (1.0, 0.4, 0.0))[:3, :3].T
    found = orientation_set(poses, POSES[poses], leaning, leaning.mean(axis=0))
    assert len(found.normals) == drops + 1 == POSES[poses]
    assert found.names[0] == "as placed"
    assert sum(name.startswith("face") for name in found.names) == 6
    assert np.ptp(found.weights) == 0.0


def test_half_a_degree_beside_flat_is_another_landing():
    """The near edge of a slab lands 0.3 mm before the far one."""
    leaning = SLAB @ trimesh.transformations.rotation_matrix(np.radians(0.5), (0.0, 1.0, 0.0))[:3, :3].T
    assert len(orientation_set("faces6", 7, leaning, leaning.mean(axis=0)).normals) == 7


def test_unknown_poses_and_counts_are_refused():
    with pytest.raises(BadInput, match="unknown poses 'restin': did you mean 'resting'"):
        orientation_set("restin", 5, CUBE, ORIGIN)
    for poses in POSES:
        with pytest.raises(BadInput, match="at least one orientation, not 0"):
            orientation_set(poses, 0, CUBE, ORIGIN)
