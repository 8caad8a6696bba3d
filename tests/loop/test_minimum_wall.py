"""The thinnest wall: how a cut is slowed and stopped, and what is said where a wall is too thin."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from mechstyle.loop.minimum_wall import SEEN, freedom, room, spared, styled_thickness, warnings
from mechstyle.records.mesh import SurfaceMesh

FEW = {"min_size": 1, "max_size": 8}
thicknesses = st.lists(st.floats(0.0, 10.0, width=32), **FEW).map(lambda values: np.array(values, np.float32))
minima = st.floats(0.05, 3.0)


def slab(height):
    """30 x 20 mm, with vertices every 2 mm or closer, about the origin."""
    box = trimesh.creation.box((30.0, 20.0, height))
    vertices, faces = trimesh.remesh.subdivide_to_size(box.vertices, box.faces, 2.0)
    merged = trimesh.Trimesh(vertices, faces, process=True)
    return SurfaceMesh(merged.vertices, merged.faces)


@pytest.fixture(scope="module")
def plate():
    """1.2 mm thick."""
    return slab(1.2)


def top(plate):
    return (plate.vertex_normals[:, 2] > 0.99).astype(np.float32)


def thick(plate):
    return np.full(len(plate.vertices), 1.2, np.float32)


@pytest.mark.parametrize(("left", "factor"), [(5.0, 1.0), (1.2, 1.0), (1.0, 0.5), (0.8, 0.0), (0.3, 0.0)])
def test_cutting_is_slowed_from_half_the_minimum_above_it_and_stops_at_it(left, factor):
    depth = 0.5 * (5.0 - left)
    assert freedom(np.float32([5.0]), np.float32([-depth]), 0.8) == pytest.approx([factor], abs=1e-5)
    assert freedom(np.float32([left]), np.float32([0.3]), 0.8) == pytest.approx([factor], abs=1e-5)


def test_there_is_room_as_far_as_nothing_is_slowed_and_none_in_a_thin_wall():
    thickness = np.float32([5.0, 1.2, 0.3])
    assert room(thickness, 0.8) == pytest.approx([1.9, 0.0, 0.0], abs=1e-6)
    deepest = -np.float32([1.9, 1.95])
    assert freedom(np.float32([5.0, 5.0]), deepest, 0.8) == pytest.approx([1.0, 0.75], abs=1e-5)


@given(st.floats(0.0, 10.0), st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=8), minima)
def test_the_deeper_the_cut_the_less_freedom(thickness, depths, minimum):
    D = np.sort(np.array(depths, np.float32))
    factor = freedom(np.full_like(D, thickness), D, minimum)
    assert np.all(np.diff(factor) >= 0.0)
    assert np.all((factor >= 0.0) & (factor <= 1.0))


@given(thicknesses, minima, st.lists(st.floats(-1.5, 1.5), min_size=1, max_size=20))
def test_two_sides_together_never_cut_below_the_minimum(thickness, minimum, steps):
    D = np.zeros_like(thickness)
    for step in steps:
        D = D + spared(np.full_like(D, step), thickness, D, minimum)
        inwards = np.minimum(D, 0.0)
        assert np.all(thickness + 2.0 * inwards >= np.minimum(minimum, thickness) - 1e-4)


def test_outward_movement_is_free_and_a_wall_too_thin_from_the_start_is_not_cut():
    thickness, D = np.float32([0.5, 0.5, 3.0]), np.zeros(3, np.float32)
    assert spared(np.float32([0.4, -0.4, -0.4]), thickness, D, 0.8) == pytest.approx([0.4, 0.0, -0.4])
    assert spared(np.float32([0.4, -0.4, -0.4]), thickness, D, 0.0) == pytest.approx([0.4, -0.4, -0.4])


@given(thicknesses, minima, st.floats(0.0, 2.0), st.floats(-3.0, 3.0))
def test_a_bump_counts_for_nothing(thickness, minimum, bump, step):
    """The wall left is reckoned without what the style has put on: over a bump a step is held back as on the bare wall."""
    wanted, bare = np.full_like(thickness, step), np.zeros_like(thickness)
    assert np.array_equal(freedom(thickness, bare + np.float32(bump), minimum), freedom(thickness, bare, minimum))
    assert np.array_equal(spared(wanted, thickness, bare + np.float32(bump), minimum), spared(wanted, thickness, bare, minimum))


@given(st.floats(2.0, 10.0), st.floats(0.05, 1.0))
def test_one_long_step_may_use_all_that_is_above_the_minimum(thickness, minimum):
    """Twice as thick as the minimum or more is free, so a step of any length is cut short where both sides leave just the minimum."""
    depth = spared(np.float32([-20.0]), np.float32([thickness]), np.float32([0.0]), minimum)
    assert thickness + 2.0 * depth == pytest.approx([minimum], abs=1e-5)


def test_a_deeper_cut_from_another_run_is_neither_deepened_nor_filled():
    assert spared(np.float32([-0.2]), np.float32([2.0]), np.float32([-0.9]), 0.8) == pytest.approx([0.0])


def test_a_wall_is_what_both_sides_leave_of_it(plate):
    outer = top(plate)
    lower = (plate.vertex_normals[:, 2] < -0.99).astype(np.float32)
    inner = (np.abs(plate.vertices[:, 0]) < 12.0) & (np.abs(plate.vertices[:, 1]) < 7.0)
    styled = styled_thickness(plate, thick(plate), -0.3 * outer - 0.2 * lower)
    assert styled[(outer > 0) & inner] == pytest.approx(0.7, abs=1e-5)
    assert styled_thickness(plate, thick(plate), 0.5 * outer) == pytest.approx(1.2)


@pytest.mark.parametrize("height", [0.5, 1.0, 6.0])
def test_the_other_side_of_a_wall_is_found_however_thick_it_is(height):
    plate = slab(height)
    cut = np.where(plate.vertex_normals[:, 2] < -0.99, -0.1, 0.0).astype(np.float32)
    seen = (plate.vertex_normals[:, 2] > 0.99) & (np.abs(plate.vertices[:, :2]) < [8.0, 3.0]).all(axis=1)
    assert seen.any()
    styled = styled_thickness(plate, np.full(len(cut), height, np.float32), cut)
    assert styled[seen] == pytest.approx(height - 0.1, abs=1e-5)


@pytest.mark.parametrize("vertex", [0, 1, 50, -2, -1])
def test_one_thin_vertex_is_no_thin_wall_wherever_it_is(plate, vertex):
    speck = thick(plate)
    speck[vertex] = 0.1
    assert warnings(plate, speck, np.zeros_like(speck), 0.8) == ()


def test_a_wall_less_than_two_hundredths_below_the_minimum_is_rounding(plate):
    """… and one exactly there still is; the part's own walls and what the style leaves are judged alike."""
    for below, told in ((-0.01, 0), (0.0, 0), (0.018, 0), (SEEN, 0), (0.022, 1), (0.1, 1)):
        wall, bare = np.full(len(plate.vertices), 0.5, np.float32), np.zeros(len(plate.vertices), np.float32)
        assert 0.5 + SEEN - SEEN == 0.5
        minimum = 0.5 + SEEN if below == SEEN else 0.5 + below
        assert len(warnings(plate, wall, bare, minimum)) == told
        assert len(warnings(plate, 2.0 * wall, bare - np.float32(0.25), minimum)) == told


def test_a_style_that_cuts_no_deeper_than_rounding_is_not_blamed_for_a_thin_wall(plate):
    wall = np.full(len(plate.vertices), 0.5, np.float32)
    for cut, told in ((0.0, 1), (0.004, 1), (0.03, 2)):
        assert len(warnings(plate, wall, np.full_like(wall, -cut), 0.8)) == told


def test_a_part_of_which_only_one_end_is_thin_is_told_so_at_its_thinnest(plate):
    x = plate.vertices[:, 0]
    wall = np.where(x < -5.0, 0.6, 1.2).astype(np.float32)
    wall[x < -10.0] = 0.4
    (sentence,) = warnings(plate, wall, np.zeros_like(wall), 0.8)
    value, place = sentence.removeprefix("the part itself has a wall of ").split(" mm at (")
    assert value == "0.40"
    assert float(place.split(",")[0]) < -10.0


def test_a_wall_cut_through_is_no_wall_and_none_of_negative_thickness(plate):
    (sentence,) = warnings(plate, thick(plate), -2.0 * top(plate), 0.8)
    assert sentence.startswith("the style leaves a wall of 0.00 mm at (")


def test_one_vertex_or_a_sharp_edge_is_no_thin_wall(plate):
    speck = thick(plate)
    speck[[7, 100]] = 0.1
    assert warnings(plate, speck, np.zeros_like(speck), 0.8) == ()


def test_a_wall_that_is_too_thin_is_told_with_place_and_value(plate):
    dent = -0.6 * top(plate) * (np.linalg.norm(plate.vertices[:, :2] - [5.0, 3.0], axis=1) < 2.5)
    (sentence,) = warnings(plate, thick(plate), dent.astype(np.float32), 0.8)
    assert sentence.startswith("the style leaves a wall of 0.60 mm at (")
    assert "thinner than the 0.8 mm minimum" in sentence
    (sentence,) = warnings(plate, thick(plate), 0.0 * dent, 1.5)
    assert sentence.startswith("the part itself has a wall of 1.20 mm at (")
    assert len(warnings(plate, thick(plate), dent, 1.5)) == 2
    assert warnings(plate, thick(plate), -0.2 * top(plate), 0.8) == ()
