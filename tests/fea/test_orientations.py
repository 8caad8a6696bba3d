"""Ways to land: what each set holds, what its landings are called, and that they belong to the part."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest
import trimesh

from mechstyle import gallery
from mechstyle.errors import BadInput
from mechstyle.fea.orientations import (
    SAME_LANDING,
    TILT,
    UP,
    UPRIGHT_CAP,
    Orientations,
    directions,
    fibonacci,
    landings,
    nearly_flat_of,
    orientation_set,
    resting,
    touchdowns,
)
from mechstyle.fea.poses import stable_poses
from mechstyle.records import POSES
from mechstyle.records.mesh import SurfaceMesh

ORIGIN = np.zeros(3)
CUBE = np.array(list(itertools.product((-5.0, 5.0), repeat=3)))
SLAB = CUBE * [3.0, 2.0, 1.0] + [4.0, -7.0, 9.0]
TURN = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
ROD = np.concatenate([np.stack([10.0 * np.cos(TURN), 10.0 * np.sin(TURN), np.full(48, z)], axis=1) for z in (-40.0, 40.0)])


def hull(points):
    found = trimesh.convex.convex_hull(points)
    return SurfaceMesh(found.vertices, found.faces)


def standing(outline, height=15.0):
    """A prism on a convex outline."""
    return hull(np.concatenate([np.column_stack([outline, np.full(len(outline), z)]) for z in (0.0, height)]))


def regular(count, start=0.0):
    turn = np.radians(start) + 2.0 * np.pi * np.arange(count) / count
    return 30.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)


BOX = standing([(-30, -20), (30, -20), (30, 20), (-30, 20)])
WEDGE = hull([(0, 0, 0), (60, 0, 0), (60, 20, 0), (0, 24, 0), (0, 0, 10), (55, 0, 30), (60, 0, 25), (60, 20, 30), (0, 24, 10)])
"""No two of its sides are alike."""


def about(axis, degrees):
    return trimesh.transformations.rotation_matrix(np.radians(degrees), axis)[:3, :3]


def moved(surface, matrix):
    """A file of the part that a rotation or reflection about the vertical leaves standing."""
    return SurfaceMesh(surface.vertices @ matrix.T, surface.faces[:, ::-1] if np.linalg.det(matrix) < 0.0 else surface.faces)


def angle_apart(some, others):
    """Largest angle between a normal of one set and the nearest of the other, both ways [degrees]."""
    angles = np.degrees(2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(some[:, None] - others, axis=2), 0.0, 1.0)))
    return max(angles.min(axis=0).max(), angles.min(axis=1).max())


def lowest(surface, normal):
    """Vertices that touch the floor first."""
    heights = surface.vertices @ normal
    return surface.vertices[heights < heights.min() + 1e-6]


# --- flat, nearly flat, any landing -------------------------------------------------------------------------------


@pytest.mark.parametrize("nearly_flat", [True, False])
@pytest.mark.parametrize("poses", POSES)
@pytest.mark.parametrize("count", [1, 2, 24])
def test_flat_comes_first_then_nearly_flat_then_any_landing_and_none_twice(poses, count, nearly_flat):
    found = landings(BOX, poses, count, nearly_flat=nearly_flat)
    np.testing.assert_array_equal(found.normals[0], UP)
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1.0, rtol=1e-12)
    assert found.names[0] == found.ways[0] == "flat"
    tilted = 8 if nearly_flat else 0
    assert found.ways[1:] == ("nearly flat",) * tilted + ("any landing",) * (len(found.ways) - 1 - tilted)
    assert len(found.names) == len(set(found.names)) == len(found.normals) == len(found.ways)
    assert (found.normals @ found.normals.T)[~np.eye(len(found.normals), dtype=bool)].max(initial=-1.0) < SAME_LANDING
    others = found.ways.count("any landing")
    assert others == count - 1 if poses == "fibonacci" else others <= count - 1
    again = landings(BOX, poses, count, nearly_flat=nearly_flat)
    assert found.normals.tobytes() == again.normals.tobytes()
    assert found.names == again.names


def test_a_direction_that_is_nearly_flat_already_is_not_dropped_twice():
    """The box of a slab that leans by as much as a tilt lands on its bottom as the tilt does."""
    leaning = moved(BOX, about((0, 1, 0), TILT))
    bottom = about((0, 1, 0), TILT) @ UP
    assert "tilted 3° onto the left side" in landings(leaning, "faces6", 1, nearly_flat=True).names
    tilts, both = (landings(leaning, "faces6", count, nearly_flat=True) for count in (1, 7))
    assert max(tilts.normals @ bottom) >= SAME_LANDING
    assert "face 3 (bottom)" in landings(leaning, "faces6", 7, nearly_flat=False).names
    assert "face 3 (bottom)" not in both.names
    assert len(both.names) == len(tilts.names) + 5


def test_orientations_are_frozen_and_each_has_a_name_and_a_way():
    found = nearly_flat_of(BOX)
    with pytest.raises(ValueError, match="read-only"):
        found.normals[0, 0] = 1.0
    with pytest.raises(ValueError, match="one way and a name"):
        Orientations(np.array([UP, UP]), ("flat", "flat"), ("flat", "any landing"))
    with pytest.raises(ValueError, match="one way and a name"):
        Orientations(np.array([UP]), ("flat",), ())
    with pytest.raises(ValueError, match="normals must have shape"):
        Orientations(np.array([UP]), ("flat", "tilted"), ("flat", "any landing"))


# --- nearly flat --------------------------------------------------------------------------------------------------


def test_the_base_of_a_box_goes_down_on_each_of_its_sides_and_corners():
    """The unsafe side: no corner and no side is left out, and each is lowest in the landing that is named after it."""
    found = nearly_flat_of(BOX)
    sign = {"left": -1.0, "right": 1.0, "front": -1.0, "back": 1.0}
    touched = []
    for name, normal in zip(found.names[1:], found.normals[1:], strict=True):
        assert normal[2] == pytest.approx(np.cos(np.radians(TILT)))
        corners = lowest(BOX, normal)
        assert (corners[:, 2] == 0.0).all()
        words = re.fullmatch(r"tilted 3° onto the (.+) (side|corner)", name)
        assert len(corners) == {"side": 2, "corner": 1}[words[2]]
        for word in words[1].split():
            axis = 0 if word in ("left", "right") else 1
            assert (np.sign(corners[:, axis]) == sign[word]).all()
        touched.append((words[2], tuple(sorted(map(tuple, corners)))))
    assert len(set(touched)) == 8
    assert sum(what == "corner" for what, _ in touched) == 4


@pytest.mark.parametrize("outline", [regular(3, 7.0), regular(5), regular(6, 11.0), [(0, 0), (60, 0), (50, 30), (5, 25)]])
def test_every_corner_of_a_polygon_is_lowest_once_and_every_side_once(outline):
    part = standing(outline)
    found = nearly_flat_of(part)
    touched = [tuple(sorted(map(tuple, np.round(lowest(part, normal), 3)))) for normal in found.normals[1:]]
    places = [one.kind for one in touchdowns(part)]
    assert [len(corners) for corners in touched] == [{"side": 2, "corner": 1}[kind] for kind in places]
    assert len(set(touched)) == len(touched) == 2 * len(outline)


def test_a_round_part_is_tilted_evenly_to_six_azimuths():
    found = nearly_flat_of(standing(regular(60)))
    assert found.names == ("flat", "tilted 3° to the right", "tilted 3° to the right back", "tilted 3° to the left back",
                           "tilted 3° to the left", "tilted 3° to the left front", "tilted 3° to the right front")  # fmt: skip
    np.testing.assert_allclose(found.normals[1:].mean(axis=0), [0.0, 0.0, np.cos(np.radians(TILT))], atol=1e-12)


def test_landings_that_would_be_called_the_same_name_their_azimuth():
    """A nose has two sides that both face the right."""
    found = nearly_flat_of(standing([(-30, -20), (30, -20), (36, 0), (30, 20), (-30, 20)]))
    assert [name for name in found.names if "(" in name] == ["tilted 3° onto the right side (17°)", "tilted 3° onto the right side (343°)"]
    assert len(found.names) == 11


@pytest.mark.parametrize("name", ["wall_hook", "shelf_bracket", "bag_clip"])
@pytest.mark.parametrize("matrix", [about((0, 0, 1), 17.0), about((0, 0, 1), 90.0), about((0, 0, 1), 51.0) @ np.diag([1.0, -1.0, 1.0])])
def test_a_gallery_part_lands_nearly_flat_as_before_when_its_file_is_turned_or_mirrored(name, matrix):
    part = gallery.load(f"gallery:{name}")
    found = nearly_flat_of(moved(part, matrix)).normals @ matrix
    assert angle_apart(nearly_flat_of(part).normals, found) < 0.01


# --- directions ---------------------------------------------------------------------------------------------------


def test_directions_are_spread_over_the_sphere_but_for_the_cap_around_upright():
    found = fibonacci(64)
    tilts = np.degrees(np.arccos(found.normals[1:, 2]))
    assert tilts.min() > UPRIGHT_CAP
    shares = np.concatenate([[0.5 * (1.0 - np.cos(np.radians(UPRIGHT_CAP)))], np.full(63, 0.0)])
    shares[1:] = (1.0 - shares[0]) / 63
    np.testing.assert_allclose(shares @ found.normals, 0.0, atol=0.02)  # a whole sphere has its centre in the middle
    np.testing.assert_array_equal(directions(64), found.normals)


@pytest.mark.parametrize("poses", ["fibonacci", "resting", "faces6", "box26"])
@pytest.mark.parametrize("matrix", [about((0, 0, 1), 17.0), about((0, 0, 1), 90.0), about((0, 0, 1), 51.0) @ np.diag([1.0, -1.0, 1.0])])
def test_all_landings_turn_and_are_mirrored_with_the_file(poses, matrix):
    before = landings(WEDGE, poses, 27, nearly_flat=True)
    after = landings(moved(WEDGE, matrix), poses, 27, nearly_flat=True)
    assert len(before.names) == len(after.names) > 9
    assert angle_apart(before.normals, after.normals @ matrix) < 0.01


def test_a_file_that_is_turned_keeps_which_direction_is_which():
    matrix = about((0, 0, 1), 51.0) @ np.diag([1.0, -1.0, 1.0])
    before, after = (landings(part, "fibonacci", 9, nearly_flat=False) for part in (WEDGE, moved(WEDGE, matrix)))
    np.testing.assert_allclose(after.normals @ matrix, before.normals, atol=1e-9)


# --- resting poses ------------------------------------------------------------------------------------------------


def test_a_cube_rests_on_each_of_its_sides():
    found = resting(CUBE, ORIGIN, 24)
    assert len(found.normals) == 6
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


def test_a_part_that_does_not_stay_as_placed_rests_on_all_six_sides():
    found = resting(CUBE @ about((1.0, 0.0, 0.0), 30.0).T, ORIGIN, 24)
    assert len(found.normals) == 7


def test_a_part_that_rolls_is_covered_by_as_many_drops_as_asked_for():
    normals, chances = stable_poses(ROD, ORIGIN)
    sides = np.abs(normals[:, 2]) < 0.1
    assert len(normals) > 48
    assert chances[sides].sum() > 0.9
    found = resting(ROD, ORIGIN, 8)
    assert 5 <= len(found.normals) <= 8
    lying = found.normals[np.abs(found.normals[:, 2]) < 0.1]
    assert len(lying) >= 4
    np.testing.assert_allclose(lying.mean(axis=0), 0.0, atol=0.3)  # all around


def test_the_most_likely_pose_is_dropped_first_after_the_flat_one():
    found = resting(SLAB, SLAB.mean(axis=0), 24)
    normals, chances = stable_poses(SLAB, SLAB.mean(axis=0))
    likely = [chances[normals @ normal > SAME_LANDING].sum() for normal in found.normals]
    np.testing.assert_allclose(found.normals[1], [0.0, 0.0, -1.0], atol=1e-12)
    assert (np.diff(likely[1:]) <= 1e-12).all()
    assert likely[1] > likely[-1]


def test_directions_and_resting_poses_are_numbered_as_they_are_dropped():
    assert fibonacci(3).names == ("flat", "direction 1", "direction 2")
    assert resting(SLAB, SLAB.mean(axis=0), 8).names[:3] == ("flat", "resting pose 1", "resting pose 2")


# --- poses of a box -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("poses", "drops"), [("box26", 26), ("box10", 10), ("faces6", 6)])
def test_a_box_that_stands_is_not_dropped_on_its_bottom_twice(poses, drops):
    found = orientation_set(poses, POSES[poses], SLAB, SLAB.mean(axis=0))
    assert len(found.normals) == drops
    assert "face 3 (bottom)" not in found.names
    leaning = SLAB @ trimesh.transformations.rotation_matrix(0.2, (1.0, 0.4, 0.0))[:3, :3].T
    found = orientation_set(poses, POSES[poses], leaning, leaning.mean(axis=0))
    assert len(found.normals) == drops + 1 == POSES[poses]
    assert sum(name.startswith("face") for name in found.names) == 6


def test_half_a_degree_beside_flat_is_another_landing():
    """The near edge of a slab lands 0.3 mm before the far one."""
    leaning = SLAB @ about((0.0, 1.0, 0.0), 0.5).T
    assert len(orientation_set("faces6", 7, leaning, leaning.mean(axis=0)).normals) == 7


def test_unknown_poses_and_counts_are_refused():
    with pytest.raises(BadInput, match="unknown poses 'restin': did you mean 'resting'"):
        landings(BOX, "restin", 5, nearly_flat=True)
    for poses in POSES:
        with pytest.raises(BadInput, match="at least one orientation, not 0"):
            landings(BOX, poses, 0, nearly_flat=True)
