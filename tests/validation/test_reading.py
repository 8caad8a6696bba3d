"""σ_V of structured bodies: what is uniform is read as it is, and periods are those of a free beam."""

import numpy as np
import pytest

from validation.meshes import box
from validation.reading import PLA, Body, period_of_body, styled_cup

BAR = (60.0, 6.0, 6.0)


@pytest.fixture(scope="module")
def bar():
    return Body(box((20, 2, 2), BAR))


def test_a_stress_that_is_the_same_everywhere_is_read_as_it_is(bar):
    corners = np.full((len(bar.tets.tets), 4), 12.5)
    assert bar.read(corners, 4.0) == pytest.approx((12.5, 12.5))


def test_a_peak_at_one_corner_is_its_largest_stress_and_not_what_a_volume_exceeds(bar):
    corners = np.full((len(bar.tets.tets), 4), 12.5)
    corners[0, 0] = 500.0
    found = bar.read(corners, 4.0)
    assert found.maximum == 500.0
    assert 12.5 <= found.stress < 20.0


def test_a_pull_is_force_over_area(bar):
    assert 10.0 < bar.loaded((360.0, 0.0, 0.0)).stress < 11.0, "a little more at the clamp, which holds it across"


def test_the_period_is_that_of_a_free_beam(bar):
    """F = 22.37 / (2 π L²) √(E I / ρ A), Euler and Bernoulli; shear makes a beam ten times as long as thick a few per cent slower."""
    length, side, _ = BAR
    modulus = np.sqrt(PLA.youngs_modulus * side**2 / 12.0 / PLA.density)  # √(E I / ρ A)
    beam = 2.0 * np.pi * length**2 / 22.37 / modulus
    assert 1.0 < period_of_body(bar.tets) / beam < 1.06


def test_the_boundary_of_a_body_encloses_its_volume(bar):
    assert bar.tets.boundary.is_closed
    assert bar.tets.boundary.volume == pytest.approx(np.prod(BAR))


def test_a_styled_cup_has_a_relief_and_sound_tetrahedra():
    part = styled_cup()
    assert np.linalg.norm(part.surface.vertices - part.smooth.vertices, axis=1).max() > 0.1
    assert (part.morphed.volumes > 0.0).all()
    standing = part.smooth.vertices[:, 2] < 1e-6
    assert standing.any()
    assert np.array_equal(part.surface.vertices[standing], part.smooth.vertices[standing])
