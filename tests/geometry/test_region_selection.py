"""Which vertices a region holds, how its ramp fades, and where segments end."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.geometry.borders import Extent
from mechstyle.geometry.region_selection import faded, protection, segments, selected
from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.geometry.thickness import local_thickness
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.regions import Box, End, HalfSpace, Holes, Inside, Outside, Rim, Segment, Sides, Sphere, Vertices
from support.bench import grid


@pytest.fixture(scope="module")
def thickness(cup):
    return local_thickness(cup)


def sheet(side=40.0, step=1.0):
    """A flat square with vertices every `step` mm, away from the origin."""
    flat = grid(round(side / step) + 1, step)
    return flat.moved(flat.vertices + np.array([50.0, -30.0, 20.0]))


def across(surface):
    """The way from the sheet's edge along x [mm]."""
    return surface.vertices[:, 0] - surface.vertices[:, 0].min()


def drum(sides):
    """A closed drum of 20 mm diameter whose mantle turns by a `sides`-th of a circle between neighbours; rings 2 mm apart."""
    outline = [(r, 0.0) for r in (2, 4, 6, 8, 10)] + [(10, z) for z in range(2, 20, 2)] + [(r, 20.0) for r in (10, 8, 6, 4, 2)]
    turn = 2.0 * np.pi * np.arange(sides) / sides
    rings = [np.stack([r * np.cos(turn), r * np.sin(turn), np.full(sides, float(z))], axis=1) for r, z in outline]
    one, last, around = np.arange(sides), (len(rings) - 1) * sides, np.roll(np.arange(sides), -1)
    faces = [np.stack([np.full(sides, len(rings) * sides), around, one], axis=1)]
    for base in range(0, last, sides):
        faces += [np.stack([base + one, base + around, base + sides + around], axis=1),
                  np.stack([base + one, base + sides + around, base + sides + one], axis=1)]  # fmt: skip
    faces.append(np.stack([np.full(sides, len(rings) * sides + 1), last + one, last + around], axis=1))
    return SurfaceMesh(np.concatenate([*rings, [[0.0, 0.0, 0.0], [0.0, 0.0, 20.0]]]), np.concatenate(faces))


def test_shapes_hold_what_lies_in_them(cup, thickness):
    points = cup.vertices
    for region, expected in (
        (Box((0, -30, -1), (30, 30, 15)), (points[:, 0] >= 0) & (points[:, 2] <= 15)),
        (Sphere((20, 0, 15), 8), np.linalg.norm(points - [20, 0, 15], axis=1) <= 8),
        (HalfSpace((0, 0, 20), (0, 0, 7)), points[:, 2] >= 20),
        (HalfSpace((0, 0, 20), (1, 0, -1)), points[:, 0] >= points[:, 2] - 20),
        (End("top"), points[:, 2] >= 0.5 * (points[:, 2].min() + points[:, 2].max())),
        (End("left", 4.0), points[:, 0] <= points[:, 0].min() + 4.0),
        (End("front"), points[:, 1] <= 0.5 * (points[:, 1].min() + points[:, 1].max())),
        (Sides(), np.abs(cup.vertex_normals[:, 2]) < np.sqrt(0.5)),
        (Vertices((5, 0, 7)), np.isin(np.arange(len(points)), [0, 5, 7])),
    ):
        assert np.array_equal(selected(region, cup, thickness), expected)


def test_a_rim_is_the_band_around_the_opening_of_a_cup_on_both_sides_of_its_wall(cup, thickness):
    z, inside = cup.vertices[:, 2], selected(Inside(), cup, thickness)
    rim = selected(Rim(6.0), cup, thickness)
    assert z[rim].min() > z.max() - 8.0
    assert rim[z > z.max() - 2.0].all()
    assert rim[inside].any()
    assert rim[~inside].any()
    assert rim.sum() < selected(Rim(12.0), cup, thickness).sum()
    assert selected(Rim(), cup, thickness).any()


def test_a_part_without_an_opening_has_no_rim(cube):
    with pytest.raises(BadInput, match="the region 'rim' holds nothing of this part"):
        selected(Rim(), cube, np.full(len(cube.vertices), 10.0))


def drilled():
    """A block of 40 x 30 x 20 mm with a bore of 6 mm right through, one of 4 mm that ends, and a pocket of 20 mm."""
    rod = manifold3d.Manifold.cylinder
    body = manifold3d.Manifold.cube((40, 30, 20)) - rod(40, 3, 3, 32).translate((8, 8, -10)) - rod(20, 2, 2, 32).translate((8, 22, 10))
    return even(surface_of(body - manifold3d.Manifold.cube((14, 20, 20)).translate((20, 5, 8))), 4000)


def test_holes_are_bores_with_their_floors_and_rims_and_neither_pockets_nor_faces():
    mesh = drilled()
    x, y, z = mesh.vertices.T
    through, blind = np.hypot(x - 8, y - 8), np.hypot(x - 8, y - 22)
    walls = ((through < 3.05) & (z > 0.1) & (z < 19.9)) | ((blind < 2.05) & (z > 9.9) & (z < 19.9))
    held = selected(Holes(), mesh, np.ones(len(z)))
    assert walls.sum() > 60
    assert held[walls].all()
    assert held[(blind < 1.5) & (z < 10.1) & (z > 9.9)].all(), "its floor"
    assert held[(through < 3.4) & (z > 19.9)].all(), "its rim"
    assert not held[(through > 5) & (blind > 5)].any(), "neither the pocket nor a face"
    narrow = selected(Holes(5.0), mesh, np.ones(len(z)))
    assert narrow[walls & (blind < 2.05)].all()
    assert not narrow[walls & (through < 3.05)].any()
    assert selected(Holes(25.0), mesh, np.ones(len(z)))[(x > 21) & (x < 33) & (y > 6) & (y < 24) & (z < 8.1) & (z > 7.9)].all()


def test_a_part_without_holes_has_none(cube):
    with pytest.raises(BadInput, match="the region 'holes' holds nothing of this part"):
        selected(Holes(), cube, np.full(len(cube.vertices), 10.0))


def test_a_shape_holds_its_border(cube):
    points = cube.vertices
    for region, expected in (
        (Box((0, 0, 0), (10, 10, 5)), points[:, 2] == 0),
        (Box((-5, -5, 10), (10, 10, 15)), points[:, 2] == 10),
        (Sphere((0, 0, 0), 10), np.linalg.norm(points, axis=1) <= 10),
        (HalfSpace((3, 3, 10), (0, 0, 2)), points[:, 2] == 10),
        (HalfSpace((3, 3, 9.95), (0, 0, 1)), points[:, 2] == 10),
        (HalfSpace((3, 3, 0.05), (0, 0, -1)), points[:, 2] == 0),
    ):
        assert np.array_equal(selected(region, cube, np.ones(8)), expected)
    with pytest.raises(BadInput, match="holds nothing"):
        selected(HalfSpace((0, 0, 10.05), (0, 0, 1)), cube, np.ones(8))


def test_outside_is_what_is_not_inside(cup, thickness):
    assert np.array_equal(selected(Outside(), cup, thickness), ~selected(Inside(), cup, thickness))


def test_a_region_that_holds_nothing_is_refused_and_told_where_the_part_is(cup, thickness):
    with pytest.raises(BadInput, match=r"'sphere 500 0 0 3' holds nothing of this part, which reaches from -20 -20 0 to 20 20 30 mm"):
        selected(Sphere((500, 0, 0), 3), cup, thickness)


def test_a_vertex_that_is_not_there_is_refused(cup, thickness):
    count = len(cup.vertices)
    for beyond in (99999, count):
        with pytest.raises(BadInput, match=f"vertex {beyond} cannot be protected: the standardised surface has vertices 0 to {count - 1}"):
            selected(Vertices((0, beyond)), cup, thickness)
    assert np.flatnonzero(selected(Vertices((count - 1,)), cup, thickness)).tolist() == [count - 1]


def test_where_the_part_is_is_told_to_a_tenth_of_a_millimetre(cube):
    with pytest.raises(BadInput, match=r"which reaches from 0\.4 0\.4 0\.4 to 12\.8 12\.8 12\.8 mm"):
        selected(Sphere((500, 0, 0), 3), cube.moved(1.234 * cube.vertices + 0.42), np.ones(8))


def test_the_note_tells_the_share_of_the_area(cube):
    (note,) = protection([HalfSpace((0, 0, 5), (0, 0, 1))], cube, np.ones(8)).notes
    assert note == "protected: above 5, 50% of the surface"


def test_protecting_all_of_a_part_is_refused(cup, thickness):
    with pytest.raises(BadInput, match="nothing is left to style"):
        protection([Inside(), Outside()], cup, thickness)


def test_without_regions_all_is_free(cup, thickness):
    free = protection([], cup, thickness)
    assert np.all(free.freedom == 1.0)
    assert not free.uncoloured.any()
    assert free.notes == ()


def test_the_strictest_region_counts_and_each_keeps_its_own_colour_rule(cup, thickness):
    low, high = HalfSpace((0, 0, 10), (0, 0, -1), ramp=20, colour=True), HalfSpace((0, 0, 25), (0, 0, 1))
    both = protection([low, high], cup, thickness)
    height = cup.vertices[:, 2]
    assert np.array_equal(both.freedom == 0.0, (height <= 10) | (height >= 25))
    assert np.array_equal(both.uncoloured == 1.0, height <= 10)
    each = [protection([one], cup, thickness).freedom for one in (low, high)]
    assert np.array_equal(both.freedom, np.minimum(*each))
    assert both.notes[1].startswith("protected: above 25, ")


def test_a_ramp_rises_by_the_way_along_the_surface(cup):
    below = cup.vertices[:, 2] <= 10
    free = faded(Extent(cup, below), 8.0)
    outer = (np.linalg.norm(cup.vertices[:, :2], axis=1) > 19.5) & (cup.vertices[:, 2] > 10)
    way = cup.vertices[outer, 2] - 10
    assert np.all(free[below] == 0.0)
    # Ways along edges are up to a seventh longer than straight ones, and begin at the last chosen vertex below.
    assert np.all(free[outer] >= np.minimum(way / 8.0, 1.0) - 1e-9)
    assert np.all(free[outer] <= np.minimum((1.16 * way + 3.0) / 8.0, 1.0))


@pytest.mark.parametrize("ramp", [1.0, 3.0, 8.0])
@pytest.mark.parametrize("edge", ["first", "last"])
def test_along_straight_edges_a_ramp_is_a_straight_line_from_either_side(ramp, edge):
    flat = sheet(10.0, 0.5)
    way = across(flat) if edge == "first" else across(flat).max() - across(flat)
    assert faded(Extent(flat, way == 0.0), ramp) == pytest.approx(np.minimum(way / ramp, 1.0))


@pytest.mark.parametrize("ramp", [0.0, 1.0, 8.0])
def test_around_nothing_nothing_fades(cube, ramp):
    assert np.array_equal(faded(Extent(cube, np.zeros(8, bool)), ramp), np.ones(8))


def test_a_ramp_does_not_reach_through_a_wall(cup, thickness):
    """The wall is 3 mm thick, the ramp 6 mm long: outside, away from the rim, nothing may fade."""
    freedom = protection([Inside(ramp=6.0)], cup, thickness).freedom
    outer = (np.linalg.norm(cup.vertices[:, :2], axis=1) > 19.5) & (cup.vertices[:, 2] < 20)
    assert np.all(freedom[outer] == 1.0)


def test_a_cube_has_six_segments(block):
    labels = segments(block, local_thickness(block))
    assert labels.max() + 1 == 6
    centre = block.vertices - block.vertices.mean(axis=0)
    away_from_edges = np.sort(np.abs(centre), axis=1)[:, 1] < 7.0
    side = 2 * np.abs(centre).argmax(axis=1) + (centre[np.arange(len(centre)), np.abs(centre).argmax(axis=1)] > 0)
    for label in range(6):
        assert len(set(side[away_from_edges & (labels == label)])) == 1


def test_where_nothing_is_smooth_all_is_one_segment(cube):
    assert segments(cube, np.ones(8)).tolist() == [0] * 8


@pytest.mark.parametrize(("sides", "count"), [(16, 3), (15, 3), (14, 2), (13, 2)])
def test_a_segment_ends_where_neighbours_turn_by_more_than_25_degrees(sides, count):
    """22.5° and 24° leave a mantle between two ends; of 25.7° and 27.7° only the ends are smooth."""
    surface = drum(sides)
    labels = segments(surface, np.full(len(surface.vertices), 3.0))
    assert np.unique(labels).tolist() == list(range(count))
    radius, height = np.linalg.norm(surface.vertices[:, :2], axis=1), surface.vertices[:, 2]
    for end in (height == 0.0, height == 20.0):
        assert len(set(labels[end & (radius < 9.0)])) == 1
    assert len(set(labels[(radius > 9.0) & (height > 4.0) & (height < 16.0)])) == (1 if count == 3 else 2)


@pytest.mark.parametrize(
    ("wall", "border"),
    [
        (lambda x: np.where(x < 20.5, 3.0, 5.7), False),  # 1.9 times as thick in a step
        (lambda x: np.where(x < 20.5, 3.0, 6.3), True),  # 2.1 times
        (lambda x: np.where(x < 20.5, 6.3, 3.0), True),
        (lambda x: np.clip(2.0 + 0.68 * (x - 15.0), 2.0, 8.0), False),  # four times as thick, but not steeply
        (lambda x: np.clip(2.0 + 0.75 * (x - 15.0), 2.0, 8.0), True),
        (lambda x: np.where(x < 20.5, 4.0, np.where(x < 24.5, 5.0, 9.0)), True),  # 9 mm within 1.5 x 4 mm of a step of 1 mm
        (lambda x: np.where(x < 20.5, 4.0, np.where(x < 26.5, 5.0, 9.0)), False),  # beyond
    ],
)
@pytest.mark.parametrize("spacing", [0.5, 1.0])
def test_a_segment_ends_where_the_wall_doubles_steeply(wall, border, spacing):
    """A flat sheet whose wall is known at every vertex; what lies in the border goes to the nearer side."""
    flat = sheet(step=spacing)
    x = across(flat)
    labels = segments(flat, wall(x))
    assert labels.max() == int(border)
    if border:
        turn = x[labels == labels[-1]].min()
        assert 15.0 <= turn <= 24.0
        assert np.array_equal(labels, np.where(x < turn, labels[0], labels[-1]))


@pytest.mark.parametrize(("sides", "count"), [((4, 4), 1), ((4, 5), 2)])
def test_half_a_per_cent_of_the_area_is_a_segment_of_its_own(sides, count):
    """On 3600 mm² that is 18 mm²; of a boss three times as thick the outermost vertices belong to its border."""
    flat = sheet(60.0)
    x, y = (flat.vertices[:, axis] - flat.vertices[:, axis].min() for axis in (0, 1))
    boss = (x >= 30) & (x < 32 + sides[0]) & (y >= 30) & (y < 32 + sides[1])
    assert len(np.unique(segments(flat, np.where(boss, 6.0, 2.0)))) == count


def test_a_border_goes_to_the_segment_nearest_along_the_surface():
    flat = sheet()
    for thick in (across(flat) > 20.5, across(flat) < 20.5):
        labels = segments(flat, np.where(thick, 9.0, 3.0))
        assert labels.tolist() == np.where(across(flat) > 20.5, labels[-1], labels[0]).tolist()


def test_a_piece_without_a_segment_that_no_way_leads_to_goes_with_the_first(cube):
    """Four smooth quarters of a sheet, numbered across, and, far away, a cube on which nothing is smooth."""
    flat = sheet()
    swapped = np.arange(len(flat.vertices))
    swapped[[1, -5]] = swapped[[-5, 1]]
    flat = SurfaceMesh(flat.vertices[swapped], swapped[flat.faces])
    x, y = (flat.vertices[:, axis] - flat.vertices[:, axis].min() for axis in (0, 1))
    wall = 2.0 * 3.0 ** ((x > 20.5) + 2 * (y > 20.5))
    both = SurfaceMesh(np.concatenate([flat.vertices, cube.vertices - 500.0]), np.concatenate([flat.faces, cube.faces + len(wall)]))
    labels = segments(both, np.concatenate([wall, np.ones(8)]))
    assert len(set(labels[: len(wall)])) == 4
    assert set(labels[len(wall) :]) == {labels[0]}


def test_a_segment_is_that_of_the_vertex_nearest_to_the_point():
    flat = sheet()
    wall = np.where(across(flat) > 20.5, 9.0, 3.0)
    labels = segments(flat, wall)
    mixed = flat.faces[np.ptp(labels[flat.faces], axis=1) > 0]
    assert len(mixed) > 10
    for face in mixed[::20]:
        for corner in range(3):
            near = np.array([0.15, 0.15, 0.15])
            near[corner] = 0.7
            point = tuple(float(x) for x in near @ flat.vertices[face])
            assert np.array_equal(selected(Segment(point), flat, wall), labels == labels[face[corner]])


def test_inside_outside_and_underside_of_a_cup_are_segments(cup, thickness):
    inner = selected(Segment((17.0, 0.0, 15.0)), cup, thickness)
    outer = selected(Segment((25.0, 0.0, 15.0)), cup, thickness)
    under = selected(Segment((0.0, 0.0, -3.0)), cup, thickness)
    assert not (inner & outer).any()
    assert not (outer & under).any()
    radius, height = np.linalg.norm(cup.vertices[:, :2], axis=1), cup.vertices[:, 2]
    middle = (height > 8) & (height < 25)
    assert inner[middle & (radius < 17.5)].all()
    assert outer[middle & (radius > 19.5)].all()
    assert under[(height < 0.1) & (radius < 15)].all()


def test_a_segment_ends_where_the_wall_thickens():
    """A flat top over a thin plate and a thick block, without any edge between them."""
    plate, thick = manifold3d.Manifold.cube((40.0, 20.0, 3.0)).translate((0, 0, 17)), manifold3d.Manifold.cube((20.0, 20.0, 20.0))
    mesh = even(surface_of(plate + thick.translate((-20.0, 0.0, 0.0))), 3000)
    labels = segments(mesh, local_thickness(mesh))
    top = np.abs(mesh.vertices[:, 2] - 20) < 0.01
    middle = np.abs(mesh.vertices[:, 1] - 10) < 5
    thin, block = (labels[top & middle & (np.abs(mesh.vertices[:, 0] - x) < 5)] for x in (25.0, -10.0))
    assert len(set(thin)) == len(set(block)) == 1
    assert thin[0] != block[0]
