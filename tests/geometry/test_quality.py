"""Folds, crossings, walls and mass of a styled surface, against shapes that are known to have them."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from mechstyle.geometry.quality import crossing_faces, folded_faces, quality
from mechstyle.mesh import SurfaceMesh


def box(at=(0.0, 0.0, 0.0), size=10.0, cuts=2):
    made = trimesh.creation.box((size, size, size))
    made.apply_translation(at)
    for _ in range(cuts):
        made = made.subdivide()
    return SurfaceMesh(made.vertices, made.faces)


def both(one, other):
    return SurfaceMesh(np.vstack([one.vertices, other.vertices]), np.vstack([one.faces, other.faces + len(one.vertices)]))


def test_a_sound_surface_crosses_nothing(sphere):
    assert crossing_faces(sphere) == 0
    assert crossing_faces(box()) == 0


def test_two_triangles_that_cross_are_one_pair():
    flat = SurfaceMesh([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    upright = SurfaceMesh([[1, 1, -1], [1, 1, 2], [1.5, 1, 2]], [[0, 1, 2]])
    apart = SurfaceMesh([[1, 1, 0.5], [1, 1, 2], [1.5, 1, 2]], [[0, 1, 2]])
    assert crossing_faces(both(flat, upright)) == 1
    assert crossing_faces(both(flat, apart)) == 0


def test_crossings_do_not_depend_on_where_the_part_stands():
    pair = both(box(), box((5.0, 0.3, 0.2)))
    there = pair.moved(pair.vertices + np.array([3e4, -2e4, 1e4]))
    assert crossing_faces(pair) > 50
    assert crossing_faces(there) == crossing_faces(pair)


def test_faces_that_look_the_other_way_are_counted(cube):
    mirrored = cube.moved(cube.vertices * [1.0, 1.0, -1.0])  # top and bottom change places, the sides are turned inside out
    assert folded_faces(cube, cube) == 0
    assert folded_faces(cube, mirrored) == 8


def test_a_relief_driven_through_the_part_is_told(sphere):
    """Every second ring of latitudes is pushed in beyond the centre."""
    pushed = sphere.displaced(np.where(np.abs(sphere.vertices[:, 2]) < 2.0, -15.0, 0.0))
    found = quality(sphere, pushed, 1.24e-3)
    assert found.folds > 0
    assert found.crossings > found.crossings_before == 0
    assert len(found.warnings) == 2
    assert f"at {found.folds} faces" in found.warnings[0]
    assert all("\n" not in words for words in found.warnings)


def test_walls_and_mass_of_a_ball_grown_evenly(sphere):
    found = quality(sphere, sphere.displaced(np.full(len(sphere.vertices), 1.0)), 2e-3)
    assert found.thinnest_before == pytest.approx(20.0, rel=0.12)  # a ball is measured at most 10 % too thick
    assert found.thin / found.thin_before == pytest.approx(1.1, rel=0.02)
    assert found.volume_change == pytest.approx(1.1**3 - 1.0, rel=2e-3)
    assert found.mass == pytest.approx(2e-3 * found.volume)
    assert found.mass_change == pytest.approx(2e-3 * (found.volume - sphere.volume))
    assert found.warnings == ()


def test_what_the_part_itself_brings_is_no_warning():
    """Crossings that were there before the style are the file's, not the style's."""
    pair = both(box(), box((5.0, 0.3, 0.2)))
    found = quality(pair, pair, 1.24e-3)
    assert found.crossings == found.crossings_before > 0
    assert found.warnings == ()
