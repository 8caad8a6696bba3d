"""Which vertices a region holds, how its ramp fades, and where segments end."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.geometry.region_selection import faded, protection, segments, selected
from mechstyle.geometry.remesh import standardise, surface_of
from mechstyle.geometry.thickness import local_thickness
from mechstyle.records.regions import Box, HalfSpace, Inside, Outside, Segment, Sphere, Vertices


@pytest.fixture(scope="module")
def thickness(cup):
    return local_thickness(cup)


def test_shapes_hold_what_lies_in_them(cup, thickness):
    points = cup.vertices
    for region, expected in (
        (Box((0, -30, -1), (30, 30, 15)), (points[:, 0] >= 0) & (points[:, 2] <= 15)),
        (Sphere((20, 0, 15), 8), np.linalg.norm(points - [20, 0, 15], axis=1) <= 8),
        (HalfSpace((0, 0, 20), (0, 0, 7)), points[:, 2] >= 20),
        (HalfSpace((0, 0, 20), (1, 0, -1)), points[:, 0] >= points[:, 2] - 20),
        (Vertices((5, 0, 7)), np.isin(np.arange(len(points)), [0, 5, 7])),
    ):
        assert np.array_equal(selected(region, cup, thickness), expected)


def test_outside_is_what_is_not_inside(cup, thickness):
    assert np.array_equal(selected(Outside(), cup, thickness), ~selected(Inside(), cup, thickness))


def test_a_region_that_holds_nothing_is_refused_and_told_where_the_part_is(cup, thickness):
    with pytest.raises(BadInput, match=r"'sphere 500 0 0 3' holds nothing of this part, which reaches from -20 -20 0 to 20 20 30 mm"):
        selected(Sphere((500, 0, 0), 3), cup, thickness)


def test_a_vertex_that_is_not_there_is_refused(cup, thickness):
    with pytest.raises(BadInput, match="vertex 99999 cannot be protected: the standardised surface has vertices 0 to"):
        selected(Vertices((99999,)), cup, thickness)


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
    assert np.array_equal(both.uncoloured, height <= 10)
    alone = protection([low], cup, thickness).freedom
    between = (height > 10) & (height < 25)
    assert np.array_equal(both.freedom[between], alone[between])
    assert both.notes[1].startswith("protected: plane 0 0 25 0 0 1, ")


def test_a_ramp_rises_by_the_way_along_the_surface(cup):
    below = cup.vertices[:, 2] <= 10
    free = faded(cup, below, 8.0)
    outer = (np.linalg.norm(cup.vertices[:, :2], axis=1) > 19.5) & (cup.vertices[:, 2] > 10)
    way = cup.vertices[outer, 2] - 10
    assert np.all(free[below] == 0.0)
    # Ways along edges are up to a seventh longer than straight ones, and begin at the last chosen vertex below.
    assert np.all(free[outer] >= np.minimum(way / 8.0, 1.0) - 1e-9)
    assert np.all(free[outer] <= np.minimum((1.16 * way + 3.0) / 8.0, 1.0))


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
    mesh = standardise(surface_of(plate + thick.translate((-20.0, 0.0, 0.0))), 3000)
    labels = segments(mesh, local_thickness(mesh))
    top = np.abs(mesh.vertices[:, 2] - 20) < 0.01
    middle = np.abs(mesh.vertices[:, 1] - 10) < 5
    thin, block = (labels[top & middle & (np.abs(mesh.vertices[:, 0] - x) < 5)] for x in (25.0, -10.0))
    assert len(set(thin)) == len(set(block)) == 1
    assert thin[0] != block[0]
