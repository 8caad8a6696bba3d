"""What lies in a shape, whichever record names it, and which faces stand on the floor."""

import numpy as np
import pytest

from mechstyle.records.load_cases import Patch
from mechstyle.records.mesh import FLOOR_TOLERANCE, SurfaceMesh, in_ball, in_box, in_half_space, on_floor
from mechstyle.records.regions import Box, HalfSpace, Sphere

HALF = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
GRID = np.stack(np.meshgrid(HALF, HALF, HALF, indexing="ij"), axis=-1)
SHAPES = {
    "box": (Box((0.5, 1.0, 1.5), (2.0, 2.5, 3.0)), lambda x, y, z: (x >= 0.5) & (x <= 2) & (y >= 1) & (y <= 2.5) & (z >= 1.5) & (z <= 3)),
    "sphere": (Sphere((1.0, 1.5, 2.0), 1.5), lambda x, y, z: (x - 1) ** 2 + (y - 1.5) ** 2 + (z - 2) ** 2 <= 2.25),
    "plane": (HalfSpace((1.0, 1.0, 1.0), (1.0, -2.0, 4.0)), lambda x, y, z: (x - 1) + 4 * (z - 1) >= 2 * (y - 1)),
}


@pytest.mark.parametrize("kind", SHAPES)
def test_a_region_and_the_patch_of_it_hold_the_same_points_with_the_border(kind):
    region, expected = SHAPES[kind]
    inside = region.contains(GRID)
    assert inside.shape == GRID.shape[:-1]
    assert np.array_equal(inside, expected(*np.moveaxis(GRID, -1, 0)))
    assert np.array_equal(Patch.of(region).contains(GRID), inside)


@pytest.mark.parametrize(
    "shape",
    [
        lambda points, margin: in_box(points, (-1.0, -1.0, 0.0), (1.0, 1.0, 1.0), margin=margin),
        lambda points, margin: in_ball(points, (0.0, 0.0, 0.5), 0.5, margin=margin),
        lambda points, margin: in_half_space(points, (0.0, 0.0, 1.0), (0.0, 0.0, -7.0), margin=margin),
    ],
    ids=["box", "ball", "half-space"],
)
def test_a_margin_is_a_length_outside_the_border(shape):
    above = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.1], [0.0, 0.0, 1.3]])
    assert shape(above, 0.0).tolist() == [True, False, False]
    assert shape(above, 0.2).tolist() == [True, True, False]


def test_a_box_may_be_a_flat_piece_of_a_plane():
    assert in_box(np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 0.1]]), (0.0, 0.0, 0.0), (2.0, 2.0, 0.0)).tolist() == [True, False]


def turned(x_degrees: float) -> SurfaceMesh:
    """A tetrahedron whose underside, of 10 mm, is turned about the x axis."""
    angle = np.radians(x_degrees)
    corners = np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [2.0, 2.0, 10.0]])
    turn = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(angle), -np.sin(angle)], [0.0, np.sin(angle), np.cos(angle)]])
    return SurfaceMesh(corners @ turn.T, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def test_only_the_underside_stands_on_the_floor():
    assert on_floor(turned(0.0)).tolist() == [True, False, False, False]


def test_an_underside_that_is_small_and_low_but_steep_does_not():
    small = turned(6.0)
    assert not on_floor(small.moved(0.05 * small.vertices)).any()
    gentle = turned(4.0)
    assert on_floor(gentle.moved(0.05 * gentle.vertices)).any()


def test_an_underside_stands_if_all_its_corners_are_within_the_tolerance():
    raised = turned(0.0).vertices.copy()
    raised[2, 2] = 0.9 * FLOOR_TOLERANCE
    assert on_floor(turned(0.0).moved(raised)).any()
    raised[2, 2] = 1.1 * FLOOR_TOLERANCE
    assert not on_floor(turned(0.0).moved(raised)).any()
