"""The sky seen by vertices of shapes where it is known."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.geometry.inside_outside import _directions, sky_seen
from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.records.mesh import SurfaceMesh


def refined(body: Manifold, edge: float) -> SurfaceMesh:
    """The surface of a solid with edges of at most a length [mm]."""
    return surface_of(body.refine_to_length(edge))


def inner(mesh: SurfaceMesh, low: tuple[float, float, float], high: tuple[float, float, float]) -> np.ndarray:
    """Whether each vertex lies within a box [mm]."""
    return np.all((mesh.vertices >= low) & (mesh.vertices <= high), axis=1)


@pytest.fixture(scope="module")
def box() -> SurfaceMesh:
    """A cube of 20 mm."""
    return refined(Manifold.cube((20.0, 20.0, 20.0)), 2.5)


def turned(mesh: SurfaceMesh, degrees: float) -> SurfaceMesh:
    """The same, turned about z."""
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return mesh.moved(mesh.vertices @ np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]]))


def test_the_directions_are_evenly_spread_above_the_horizon():
    sky = _directions(64, cosine=False)
    assert sky[:, 2].min() > 0.0
    assert np.linalg.norm(sky, axis=1) == pytest.approx(1.0)
    assert sky.mean(axis=0) == pytest.approx([0.0, 0.0, 0.5], abs=0.01)
    assert sky.T @ sky / 64 == pytest.approx(np.eye(3) / 3.0, abs=0.01)


def test_the_sides_of_a_cube_on_the_floor(box):
    """All of the sky from the top, half of it from the sides, nothing from below."""
    seen = sky_seen(box)
    assert seen.dtype == np.float32
    assert seen.shape == (len(box.vertices),)
    assert seen[inner(box, (1, 1, 20), (19, 19, 20))] == pytest.approx(1.0, abs=1e-6)
    for side in (inner(box, (0, 1, 1), (0, 19, 19)), inner(box, (1, 20, 1), (19, 20, 19))):
        assert seen[side] == pytest.approx(0.5, abs=0.02)
    below = inner(box, (1, 1, 0), (19, 19, 0))
    assert below.sum() > 20
    assert np.all(seen[below] == 0.0)
    rim = inner(box, (-1, -1, 0), (21, 21, 0)) & ~below
    assert seen[rim].max() < 0.2


def test_a_plate_shows_its_top_alone():
    plate = refined(Manifold.cube((60.0, 40.0, 2.0)), 2.0)
    seen, high = sky_seen(plate), plate.vertices[:, 2] > 1.99
    assert seen[high].min() > 0.7  # a corner belongs to two walls, too
    assert np.average(seen, weights=plate.vertex_areas) == pytest.approx((60 * 40 + 0.5 * 200 * 2) / (2 * 60 * 40 + 200 * 2), abs=0.02)


def test_a_sphere_sees_what_its_slope_leaves():
    """The light of an even sky on a face that leans by θ from horizontal is (1 + cos θ) / 2 (Moon and Spencer 1942)."""
    ball = surface_of(Manifold.sphere(15.0, 64).translate((0.0, 0.0, 15.0)))
    seen = sky_seen(ball)
    assert seen == pytest.approx((1.0 + ball.vertex_normals[:, 2]) / 2.0, abs=0.02)
    assert seen[ball.vertices[:, 2].argmin()] == 0.0
    assert seen[ball.vertices[:, 2].argmax()] == pytest.approx(1.0, abs=1e-3)


def test_the_bottom_of_a_deep_cup_sees_the_share_of_the_sky_its_mouth_fills():
    """Seen from the middle of the floor, a mouth of radius r at height h fills r² / (r² + h²) of the light."""
    deep = Manifold.cylinder(45.0, 20.0, 20.0, 64) - Manifold.cylinder(45.0, 15.0, 15.0, 64).translate((0.0, 0.0, 5.0))
    mesh = even(surface_of(deep), 3000)
    seen = sky_seen(mesh)
    bottom = (np.linalg.norm(mesh.vertices[:, :2], axis=1) < 12.0) & (np.abs(mesh.vertices[:, 2] - 5.0) < 0.1)
    assert seen[bottom].min() > 0.0
    assert seen[bottom].max() < 0.2
    middle = np.linalg.norm(mesh.vertices - [0.0, 0.0, 5.0], axis=1).argmin()
    share = 15.0**2 / (15.0**2 + 40.0**2)
    assert seen[middle] == pytest.approx(share, abs=0.04)
    assert sky_seen(mesh, directions=4096)[middle] == pytest.approx(share, abs=0.005)


def test_below_a_table_top_there_is_no_sky_and_its_leg_sees_the_horizon():
    """The underside faces the floor. The leg sees less than the half of the sky that a free wall sees, and the less the higher."""
    table = Manifold.cube((60.0, 60.0, 4.0)).translate((0, 0, 30)) + Manifold.cube((10.0, 10.0, 31.0)).translate((25, 25, 0))
    mesh = refined(table, 2.0)
    seen = sky_seen(mesh)
    under = inner(mesh, (3, 3, 30), (57, 57, 30)) & ~inner(mesh, (24, 24, 0), (36, 36, 31))
    assert under.sum() > 100
    assert np.all(seen[under] == 0.0)
    leg, height = inner(mesh, (25, 27, 3), (25, 33, 27)), mesh.vertices[:, 2]
    assert seen[leg].max() < 0.42
    assert seen[leg].min() > 0.0
    assert seen[leg & (height < 8.0)].min() > seen[leg & (height > 22.0)].max()


def test_an_overhang_shades_what_is_below_it():
    """A long shelf leaves a strip of sky, from its edge to the horizon: (1 - sin φ) / 2 of the light, φ from straight up to the edge."""
    long = Manifold.cube((60.0, 300.0, 5.0)) + Manifold.cube((5.0, 300.0, 25.0)) + Manifold.cube((30.0, 300.0, 5.0)).translate((0, 0, 20))
    mesh = refined(long, 4.0)
    across, height, middle = mesh.vertices[:, 0], mesh.vertices[:, 2], np.abs(mesh.vertices[:, 1] - 150.0) < 20.0
    seen, step = sky_seen(mesh), middle & (np.abs(height - 5.0) < 0.01)
    for here, edge in ((step & (across > 8.0) & (across < 29.0), 15.0), (step & (across > 31.0) & (across < 59.0), 20.0)):
        ahead = 30.0 - across[here]
        assert here.sum() > 20
        assert seen[here] == pytest.approx((1.0 - ahead / np.hypot(ahead, edge)) / 2.0, abs=0.05)
    assert np.all(seen[middle & (np.abs(height - 20.0) < 0.01) & (across > 7.0) & (across < 28.0)] == 0.0)


@pytest.mark.parametrize("degrees", [30.0, 137.0])
def test_turned_about_z_a_part_sees_the_same(cup, degrees):
    straight, other = sky_seen(cup), sky_seen(turned(cup, degrees))
    weights = cup.vertex_areas
    assert np.average(np.abs(other - straight), weights=weights) < 0.02
    assert np.average(other, weights=weights) == pytest.approx(np.average(straight, weights=weights), abs=0.005)


def test_it_is_the_same_each_time(box):
    assert np.array_equal(sky_seen(box), sky_seen(box))
