"""Folds, crossings, walls and mass of a styled surface, against shapes that are known to have them."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from manifold3d import CrossSection, Manifold

from mechstyle.geometry.print_quality import quality, turned_over
from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.geometry.subdivision import subdivided
from mechstyle.records.mesh import SurfaceMesh


def box(at=(0.0, 0.0, 0.0), size=10.0, cuts=2):
    made = trimesh.creation.box((size, size, size))
    made.apply_translation(at)
    for _ in range(cuts):
        made = made.subdivide()
    return SurfaceMesh(made.vertices, made.faces)


def both(one, other):
    return SurfaceMesh(np.vstack([one.vertices, other.vertices]), np.vstack([one.faces, other.faces + len(one.vertices)]))


def test_faces_that_look_the_other_way_are_counted(cube):
    mirrored = cube.moved(cube.vertices * [1.0, 1.0, -1.0])  # top and bottom change places, the sides are turned inside out
    assert turned_over(cube, cube).sum() == 0
    assert turned_over(cube, mirrored).sum() == 8


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


def leaning_wall(wall=3.0):
    """A plate of 40 x 30 mm whose narrow sides lean: its edges are of 70 and 110 degrees."""
    plate = Manifold.cube((40.0, 30.0, wall), center=True)
    lean = np.tan(np.radians(20.0))
    return even(surface_of(plate.transform([[1.0, 0.0, lean, 0.0], [0.0, 1.0, lean, 0.0], [0.0, 0.0, 1.0, 0.0]])), 3000)


@pytest.mark.parametrize("rounds", [0, 1, 2])
def test_the_thinnest_wall_does_not_depend_on_how_close_to_an_edge_vertices_lie(rounds):
    """Beside an edge of 70 degrees the inner ball vanishes: the more vertices, the thinner such a wall would read."""
    surface = leaning_wall(3.0)
    for _ in range(rounds):
        surface = subdivided(surface)
    found = quality(surface, surface, 1.24e-3)
    assert found.thinnest == pytest.approx(3.0, rel=0.02)
    assert found.thin == pytest.approx(3.0, rel=0.02)


def test_a_wall_that_is_thinner_in_the_middle_is_seen_on_a_finer_surface_too():
    surface = leaning_wall(3.0)
    dent = subdivided(surface)
    depth = np.where(np.hypot(*surface.vertices[:, :2].T) < 6.0, -0.8, 0.0) * (np.abs(surface.vertex_normals[:, 2]) > 0.99)
    coarse = quality(surface, surface.displaced(depth), 1.24e-3)
    fine = quality(dent.mesh, dent.mesh.displaced(dent.interpolation @ depth), 1.24e-3)
    assert coarse.thinnest == pytest.approx(1.4, rel=0.02)
    assert fine.thinnest == pytest.approx(1.4, rel=0.02)


def cut_fine(body, edge=0.12):
    return surface_of(body.refine_to_length(edge))


def test_a_ridge_of_the_relief_that_is_narrower_than_two_lines_is_no_wall():
    """A relief cut off at the floor leaves some: a stone wall hook read 0.29 mm of them, 1 % of it being thinner than 5.34."""
    profile = CrossSection([[(-0.12, 0.0), (0.12, 0.0), (0.0, 0.35)]])
    ridge = Manifold.extrude(profile, 3.0).rotate((90.0, 0.0, 0.0)).translate((0.0, 1.5, 1.5))
    surface = cut_fine(Manifold.cube((8.0, 6.0, 3.0), center=True) + ridge)
    assert quality(surface, surface, 1.24e-3).thinnest == pytest.approx(3.0, rel=0.02)


@pytest.mark.parametrize("wide", [1.5, 6.0])
def test_a_thin_wall_is_seen_whatever_stands_beside_it(wide):
    """A wall of 0.5 mm, 0.2 mm before a block: what is near in space and not along the surface has no say."""
    wall, block = Manifold.cube((0.5, wide, 4.0)), Manifold.cube((4.0, 6.0, 4.0)).translate((0.7, 0.0, 0.0))
    surface = cut_fine(wall + block + Manifold.cube((4.7, 6.0, 2.0)).translate((0.0, 0.0, -2.0)))
    assert quality(surface, surface, 1.24e-3).thinnest == pytest.approx(0.5, rel=0.05)
