"""An even triangulation of the wished size that is still the same part."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from manifold3d import Manifold

from mechstyle.errors import BadInput
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.standardise import shell_count, standardise, surface_of
from mechstyle.mesh import SurfaceMesh


@pytest.mark.parametrize("wished", [800, 3000, 8000])
def test_the_count_is_met_within_five_percent(cup, wished):
    assert abs(len(standardise(cup, wished).vertices) / wished - 1) <= 0.05


def test_triangles_are_nearly_equilateral(cup):
    sides = np.linalg.norm(np.roll(cup.corners, -1, axis=1) - cup.corners, axis=2)
    quality = 4 * np.sqrt(3) * cup.face_areas / (sides**2).sum(axis=1)
    assert quality.mean() > 0.9
    assert np.percentile(quality, 1) > 0.4


def test_the_shape_stays(cup):
    assert cup.is_closed
    assert len(cup.vertices) - len(cup.edges) + len(cup.faces) == 2
    ideal = np.pi * (20**2 * 30 - 17**2 * 27)
    assert cup.volume == pytest.approx(ideal, rel=0.01)
    assert cup.extents == pytest.approx([40, 40, 30], abs=0.05)


def test_sharp_edges_stay_where_they_are():
    box = trimesh.creation.box((30.0, 20.0, 10.0))
    even = standardise(SurfaceMesh(box.vertices, box.faces), 2000)
    distance = TriangleTree(even.vertices, even.faces).nearest(box.vertices).distance
    assert distance.max() < 1e-4
    assert even.volume == pytest.approx(6000, rel=1e-4)


def test_handles_and_cavities_are_kept():
    ring = Manifold.cylinder(6.0, 15.0, 15.0, 48) - Manifold.cylinder(6.0, 9.0, 9.0, 48)
    hollow = Manifold.sphere(12.0, 48) - Manifold.sphere(8.0, 48)
    even_ring, even_hollow = standardise(surface_of(ring), 1500), standardise(surface_of(hollow), 2000)
    assert len(even_ring.vertices) - len(even_ring.edges) + len(even_ring.faces) == 0
    assert shell_count(even_hollow) == 2


def test_the_same_input_gives_the_same_bytes(cup):
    assert standardise(cup, 1500).digest == standardise(cup, 1500).digest


@pytest.mark.parametrize("count", [10, 499, 400_001])
def test_counts_out_of_range_are_refused(cup, count):
    with pytest.raises(BadInput, match="500 to 400000"):
        standardise(cup, count)


def test_an_open_surface_is_refused(cup):
    with pytest.raises(BadInput, match="not closed"):
        standardise(SurfaceMesh(cup.vertices, cup.faces[:-1]), 1000)
