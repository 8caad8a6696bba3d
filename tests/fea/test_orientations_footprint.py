"""What a part stands on: its sides and corners are those of the shape, however its file is turned, mirrored or meshed."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from mechstyle import gallery
from mechstyle.fea.orientations import footprint, own_frame, straight_sides, touchdowns
from mechstyle.geometry.remeshing.evening import even
from mechstyle.records.mesh import SurfaceMesh

WAYS = [(17.0, False), (51.0, False), (90.0, False), (0.0, True), (33.0, True)]
"""Turns about z [degrees], some of the mirrored part."""


def prism(outline, height=20.0):
    """A prism on a polygon that its first corner sees all of."""
    outline, n = np.asarray(outline, float), len(outline)
    ahead = np.roll(np.arange(n), -1)
    fan = np.stack([np.zeros(n - 2, int), np.arange(1, n - 1), np.arange(2, n)], axis=1)
    here = np.arange(n)
    walls = np.concatenate([np.stack([here, ahead, ahead + n], axis=1), np.stack([here, ahead + n, here + n], axis=1)])
    vertices = np.concatenate([np.column_stack([outline, np.full(n, z)]) for z in (0.0, height)])
    return SurfaceMesh(vertices, np.concatenate([fan[:, ::-1], fan + n, walls]))


def lifted(surface, x, z):
    return surface.moved(surface.vertices + np.array([x, 0.0, z]))


def together(*surfaces):
    """Several bodies in one surface."""
    starts = np.cumsum([0, *(len(one.vertices) for one in surfaces)])[:-1]
    faces = [one.faces + start for one, start in zip(surfaces, starts, strict=True)]
    return SurfaceMesh(np.concatenate([one.vertices for one in surfaces]), np.concatenate(faces))


def regular(count, radius=30.0, start=0.0):
    turn = np.radians(start) + 2.0 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)


def rounded(x, y, radius, facets=9):
    """A rectangle of two half sides with round corners."""
    quarter = np.linspace(0.0, np.pi / 2.0, facets)
    corners = [(x - radius, y - radius), (radius - x, y - radius), (radius - x, radius - y), (x - radius, radius - y)]
    arcs = [
        np.array(corner) + radius * np.stack([np.cos(quarter + turn), np.sin(quarter + turn)], axis=1)
        for corner, turn in zip(corners, np.pi / 2.0 * np.arange(4), strict=True)
    ]
    return np.concatenate(arcs)


def about_z(degrees):
    return trimesh.transformations.rotation_matrix(np.radians(degrees), (0, 0, 1))[:3, :3]


def moved(surface, degrees, mirrored):
    """A file turned about z, of the part or of its mirror image."""
    vertices, faces = (surface.vertices * [1.0, -1.0, 1.0], surface.faces[:, ::-1]) if mirrored else (surface.vertices, surface.faces)
    return SurfaceMesh(vertices @ about_z(degrees).T + np.array([3.0, -8.0, 5.0]), faces)


def meshed_again(surface, seed=0):
    """The same surface with triangles cut in four and vertices in another order."""
    vertices, faces = trimesh.remesh.subdivide(surface.vertices, surface.faces)
    order = np.random.default_rng(seed).permutation(len(vertices))
    return SurfaceMesh(vertices[order], np.argsort(order)[faces])


def seen(found, degrees=0.0, mirrored=False):
    """Azimuths and kinds from the part that a file was made of, as rows that can be compared: kind, azimuth [degrees]."""
    sign = -1.0 if mirrored else 1.0
    return [(one.kind, sign * (one.azimuth - degrees) % 360.0) for one in found]


def apart(some, others):
    """Largest angle between a place and the nearest of its kind among the others, both ways [degrees]; 180 if kinds differ."""
    if sorted(kind for kind, _ in some) != sorted(kind for kind, _ in others):
        return 180.0
    angles = np.array([[abs((a - b + 180.0) % 360.0 - 180.0) if one == other else 180.0 for other, b in others] for one, a in some])
    return max(angles.min(axis=0).max(), angles.min(axis=1).max())


RECTANGLE = [("side", 0.0), ("corner", 45.0), ("side", 90.0), ("corner", 135.0), ("side", 180.0), ("corner", 225.0), ("side", 270.0),
             ("corner", 315.0)]  # fmt: skip
ROUND = [("", 60.0 * place) for place in range(6)]
STADIUM = [("end", 0.0), ("side", 90.0), ("end", 180.0), ("side", 270.0)]
SHAPES = {
    "rectangle": ([(-30, -20), (30, -20), (30, 20), (-30, 20)], RECTANGLE),
    "triangle": (regular(3, start=-30.0), [(("side", "corner")[k % 2], 30.0 + 60.0 * k) for k in range(6)]),
    "L": (
        [(25, 25), (25, 60), (0, 60), (0, 0), (60, 0), (60, 25)],
        [("corner", 22.5), ("side", 45.0), ("corner", 67.5), ("side", 90.0), ("corner", 135.0), ("side", 180.0), ("corner", 225.0),
         ("side", 270.0), ("corner", 315.0), ("side", 0.0)],
    ),
    "hexagon": (regular(6), [(("corner", "side")[k % 2], 30.0 * k) for k in range(12)]),
    "round corners": (rounded(30.0, 20.0, 8.0), RECTANGLE),
    "chamfers": (rounded(30.0, 20.0, 3.0, 2), RECTANGLE),
    "stadium": (rounded(40.0, 15.0, 15.0), STADIUM),
    "narrow plate": ([(-30, -1), (30, -1), (30, 1), (-30, 1)], STADIUM),
    "half a disc": (regular(64, 20.0, -90.0)[:33], [("side", 180.0), *[("", 180.0 + 60.0 * k) for k in range(1, 6)]]),
    "oval": (regular(90) * [1.5, 1.0], STADIUM),
}  # fmt: skip


@pytest.mark.parametrize(("outline", "expected"), SHAPES.values(), ids=SHAPES)
def test_a_part_lands_on_every_side_and_corner_of_what_it_stands_on(outline, expected):
    assert apart(seen(touchdowns(prism(outline))), expected) < 1.0


@pytest.mark.parametrize("outline", [outline for outline, _ in SHAPES.values()], ids=SHAPES)
def test_turned_mirrored_or_meshed_again_a_part_lands_on_the_same_places(outline):
    part = prism(outline)
    places = seen(touchdowns(part))
    for degrees, mirrored in WAYS:
        other = meshed_again(moved(part, degrees, mirrored))
        assert apart(places, seen(touchdowns(other), degrees, mirrored)) < 0.1


@pytest.mark.parametrize("count", [7, 8, 12, 24, 100])
def test_a_base_of_more_than_six_sides_is_round_and_lands_on_six_azimuths(count):
    places = [one.azimuth for one in touchdowns(prism(regular(count)))]
    np.testing.assert_allclose(np.diff(places), 60.0, atol=0.03)
    assert {one.kind for one in touchdowns(prism(regular(count)))} == {""}


def test_a_coarse_round_of_uneven_facets_has_no_sides():
    turn = np.sort(np.random.default_rng(3).uniform(0.0, 2.0 * np.pi, 60))
    assert len(straight_sides(30.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1))) == 0


def test_a_round_corner_at_one_end_of_a_side_does_not_turn_it():
    outline = [*rounded(30.0, 20.0, 15.0)[:9], (-30, 20), (-30, -20), (30, -20)]
    np.testing.assert_allclose(straight_sides(np.array(outline, float)), [0.0, 90.0, 180.0, 270.0], atol=0.5)


def test_a_point_lands_all_around():
    ball = trimesh.creation.icosphere(4, 20.0)
    faces = [(0, 2, 1), (0, 3, 2), (0, 4, 3), (0, 1, 4), (1, 2, 3), (1, 3, 4)]
    cone = SurfaceMesh([(0, 0, 0), *np.column_stack([regular(4), np.full(4, 40.0)])], faces)
    for surface in (SurfaceMesh(ball.vertices, ball.faces), cone):
        assert [one.kind for one in touchdowns(surface)] == [""] * 6


def test_places_come_by_azimuth_from_the_right():
    azimuths = [one.azimuth for one in touchdowns(moved(prism(SHAPES["rectangle"][0]), -1e-7, mirrored=False))]
    np.testing.assert_allclose(azimuths, [360.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0], atol=1e-6)


def test_what_stands_on_three_feet_has_the_sides_between_them():
    feet = [prism(np.array(middle) + regular(24, 3.0), 5.0) for middle in regular(3, 40.0, 90.0)]
    table = together(*feet, lifted(prism(regular(64, 60.0)), 0.0, 5.0))
    expected = [(("side", "corner")[k % 2], 30.0 + 60.0 * k) for k in range(6)]
    assert apart(seen(touchdowns(table)), expected) < 0.5


def test_the_outline_does_not_depend_on_where_vertices_are():
    """A round bar that lies is cut above the floor: one row of vertices of its mesh alone would be a line."""
    for facets in (24, 25, 60):
        bar = prism(regular(facets, 8.0, 7.0), 60.0)
        lying = bar.moved(bar.vertices[:, [0, 2, 1]])
        assert np.ptp(footprint(lying), axis=0)[0] == pytest.approx(2.0 * np.sqrt(2 * 8.0 * 0.3), rel=0.15)
        assert apart(seen(touchdowns(lying)), [("side", 0.0), ("end", 90.0), ("side", 180.0), ("end", 270.0)]) < 1.0


def test_points_on_a_line_are_outlined_by_its_ends():
    flat = SurfaceMesh([(0, 0, 0), (10, 20, 0), (5, 10, 0), (0, 0, 9)], [(0, 1, 3), (0, 2, 1)])
    assert sorted(map(tuple, np.round(footprint(flat), 6))) == [(0.0, 0.0), (10.0, 20.0)]


@pytest.mark.parametrize("name", ["wall_hook", "phone_stand", "book_end", "bag_clip", "bottle_opener", "coat_hook", "soap_dish"])
def test_files_of_a_gallery_part_land_on_the_same_places(name):
    part = gallery.load(f"gallery:{name}")
    places = seen(touchdowns(part))
    assert {"side", "corner", "end"} & {kind for kind, _ in places}
    for degrees, mirrored in WAYS:
        assert apart(places, seen(touchdowns(moved(part, degrees, mirrored)), degrees, mirrored)) < 0.1


@pytest.mark.parametrize(("name", "degrees", "mirrored"), [("wall_hook", 17.0, False), ("book_end", 33.0, True)])
def test_a_gallery_part_meshed_with_few_vertices_lands_on_the_same_places(name, degrees, mirrored):
    part = gallery.load(f"gallery:{name}")
    again = even(moved(part, degrees, mirrored), 2000)
    assert apart(seen(touchdowns(part)), seen(touchdowns(again), degrees, mirrored)) < 1.0


# --- the part's own frame -----------------------------------------------------------------------------------------

CHIRAL = prism([(0, 0), (60, 0), (70, 14), (8, 30)])


def cup():
    """A round part with a handle above the floor, towards azimuth 20°."""
    lug = lifted(prism([(0, -4), (14, -4), (14, 4), (0, 4)]), 30.0, 15.0)
    return together(prism(regular(72), 50.0), lug.moved(lug.vertices @ about_z(20.0).T))


@pytest.mark.parametrize(("degrees", "mirrored"), WAYS)
@pytest.mark.parametrize("part", [CHIRAL, gallery.load("gallery:shelf_bracket")], ids=["prism", "bracket"])
def test_the_frame_turns_and_is_mirrored_with_the_part(part, degrees, mirrored):
    expected = own_frame(part) @ np.diag([1.0, -1.0 if mirrored else 1.0, 1.0]) @ about_z(degrees).T
    found = own_frame(moved(part, degrees, mirrored))
    np.testing.assert_allclose(found[0], expected[0], atol=1e-9)
    if part is CHIRAL:
        np.testing.assert_allclose(found, expected, atol=1e-9)
        np.testing.assert_allclose(own_frame(meshed_again(moved(part, degrees, mirrored))), expected, atol=1e-9)
        assert np.linalg.det(found) * np.linalg.det(own_frame(part)) == pytest.approx(-1.0 if mirrored else 1.0)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(("degrees", "mirrored"), WAYS)
def test_a_round_base_lands_on_azimuths_that_follow_the_rest_of_the_part(degrees, mirrored):
    part = cup()
    places = seen(touchdowns(part))
    assert apart(places, [("", 20.0 + 60.0 * k) for k in range(6)]) < 0.5
    assert apart(places, seen(touchdowns(moved(part, degrees, mirrored)), degrees, mirrored)) < 0.1


def test_a_part_of_nine_lobes_is_turned_by_no_more_than_a_lobe():
    angle = np.linspace(0.0, 2.0 * np.pi, 180, endpoint=False)
    lobes = (30.0 + 3.0 * np.cos(9.0 * (angle - 0.2)))[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    for degrees, mirrored in WAYS:
        first = own_frame(moved(prism(lobes), degrees, mirrored))[0]
        ((_, azimuth),) = seen([touchdowns(CHIRAL)[0]._replace(azimuth=np.degrees(np.arctan2(first[1], first[0])))], degrees, mirrored)
        assert abs((azimuth - np.degrees(0.2) + 20.0) % 40.0 - 20.0) < 0.1


def test_a_solid_of_revolution_has_the_axes_of_its_file():
    np.testing.assert_array_equal(own_frame(prism(regular(72))), np.eye(3))
