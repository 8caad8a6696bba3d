"""Triangles without area go, and the surface stays the same closed surface."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import example, given, settings
from hypothesis import strategies as st
from manifold3d import Manifold

from mechstyle.errors import BadInput
from mechstyle.gallery import make
from mechstyle.geometry.remeshing.cleaning import heights, without_degenerate
from mechstyle.geometry.remeshing.evening import _shape, even, even_edge, surface_of
from mechstyle.geometry.remeshing.tolerances import TOL
from mechstyle.records.mesh import SurfaceMesh
from support.degenerate import needled, railed, seamed, twinned

LEAST = 1e-3


def test_heights_of_known_triangles():
    corners = np.array([[(0, 0, 0), (4, 0, 0), (1, 3, 0)], [(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(1, 1, 1)] * 3], float)
    assert heights(corners) == pytest.approx([12 / np.sqrt(18), 0.0, 0.0])  # over its longest side, √18 mm


def test_a_sound_surface_stays_the_same_object(sphere):
    assert without_degenerate(sphere, LEAST) is sphere


@pytest.fixture(scope="module")
def ball() -> SurfaceMesh:
    """A ball of radius 10 mm about the origin, 642 vertices."""
    round_one = trimesh.creation.icosphere(3, 10.0)
    return SurfaceMesh(round_one.vertices, round_one.faces)


@pytest.mark.parametrize("apart", [0.0, 1e-9, 1e-5])
def test_seams_without_area_are_closed(ball, apart):
    broken = seamed(ball, apart)
    mended = without_degenerate(broken, LEAST)
    assert heights(broken.corners).min() < LEAST
    assert heights(mended.corners).min() >= LEAST
    assert _shape(mended) == _shape(ball)
    assert mended.volume == pytest.approx(ball.volume, rel=1e-4)
    assert (mended.face_normals * mended.corners.mean(axis=1)).sum(axis=1).min() > 0  # none was turned over


def test_whoever_waits_is_asked_before_every_pass_and_may_end_it(sphere):
    def no_longer():
        raise InterruptedError

    assert without_degenerate(sphere, LEAST, no_longer) is sphere  # nothing to do, nothing to ask
    with pytest.raises(InterruptedError):
        without_degenerate(seamed(sphere, 0.0), LEAST, no_longer)


@pytest.mark.parametrize("apart", [0.0, 1e-10, 1e-5])
def test_vertices_in_one_place_become_one_and_the_first_of_them_stays(sphere, apart):
    broken = twinned(sphere, range(0, 4000, 100), apart)
    mended = without_degenerate(broken, LEAST)
    assert heights(mended.corners).min() >= LEAST
    assert _shape(mended) == _shape(sphere)
    assert np.array_equal(mended.vertices, sphere.vertices)


@pytest.mark.parametrize("off", [0.5, 0.9, 1.7])
def test_a_strip_between_two_rows_of_vertices_on_one_line_goes_and_nothing_moves(off):
    """No side of it is short and none can be turned; a vertex may move along the edge, but never from the corner at its end."""
    bar = railed(off=off)
    mended = without_degenerate(bar, LEAST)
    assert heights(bar.corners).min() == 0.0
    assert heights(mended.corners).min() >= LEAST
    assert _shape(mended) == _shape(bar)
    assert mended.volume == pytest.approx(1200.0, rel=1e-12)
    assert mended.face_areas.sum() == pytest.approx(2 * 100 + 4 * 120, rel=1e-12)


def test_a_handle_as_thin_as_a_hair_is_not_pinched_off():
    """It cannot go without the part becoming another one; the caller looks at what is left."""
    block = surface_of(Manifold.cube((20, 20, 10), True) - Manifold.cylinder(20, 1e-7, 1e-7, 3, True))
    mended = without_degenerate(block, LEAST)
    assert _shape(mended) == _shape(block)


def cone():
    return surface_of(Manifold.cylinder(10.0, 15.0, 8.0, 32))


@pytest.mark.parametrize("apart", [1e-10, 1e-7, 5e-5])
@pytest.mark.parametrize("solid", [cone, lambda: surface_of(Manifold.sphere(12.0, 32))], ids=["cone", "sphere"])
def test_a_part_with_vertices_in_one_place_is_standardised_to_triangles_with_area(solid, apart):
    part = twinned(solid(), range(0, 60, 7), apart)
    evened = even(part, 1000)
    assert heights(evened.corners).min() >= TOL.no_area * even_edge(part, 2000)
    assert evened.vertex_areas.min() > 0
    assert _shape(evened) == _shape(part)
    assert evened.volume == pytest.approx(solid().volume, rel=0.01)


SOLIDS = {
    "cone": cone,
    "box": lambda: surface_of(Manifold.cube((30, 20, 10), True)),
    "fan of needles": lambda: surface_of(Manifold.cylinder(10.0, 15.0, 15.0, 1000)),
    "thin plate with a fin": lambda: surface_of(Manifold.cube((40, 20, 0.3)) + Manifold.cube((0.3, 20, 15)).translate((20, 0, 0))),
    "steps no higher than dust": lambda: surface_of(Manifold.cube((20, 20, 10)) + Manifold.cube((20, 20, 10)).translate((15, 3, 1e-6))),
}
FLAWS = {
    "none": lambda mesh, _apart: mesh,
    "seams": seamed,
    "twins": lambda mesh, apart: twinned(mesh, range(0, min(60, len(mesh.vertices)), 7), apart),
    "needles": lambda mesh, apart: needled(mesh, range(0, len(mesh.faces), 3), apart),
}


@settings(max_examples=12)
@given(
    solid=st.sampled_from(sorted(SOLIDS)),
    flaw=st.sampled_from(sorted(FLAWS)),
    apart=st.floats(-14, -2).map(lambda power: 10.0**power) | st.just(0.0),
    scale=st.floats(-2, 3).map(lambda power: 10.0**power),
    far=st.sampled_from([0.0, 1e3, 1e5]),
)
@example(solid="cone", flaw="twins", apart=1e-10, scale=1.0, far=0.0)
def test_no_triangle_without_area_leaves_standardising_whatever_went_in(solid, flaw, apart, scale, far):
    """Whatever the size of the part and wherever it lies; the flaw is made on the part as it is given."""
    clean = SOLIDS[solid]()
    part = SurfaceMesh(clean.vertices * scale + far, clean.faces)
    part = FLAWS[flaw](part, apart)
    evened = even(part, 800)
    assert heights(evened.corners).min() >= TOL.no_area * even_edge(part, 1600)
    assert evened.vertex_areas.min() > 0
    assert _shape(evened) == _shape(part)
    found, wanted = (mesh.moved(mesh.vertices - far).volume for mesh in (evened, part))
    assert found == pytest.approx(wanted, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["spectacle_frame", "cable_clip", "napkin_ring"])
def test_no_triangle_of_the_gallery_is_without_area(name):
    """Frames, slots and narrow rounds; a part that cannot be had without them is refused, whichever it is."""
    evened = even(make(name), 2000)
    assert heights(evened.corners).min() >= TOL.no_area * even_edge(evened, 4000)
    assert evened.vertex_areas.min() > 0


def test_a_part_with_strips_without_width_is_brought_to_any_number_of_vertices():
    """The rounds of the phone stand end in such strips: with so many vertices it was refused."""
    part = make("phone_stand")
    evened = even(part, 3000)
    assert heights(evened.corners).min() >= TOL.no_area * even_edge(evened, 6000)
    assert evened.volume == pytest.approx(part.volume, rel=0.015)  # its rounds are narrower than the triangles


@pytest.mark.parametrize("thick", [1e-3, 1e-2])
def test_a_part_too_thin_to_hold_a_triangle_is_refused(thick):
    """A plate with a fin, 60 mm long: nothing is left of it where needless vertices go."""
    sheets = Manifold.cube((60, 20, thick), True) + Manifold.cube((thick, 20, 30), True).translate((0, 0, 15))
    with pytest.raises(BadInput, match=r"thinner than .* mm everywhere: "):
        even(surface_of(sheets), 1000)


def test_what_cannot_be_had_without_them_is_refused(monkeypatch):
    monkeypatch.setattr("mechstyle.geometry.remeshing.evening.without_degenerate", lambda mesh, _least, _go_on=None: mesh)
    with pytest.raises(BadInput, match="without area"):
        even(twinned(cone(), range(0, 60, 7), 1e-10), 800)


def test_nothing_is_taken_out_of_a_tetrahedron():
    flat = SurfaceMesh(np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1e-6, 0, 0.5)]), [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    assert _shape(without_degenerate(flat.moved(flat.vertices * [1, 1, 1e-6]), LEAST)) == _shape(flat)
