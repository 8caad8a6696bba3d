"""How wide faces are, on shapes whose faces are known."""

import manifold3d
import pytest

from mechstyle.geometry import thickness
from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.geometry.thickness import face_width


def block(x, y, z):
    return even(surface_of(manifold3d.Manifold.cube((x, y, z))), 4000)


@pytest.mark.parametrize(("size", "least", "most"), [((100, 100, 100), 45, 100), ((100, 4, 4), 2.5, 4.2), ((100, 100, 3), 45, 100)])
def test_faces_are_as_wide_as_their_narrow_side_and_the_edge_of_a_plate_does_not_count(size, least, most):
    assert least < face_width(block(*size)) <= most


def test_a_thin_ring_is_as_narrow_as_it_is_thick():
    ring = manifold3d.CrossSection.circle(2.2, 24).translate((30.0, 0.0)).revolve(96)
    assert face_width(even(surface_of(ring), 4000)) == pytest.approx(4.4, rel=0.25)


def test_a_ball_is_as_wide_as_it_is(sphere):
    """From anywhere on it, the nearest place whose normal is across is 60 degrees away: a chord of one radius."""
    assert face_width(sphere) == pytest.approx(20.0, rel=0.03)


def test_it_is_found_once_for_each_part(sphere, monkeypatch):
    """Every style on a part asks for it anew: a third of the time until it is on show."""
    width = face_width(sphere)
    monkeypatch.setattr(thickness, "SAMPLES", 2)
    assert face_width(sphere) == width
    assert face_width(block(60.0, 60.0, 3.0)) > 0.0, "another part is measured all the same"
