"""Faces that cross, and bodies that reach into themselves, against shapes that are known to."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from mechstyle import gallery
from mechstyle.geometry.one_body import repaired
from mechstyle.geometry.pieces import Piece, Thing
from mechstyle.geometry.remeshing.crossings import crossings, overlaps
from mechstyle.records.mesh import SurfaceMesh


def box(at=(0.0, 0.0, 0.0), size=10.0, cuts=2):
    made = trimesh.creation.box((size, size, size))
    made.apply_translation(at)
    for _ in range(cuts):
        made = made.subdivide()
    return SurfaceMesh(made.vertices, made.faces)


def both(one, other):
    return SurfaceMesh(np.vstack([one.vertices, other.vertices]), np.vstack([one.faces, other.faces + len(one.vertices)]))


def figure_of_eight(radius: float, rise: float, rings: int = 120, around: int = 16) -> SurfaceMesh:
    """One closed tube along a figure of eight of 60 mm whose two ways pass `2 rise` above each other at the origin."""
    angle, turn = (2.0 * np.pi * np.arange(count) / count for count in (rings, around))
    path = np.stack([30.0 * np.sin(angle), 20.0 * np.sin(2.0 * angle), rise * np.cos(angle)], axis=1)
    tangent = np.stack([30.0 * np.cos(angle), 40.0 * np.cos(2.0 * angle), -rise * np.sin(angle)], axis=1)
    side = np.cross(tangent, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, tangent / np.linalg.norm(tangent, axis=1, keepdims=True))
    ring = np.cos(turn)[:, None, None] * side + np.sin(turn)[:, None, None] * up
    points = (path + radius * ring).transpose(1, 0, 2).reshape(-1, 3)
    a = np.arange(rings * around).reshape(rings, around)
    b, c, d = np.roll(a, -1, axis=0), np.roll(a, (-1, -1), axis=(0, 1)), np.roll(a, -1, axis=1)
    faces = np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)]).reshape(-1, 3)
    surface = SurfaceMesh(points, faces)
    return surface if surface.volume > 0 else SurfaceMesh(points, faces[:, ::-1])


def test_a_sound_surface_crosses_nothing(sphere):
    for sound in (sphere, box()):
        found = crossings(sound)
        assert found.pairs == 0
        assert (found.other == -1).all()


def test_two_triangles_that_cross_are_one_pair():
    flat = SurfaceMesh([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    upright = SurfaceMesh([[1, 1, -1], [1, 1, 2], [1.5, 1, 2]], [[0, 1, 2]])
    apart = SurfaceMesh([[1, 1, 0.5], [1, 1, 2], [1.5, 1, 2]], [[0, 1, 2]])
    found = crossings(both(flat, upright))
    assert (found.pairs, found.other.tolist()) == (1, [1, 0])
    assert crossings(both(flat, apart)).pairs == 0


def test_triangles_apart_in_one_plane_do_not_cross():
    """Two of a chamfer 0.43 mm wide that the remesher made: their planes differ by rounding alone."""
    corners = [
        [-62.77106711327218, -33.564125366527705, 23.9499010663031],
        [-63.168775821437315, -31.905572237261914, 23.79465066509506],
        [-63.16871496273629, -33.53951679782279, 23.794675873594407],
        [-62.77105588871996, -31.927140186632684, 23.949902544043436],
        [-62.77104463022873, -30.290157141517177, 23.949904026251925],
        [-63.16883667438814, -30.271634794656237, 23.794625458977514],
    ]
    assert crossings(SurfaceMesh(corners, [[0, 1, 2], [3, 4, 5]])).pairs == 0


def test_crossings_do_not_depend_on_where_the_part_stands():
    pair = both(box(), box((5.0, 0.3, 0.2)))
    there = pair.moved(pair.vertices + np.array([3e4, -2e4, 1e4]))
    assert crossings(pair).pairs > 50
    assert crossings(there).pairs == crossings(pair).pairs


def test_a_tube_that_passes_through_itself_overlaps_where_its_ways_meet():
    (place,) = overlaps(figure_of_eight(4.0, 0.0))
    assert place == pytest.approx([0.0, 0.0, 0.0], abs=0.2)
    assert overlaps(figure_of_eight(4.0, 5.0)).shape == (0, 3), "its ways are 2 mm apart"


@pytest.mark.parametrize(("depth", "places"), [(0.05, 0), (1.0, 1)])
def test_an_overlap_too_shallow_to_be_printed_is_none(depth, places):
    surface = figure_of_eight(4.0, 4.0 - 0.5 * depth)
    assert crossings(surface).pairs > 0
    assert len(overlaps(surface)) == places


def test_the_place_with_more_of_an_overlap_comes_first():
    """A bar of 60 mm with a small and a large block sunk into its upper side, which is at z = 5 mm."""
    bar = box(cuts=4)
    bar = bar.moved(bar.vertices * [6.0, 1.0, 1.0])
    places = overlaps(both(both(bar, box((-20.0, 0.1, 5.2), 2.0)), box((20.0, 0.1, 5.2), 6.0)))
    assert places == pytest.approx(np.array([[20.0, 0.1, 5.0], [-20.0, 0.1, 5.0]]), abs=0.5)


def test_a_pocket_that_is_inside_out_is_no_simple_body_either(sphere):
    """A ball whose upper and lower side change places up to 5 mm from the axis; the lower one turned, lest edges meet edges."""
    x, y, z = sphere.vertices.T
    radius = np.hypot(x, y)
    turn = np.exp(1j * np.where(z < 0.0, 0.01 * (10.0 - radius), 0.0)) * (x + 1j * y)
    swapped = sphere.moved(np.stack([turn.real, turn.imag, z * (radius / 5.0 - 1.0)], axis=1))
    found = overlaps(swapped)
    assert len(found) > 0
    assert np.abs(found[:, 2]).max() < 0.5


def test_a_body_that_passes_through_itself_is_taken_with_a_note():
    eight = figure_of_eight(4.0, 0.3)
    surface, notes = repaired([Thing("", (Piece("", eight.vertices + np.array([100.0, 50.0, 7.0]), eight.faces),))], "eight.stl")
    assert surface.is_closed
    (note,) = notes
    assert note.startswith("its surface passes through itself in 1 place, around (")
    x, y, z = map(float, note[note.index("(") + 1 : note.index(")")].split(","))
    assert (x, y, z) == pytest.approx((100.0, 50.0, 7.0), abs=0.3)


@pytest.mark.parametrize("name", gallery.names())
def test_the_gallery_passes_through_itself_nowhere(name):
    assert len(overlaps(gallery.make(name))) == 0
