"""The box around a part: the smallest, seen as a package is, its faces, edges and corners with the centre of mass above them."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import trimesh

from mechstyle.fea.poses import AXIS_OF, MOST_FRAGILE, SIDES, box_around, named, places

CORNERS = np.array(list(itertools.product((0.0, 1.0), repeat=3))) * [60.0, 20.0, 40.0]
WEDGE = np.array([[0, 0, 0], [60, 0, 0], [60, 20, 0], [0, 20, 0], [0, 0, 35], [0, 20, 40]], dtype=float)
INSIDE = np.array([20.0, 9.0, 15.0])


def turned(degrees, axis=(1.0, 2.0, 3.0)):
    return trimesh.transformations.rotation_matrix(np.radians(degrees), axis)[:3, :3]


def corner(box, faces):
    """The place of a corner in the frame of the part [mm]."""
    place = np.zeros(3)
    for axis, side in (AXIS_OF[face] for face in faces):
        place[axis] = (box.high if side > 0.0 else box.low)[axis]
    return place @ box.axes


def test_an_upright_box_is_its_own_and_seen_from_the_front():
    box = box_around(CORNERS)
    np.testing.assert_array_equal(box.axes, np.eye(3))
    np.testing.assert_allclose((box.high - box.low), [60.0, 20.0, 40.0])
    outward = {SIDES[face]: -box.landing((face,), INSIDE) for face in SIDES}
    assert {name: normal.round(9).tolist() for name, normal in outward.items()} == {
        "top": [0, 0, 1], "right": [1, 0, 0], "bottom": [0, 0, -1], "left": [-1, 0, 0], "near end": [0, -1, 0], "far end": [0, 1, 0],
    }  # fmt: skip


@pytest.mark.parametrize("points", [CORNERS, WEDGE], ids=["box", "wedge"])
@pytest.mark.parametrize("degrees", [7.0, 20.0, 40.0])
def test_a_turned_part_has_the_same_box_turned(points, degrees):
    rotation = turned(degrees)
    upright, box = box_around(points), box_around(points @ rotation.T)
    np.testing.assert_allclose((box.high - box.low), (upright.high - upright.low), rtol=1e-9)
    for place in places("box26", upright):
        np.testing.assert_allclose(box.landing(place, rotation @ INSIDE), rotation @ upright.landing(place, INSIDE), atol=1e-9)


@pytest.mark.parametrize("seed", [0, 1])
def test_the_box_holds_the_part_and_no_box_on_a_facet_is_smaller(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(40, 3)) * [30.0, 12.0, 5.0] @ turned(33.0).T
    box = box_around(points)
    np.testing.assert_allclose(box.axes @ box.axes.T, np.eye(3), atol=1e-12)
    along = points @ box.axes.T
    np.testing.assert_allclose([along.min(axis=0), along.max(axis=0)], [box.low, box.high])
    _, extents = trimesh.bounds.oriented_bounds(points)
    assert np.prod(box.high - box.low) <= np.prod(extents) * (1.0 + 1e-6)
    assert np.prod(box.high - box.low) < np.prod(np.ptp(points, axis=0))


def test_the_box_of_a_cup_stands_as_the_cup_does():
    """A box that turns with the facets of a round wall is hardly smaller."""
    turn = np.linspace(0.1, 2.0 * math.pi + 0.1, 31, endpoint=False)
    rim = np.concatenate([np.stack([20.0 * np.cos(turn), 20.0 * np.sin(turn), np.full(31, z)], axis=1) for z in (0.0, 70.0)])
    np.testing.assert_array_equal(box_around(rim).axes, np.eye(3))


def test_a_round_part_with_thousands_of_facets_has_a_box():
    sphere = trimesh.creation.icosphere(subdivisions=4, radius=10.0).vertices
    box = box_around(sphere)
    np.testing.assert_allclose(box.high - box.low, 20.0, rtol=0.02)


def test_corners_and_edges_have_the_centre_of_mass_above_them():
    box = box_around(WEDGE @ turned(20.0).T)
    centre = turned(20.0) @ INSIDE
    for place in places("box26", box):
        normal = box.landing(place, centre)
        assert np.linalg.norm(normal) == pytest.approx(1.0)
        arm = centre - corner(box, place)
        if len(place) == 3:
            np.testing.assert_allclose(np.cross(normal, arm), 0.0, atol=1e-9)  # the corner itself, not the middle of the box, is below
            assert normal @ arm > 0.0
        if len(place) == 2:
            (along,) = {0, 1, 2} - {AXIS_OF[face][0] for face in place}
            assert abs(normal @ box.axes[along]) < 1e-12, "the whole edge touches the floor"
            np.testing.assert_allclose(np.cross(normal, arm - (arm @ box.axes[along]) * box.axes[along]), 0.0, atol=1e-9)
    of_the_box = np.sum([box.axes[AXIS_OF[face][0]] * -AXIS_OF[face][1] for face in MOST_FRAGILE] * (box.high - box.low)[:, None], axis=0)
    assert np.linalg.norm(np.cross(of_the_box, box.landing(MOST_FRAGILE, centre))) > 0.1, "the diagonal would be another pose"


def test_each_set_has_the_faces_edges_and_corners_of_its_standard():
    box = box_around(CORNERS)
    every = places("box26", box)
    assert [sum(len(place) == size for place in every) for size in (1, 2, 3)] == [6, 12, 8]
    assert len(set(every)) == 26
    assert not [place for place in every if {1, 3} <= set(place) or {2, 4} <= set(place) or {5, 6} <= set(place)]
    assert places("faces6", box) == ((1,), (2,), (3,), (4,), (5,), (6,))


def test_a_package_is_dropped_in_the_order_of_ista_1a():
    """60 × 20 × 40 mm: the edge along y is the shortest, the ends (60 × 40) are the largest faces."""
    box = box_around(CORNERS)
    first, *edges = places("box10", box)[:4]
    faces = places("box10", box)[4:]
    assert first == (2, 3, 5)
    assert edges == [(2, 3), (2, 5), (3, 5)]
    assert [box.length(edge) for edge in edges] == [20.0, 40.0, 60.0]
    assert faces == ((2,), (4,), (1,), (3,), (5,), (6,))
    assert [box.area(face) for (face,) in faces] == [800.0, 800.0, 1200.0, 1200.0, 2400.0, 2400.0]


def test_poses_of_a_box_are_named_by_the_numbers_of_the_faces_that_meet():
    assert (named((3,)), named((2, 3)), named((2, 3, 5))) == ("face 3 (bottom)", "edge 2-3", "corner 2-3-5")
