"""What a part stands on, and where it is protected."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold, OpType

from mechstyle.geometry.remeshing.evening import surface_of
from mechstyle.geometry.resting_face import resting_face, resting_weight
from mechstyle.records.mesh import SurfaceMesh


def test_a_box_stands_on_its_underside():
    face = resting_face(surface_of(Manifold.cube((30.0, 20.0, 10.0)).translate((0, 0, 5.0))))
    assert face.area == pytest.approx(600.0)
    assert face.height == pytest.approx(5.0)
    assert len(face.polygon) == 4


@pytest.mark.parametrize(
    "body",
    [
        Manifold.sphere(10.0, 64),
        Manifold.cube((20.0, 20.0, 20.0), center=True).rotate((45.0, 35.26, 0.0)),
        Manifold.cylinder(20.0, 0.0, 10.0, 64),
        Manifold.cube((10.0, 10.0, 10.0)) + Manifold.cube((60.0, 10.0, 5.0)).translate((5.0, 0.0, 8.0)),
    ],
    ids=["ball", "cube on its corner", "cone on its tip", "top-heavy: it would tip over"],
)
def test_what_rolls_tips_or_balances_has_none(body):
    mesh = surface_of(body)
    assert resting_face(mesh) is None
    assert np.all(resting_weight(mesh) == 1.0)


def test_a_table_stands_on_its_legs():
    legs = [Manifold.cube((4.0, 4.0, 20.0)).translate((x, y, 0.0)) for x in (0.0, 26.0) for y in (0.0, 26.0)]
    table = Manifold.batch_boolean([Manifold.cube((30.0, 30.0, 4.0)).translate((0, 0, 19.0)), *legs], OpType.Add)
    assert resting_face(surface_of(table)).area == pytest.approx(4 * 16.0)


def test_a_part_may_stand_on_a_single_triangle():
    face = resting_face(SurfaceMesh([[0, 0, 7], [6, 0, 7], [0, 8, 7], [1, 1, 9]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))
    assert (len(face.polygon), face.area, face.height) == (3, pytest.approx(24.0), 7.0)


@pytest.mark.parametrize(("step", "area"), [(0.05, 400.0), (0.09, 400.0), (0.11, 240.0), (3.0, 240.0)])
@pytest.mark.parametrize("height", [-50.0, 0.0, 12.5])
def test_what_is_within_a_tenth_of_a_millimetre_of_the_floor_stands_on_it(step, area, height):
    """An underside of two levels; the riser between them looks sideways and carries nothing."""
    body = Manifold.cube((20.0, 20.0, 10.0)) - Manifold.cube((8.0, 20.0, step)).translate((12.0, 0.0, 0.0))
    face = resting_face(surface_of(body.translate((100.0, -30.0, height))))
    assert face.area == pytest.approx(area, rel=1e-4)
    assert face.height == pytest.approx(height)


@pytest.mark.parametrize(("degrees", "stands"), [(0.0, True), (4.5, True), (5.5, False)])
def test_an_underside_within_five_degrees_of_level_is_one(degrees, stands):
    """A slat so narrow that its other edge is hardly higher: 1 mm · sin 5.5° < 0.1 mm."""
    slat = Manifold.cube((1.0, 20.0, 1.0)).rotate((0.0, degrees, 0.0)).translate((5.0, 0.0, 3.0))
    assert (resting_face(surface_of(slat)) is not None) == stands


def test_an_underside_of_which_only_the_middle_touches_rocks():
    """A cone so blunt that it looks down everywhere, but stands on its tip."""
    body = Manifold.cylinder(1.0, 0.0, 20.0, 64) + Manifold.cylinder(5.0, 20.0, 20.0, 64).translate((0.0, 0.0, 1.0))
    assert resting_face(surface_of(body)) is None


@pytest.mark.parametrize(("share", "stands"), [(0.018, False), (0.022, True)])
def test_a_stem_carries_its_cap_from_two_per_cent_of_the_footprint_on(share, stands):
    stem = 20.0 * np.sqrt(share)
    body = Manifold.cube((20.0, 20.0, 30.0), center=True) + Manifold.cube((stem, stem, 50.0), center=True)
    assert (resting_face(surface_of(body)) is not None) == stands


@pytest.mark.parametrize(("lean", "stands"), [(0.0, True), (9.0, True), (11.0, False), (-9.0, True), (-11.0, False)])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_leaning_cube_tips_over_where_its_centre_leaves_its_base(cube, lean, stands, axis):
    """Sheared by `lean` over its height of 10 mm its centre moves by half of that from the middle of its 10 mm base."""
    corners = cube.vertices + np.array([40.0, -60.0, 25.0])
    corners[:, axis] += lean * cube.vertices[:, 2] / 10.0
    leaning = cube.moved(corners)
    assert leaning.centre_of_mass[axis] == pytest.approx(corners[:, axis].mean())
    assert (resting_face(leaning) is not None) == stands


@pytest.mark.parametrize("height", [-50.0, 0.0, 12.5])
def test_nothing_moves_up_to_one_millimetre_everything_from_five_on_and_half_midway(height):
    box = surface_of(Manifold.cube((20.0, 20.0, 10.0)).refine(20).translate((-30.0, 7.0, height)))
    above = box.vertices[:, 2] - height
    weight = resting_weight(box)
    for z, factor in ((0.0, 0.0), (1.0, 0.0), (1.5, 0.125), (3.0, 0.5), (4.5, 0.875), (5.0, 1.0), (10.0, 1.0)):
        at = np.abs(above - z) < 1e-6
        assert at.any()
        assert weight[at] == pytest.approx(factor, abs=1e-5)
    assert resting_weight(box, low=2.0, high=4.0)[np.abs(above - 2.5) < 1e-6] == pytest.approx(0.25, abs=1e-5)


def test_protection_rises_with_height(cup):
    weight = resting_weight(cup)
    height = cup.vertices[:, 2] - cup.vertices[:, 2].min()
    assert np.all(weight[height <= 1.0] == 0.0)
    assert np.all(weight[height >= 5.0] == 1.0)
    order = np.argsort(height)
    assert np.all(np.diff(weight[order]) >= 0)


def test_the_centre_of_mass_of_a_shifted_box():
    box = surface_of(Manifold.cube((30.0, 20.0, 10.0)).translate((1.0, 2.0, 3.0)))
    assert box.centre_of_mass == pytest.approx([16.0, 12.0, 8.0])
