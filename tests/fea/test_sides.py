"""What is near on the same side of a wall, and what only looks near."""

import numpy as np
import pytest

from mechstyle.fea.sides import Sides
from mechstyle.records.mesh import TetMesh

UP, DOWN = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])


def beside(*parts):
    """Bodies that do not touch, as one mesh."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    tets = [part.tets + start for part, start in zip(parts, starts, strict=True)]
    return TetMesh(np.concatenate([part.vertices for part in parts]), np.concatenate(tets))


def facing(sides, direction):
    return sides._directions @ direction > 0.9


def around(sides, marked):
    """Within 3 mm, on a mesh without splinters."""
    return sides.around(marked, 3.0, np.zeros(len(sides.vertices), bool))


def test_points_share_the_area_and_follow_a_morph(box):
    mesh = box((5, 3, 2), (15.0, 8.0, 4.0))
    sides = Sides(mesh)
    assert sides.weights(mesh).sum() == pytest.approx(2 * (15 * 8 + 15 * 4 + 8 * 4))
    stretched = mesh.moved(mesh.vertices * [2.0, 1.0, 1.0])
    assert sides.weights(stretched).sum() == pytest.approx(2 * (30 * 8 + 30 * 4 + 8 * 4))
    heights = sides.points @ mesh.vertices[:, 2]
    assert sides.weights(mesh) @ heights == pytest.approx(2.0 * sides.weights(mesh).sum())  # the middle of the body
    assert np.diff(sides.points.indptr).max() == 3


def test_a_vertex_on_an_edge_is_a_spot_of_each_side_and_on_a_plane_of_one(box):
    sides = Sides(box((3, 3, 3), (9.0, 9.0, 9.0)))
    number = np.bincount(sides.vertices)
    on = np.isclose(sides._vertices % 9.0, 0.0).sum(axis=1)  # 1 in a face, 2 on an edge, 3 at a corner
    assert (number[on == 1] == 1).all()
    assert (number[on == 2] >= 2).all()
    assert (number[on == 3] >= 3).all()


@pytest.mark.parametrize("edge", [0.7, 1.0, 2.0, 4.0])
def test_the_points_within_reach_of_a_spot_are_those_of_a_disc_on_its_own_side(box, edge):
    """In a wall of 1 mm the other side is nearer than 2 mm, and so is the rim."""
    count = round(16.0 / edge)
    mesh = box((count, count, 1), (16.0, 16.0, 1.0))
    sides = Sides(mesh)
    area = sides.near(2.0) @ sides.weights(mesh)
    inner = facing(sides, UP) & (np.abs(sides.positions[:, :2] - 8.0).max(axis=1) < 5.0)
    assert area[inner] == pytest.approx(np.full(inner.sum(), 4.0 * np.pi), rel=0.2)
    points = sides.points @ mesh.vertices
    near = sides.near(2.0).tocsr()[np.flatnonzero(inner)]
    assert points[near.indices, 2] == pytest.approx(1.0)


def test_the_same_side_of_the_next_wall_is_not_near(box):
    """Two plates 0.5 mm apart: both look up, and lie within 2 mm of each other."""
    plate = box((10, 10, 1), (10.0, 10.0, 1.0))
    pair = beside(plate, plate.moved(plate.vertices + 1.5 * UP))
    sides = Sides(pair)
    heights = (sides.points @ pair.vertices)[:, 2]
    lower = facing(sides, UP) & np.isclose(sides.positions[:, 2], 1.0)
    assert heights[sides.near(2.0)[np.flatnonzero(lower)].indices] == pytest.approx(1.0)
    zone = around(sides, np.isclose(pair.vertices[:, 2], 0.0))
    assert zone[facing(sides, DOWN) & np.isclose(sides.positions[:, 2], 0.0)].all()
    assert not zone[np.isclose(sides.positions[:, 2], 1.5) | np.isclose(sides.positions[:, 2], 2.5)].any()


@pytest.mark.parametrize("thickness", [1.0, 2.0, 3.0])
def test_the_upper_side_of_a_floor_is_not_beside_what_its_underside_stands_on(box, thickness):
    mesh = box((10, 10, 2), (20.0, 20.0, thickness))
    sides = Sides(mesh)
    zone = around(sides, np.isclose(mesh.vertices[:, 2], 0.0))
    assert zone[facing(sides, DOWN)].all()
    assert not zone[facing(sides, UP)].any()


def test_a_chamfer_does_not_end_a_zone(box):
    """The wall begins 1.4 mm from where the floor ends, and looks 90° away from it."""
    straight = box((8, 8, 8), (8.0, 8.0, 8.0))
    vertices = straight.vertices.copy()
    vertices[np.isclose(vertices[:, 1:], 0.0).all(axis=1), 1:] = 0.5
    mesh = straight.moved(vertices)
    sides = Sides(mesh)
    zone = around(sides, np.isclose(vertices[:, 2], 0.0) & np.isclose(vertices[:, 0], 4.0))
    wall = facing(sides, np.array([0.0, -1.0, 0.0])) & np.isclose(sides.positions[:, 0], 4.0)
    assert wall.sum() >= 7
    assert np.array_equal(zone[wall], sides.positions[wall, 2] < 2.9)  # the floor ends at y = 1


def test_a_zone_reaches_so_far_round_an_edge_and_no_farther(box):
    """A plate stands on its narrow side: both large sides belong to the zone up to 3 mm."""
    mesh = box((1, 20, 20), (2.0, 20.0, 20.0))
    sides = Sides(mesh)
    zone = around(sides, np.isclose(mesh.vertices[:, 2], 0.0))
    for outwards in ([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]):
        large = facing(sides, np.array(outwards))
        assert np.array_equal(zone[large], sides.positions[large, 2] < 3.5)
    assert not around(sides, np.zeros(len(mesh.vertices), bool)).any()


@pytest.fixture
def plate(box):
    """A plate, and which of its spots are on its upper side within so much of the middle, all else of that side being a zone."""
    sides = Sides(box((24, 24, 2), (24.0, 24.0, 4.0)))
    above = facing(sides, UP) & np.isclose(sides.positions[:, 2], 4.0)
    return sides, above, lambda half_width: above & (np.abs(sides.positions[:, :2] - 12.0).max(axis=1) < half_width + 0.1)


@pytest.mark.parametrize(("half_width", "joins"), [(0.0, True), (1.0, False)])
def test_a_piece_that_a_zone_surrounds_belongs_to_it_unless_it_is_a_side_of_its_own(plate, half_width, joins):
    """Four faces around a vertex that is not in the zone, 4 mm² less rounding, and sixteen."""
    sides, above, within = plate
    scale = sides._areas.copy()
    sides._areas = 0.99 * scale
    found = sides._islands(above & ~within(half_width), np.ones(len(above), bool))
    assert found.any() == joins
    assert np.isin(sides.vertices[within(half_width)], sides.faces[found]).all() == joins


def test_a_piece_that_goes_on_beyond_the_reach_of_a_zone_is_no_part_of_it(plate):
    sides, above, within = plate
    sides._areas = 0.99 * sides._areas
    assert not sides._islands(above & ~within(0.0), above & ~within(0.0)).any()


def test_a_small_hole_inside_a_body_is_a_side_of_its_own_however_near(box):
    """Its surface of 2.4 mm² touches no zone; taken for an island, a mean over a ball would have read half of what its wall bears."""
    straight = box((9, 9, 9), (9.0, 9.0, 9.0))
    middle = straight.vertices[straight.tets].mean(axis=1)
    mesh = TetMesh(straight.vertices, straight.tets[~(np.abs(middle - [4.5, 4.5, 2.5]) < 0.5).all(axis=1)])
    hollow = mesh.moved(mesh.vertices)
    sides = Sides(hollow)
    inside = ((sides.positions > 0.5) & (sides.positions < 8.5)).all(axis=1)
    assert inside.sum() >= 8
    sides._areas = 0.4 * sides._areas  # of a cube of 1 mm, 6 mm²
    zone = sides.around(np.isclose(hollow.vertices[:, 2], 0.0), 5.0, np.zeros(len(sides.vertices), bool))
    looks_away = inside & (sides._directions[:, 2] > 0.9)
    assert looks_away.any()
    assert not zone[looks_away].any()


def test_ledges_of_bricks_next_to_a_contact_are_in_its_zone(box):
    """Pits in the side of a block that lands on its edge: their ledges look up, away from the floor, and are no other side of a wall."""
    straight = box((24, 6, 24), (12.0, 3.0, 12.0))
    vertices = straight.vertices.copy()
    pits = np.isclose(vertices[:, 1], 0.0) & (vertices[:, 0] % 2.0 < 0.75) & (np.abs(vertices[:, 2] - 1.75) < 0.3)
    vertices[pits, 1] = 1.5  # rows of vertices are 0.5 mm apart, so their walls are 72° steep
    sides = Sides(straight.moved(vertices))
    zone = sides.around(np.isclose(vertices[:, 2], 0.0), 3.0, np.zeros(len(sides.vertices), bool))
    near = (sides.positions[:, 2] < 2.1) & (np.abs(sides.positions[:, 0] - 6.0) < 4.0) & (sides.positions[:, 1] < 1.75)
    assert near.sum() > 60
    assert zone[near].all()
