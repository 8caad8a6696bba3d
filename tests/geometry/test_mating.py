"""Flat ends that may meet something else: feet and rims, and what is none."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest

from mechstyle import gallery
from mechstyle.geometry.mating import mating_ends
from mechstyle.geometry.remeshing.evening import even, surface_of

CUP = manifold3d.Manifold.cylinder(50.0, 20.0, 20.0, 64) - manifold3d.Manifold.cylinder(50.0, 18.5, 18.5, 64).translate((0, 0, 3))
TABLE = manifold3d.Manifold.cube((60.0, 60.0, 6.0)) + manifold3d.Manifold.batch_boolean(
    [manifold3d.Manifold.cube((5.0, 5.0, 12.0)).translate((x, y, 5.0)) for x in (0.0, 55.0) for y in (0.0, 55.0)],
    manifold3d.OpType.Add,
)


@pytest.mark.parametrize(("solid", "area"), [(CUP, np.pi * (20.0**2 - 18.5**2)), (TABLE, 4 * 25.0)], ids=["rim", "feet"])
def test_the_ends_and_nothing_else(solid, area):
    mesh = even(surface_of(solid), 3000)
    found = mating_ends(mesh).holds[mesh.faces].all(axis=1)
    assert mesh.face_areas[found].sum() == pytest.approx(area, rel=0.1)
    assert np.allclose(mesh.corners[found].reshape(-1, 3)[:, 2], mesh.vertices[:, 2].max(), atol=0.05)


@pytest.mark.parametrize(
    "solid",
    [
        manifold3d.Manifold.cube((40.0, 30.0, 20.0)),
        manifold3d.Manifold.sphere(20.0, 64),
        manifold3d.Manifold.cube((50.0, 50.0, 5.0)) + manifold3d.Manifold.cube((5.0, 50.0, 50.0)),
        TABLE.rotate((180.0, 0.0, 0.0)),
    ],
    ids=["box", "ball", "angle", "table on its feet"],
)
def test_walls_curves_and_the_base_are_none(solid):
    assert not mating_ends(even(surface_of(solid), 2000)).holds.any()


def test_of_the_gallery_little_is_taken():
    """A rim or feet: what is more would be seen."""
    for name in gallery.names():
        mesh = gallery.make(name)
        assert mesh.face_areas[mating_ends(mesh).holds[mesh.faces].all(axis=1)].sum() < 0.06 * mesh.face_areas.sum(), name
