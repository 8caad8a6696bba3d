"""Reliefs that would make a surface pass through itself."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import CrossSection, Manifold

from mechstyle.geometry.print_quality import turned_over, untangled
from mechstyle.geometry.remeshing.crossings import crossings
from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.records.mesh import SurfaceMesh


@pytest.fixture(scope="module")
def angle():
    """A bracket of two plates, 30 mm long, with an inner corner along y at x = z = 4 mm."""
    profile = CrossSection([[(0.0, 0.0), (20.0, 0.0), (20.0, 4.0), (4.0, 4.0), (4.0, 20.0), (0.0, 20.0)]])
    return even(surface_of(Manifold.extrude(profile, 30.0).rotate([90.0, 0.0, 0.0]).refine_to_length(1.0)), 12_000)


def tangles(surface, relief):
    styled = surface.displaced(relief)
    return crossings(styled).pairs + int(turned_over(surface, styled).sum())


def bricks(surface, low, high):
    """Dents and bumps in stripes of 3 mm."""
    return np.where(np.sin(2.0 * np.pi * surface.vertices[:, 1] / 6.0) > 0.0, high, low).astype(np.float32)


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.5), (-1.5, 0.0), (-1.0, 1.0)], ids=["bumps", "dents", "both"])
def test_nothing_crosses_or_turns_over_any_more(angle, low, high):
    relief = bricks(angle, low, high)
    assert tangles(angle, relief) > 20
    found = untangled(angle, relief)
    assert tangles(angle, found) == 0
    assert found.dtype == np.float32
    assert np.all(np.abs(found) <= np.abs(relief))


def test_away_from_corners_a_relief_stays_as_it_is(angle):
    relief = bricks(angle, 0.0, 1.5)
    found = untangled(angle, relief)
    inner = np.hypot(angle.vertices[:, 0] - 4.0, angle.vertices[:, 2] - 4.0)
    np.testing.assert_array_equal(found[inner > 8.0], relief[inner > 8.0])
    areas = angle.vertex_areas
    assert (areas * relief * found).sum() > 0.95 * (areas * relief**2).sum()


def test_what_crosses_nothing_is_returned_unchanged(angle):
    relief = bricks(angle, -0.1, 0.1)
    np.testing.assert_array_equal(untangled(angle, relief), relief)


def test_crossings_of_the_part_itself_are_left_alone(angle):
    """Two brackets that reach into each other cross, whatever relief they have."""
    count = len(angle.vertices)
    moved = angle.vertices + np.array([1.1, 2.3, 1.7])
    pair = SurfaceMesh(np.vstack([angle.vertices, moved]), np.vstack([angle.faces, angle.faces + count]))
    relief = np.zeros(2 * count, np.float32)
    np.testing.assert_array_equal(untangled(pair, relief), relief)
    assert crossings(pair).pairs > 0


def test_it_can_be_stopped(angle):
    def stop():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        untangled(angle, bricks(angle, 0.0, 1.5), stop)
