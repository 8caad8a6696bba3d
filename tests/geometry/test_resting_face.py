"""What a part stands on, and where it is protected."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold, OpType

from mechstyle.geometry.remesh import surface_of
from mechstyle.geometry.resting_face import centre_of_mass, resting_face, resting_weight


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


def test_protection_rises_with_height(cup):
    weight = resting_weight(cup)
    height = cup.vertices[:, 2] - cup.vertices[:, 2].min()
    assert np.all(weight[height <= 1.0] == 0.0)
    assert np.all(weight[height >= 5.0] == 1.0)
    order = np.argsort(height)
    assert np.all(np.diff(weight[order]) >= 0)


def test_the_centre_of_mass_of_a_shifted_box():
    box = surface_of(Manifold.cube((30.0, 20.0, 10.0)).translate((1.0, 2.0, 3.0)))
    assert centre_of_mass(box) == pytest.approx([16.0, 12.0, 8.0])
