"""Morphing: exact at rest, honest about what could not be followed, and idempotent."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold

from mechstyle.errors import BadInput
from mechstyle.geometry.morph import Morph, laplacian
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.evening import even, surface_of
from mechstyle.geometry.remeshing.filling import fill
from mechstyle.records.mesh import SurfaceMesh


@pytest.fixture(scope="module")
def morph(cup, cup_tets):
    return Morph(cup, cup_tets)


def waves(cup, height):
    x, y, z = cup.vertices.T
    return (height * np.sin(0.7 * x) * np.sin(0.6 * y + 0.5 * z)).astype(np.float32)


def test_no_displacement_gives_the_same_vertices_bit_for_bit(cup, cup_tets, morph):
    result = morph.morphed(np.zeros(len(cup.vertices), np.float32))
    assert result.tets.vertices.tobytes() == cup_tets.vertices.tobytes()
    assert (result.backed_off, result.deviation) == (0.0, 0.0)


def test_small_relief_is_followed_in_full(cup, morph):
    """But for a place or two: no two meshes of fTetWild's are alike, and one in thirty has a tetrahedron too low for it."""
    request = waves(cup, 0.3)
    result = morph.morphed(request)
    assert result.backed_off < 0.03
    assert np.mean(result.displacement == request) > 0.97
    assert result.tets.quality.min() > 0.0


def test_growth_of_the_whole_surface_grows_the_volume(cup, cup_tets, morph):
    result = morph.morphed(np.full(len(cup.vertices), 0.1, np.float32))
    gained = result.tets.volumes.sum() - cup_tets.volumes.sum()
    assert gained == pytest.approx(0.1 * cup.face_areas.sum(), rel=0.1)  # vertex normals cut the corners of sharp edges


def test_the_boundary_goes_where_the_surface_goes(cup, cup_tets, morph):
    shift = 0.2
    result = morph.morphed(np.full(len(cup.vertices), shift, np.float32))
    outer = np.unique(cup_tets.boundary_faces)
    wall = outer[(np.abs(np.hypot(*cup_tets.vertices[outer, :2].T) - 20) < 0.05) & (np.abs(cup_tets.vertices[outer, 2] - 15) < 8)]
    moved = np.hypot(*result.tets.vertices[wall, :2].T) - np.hypot(*cup_tets.vertices[wall, :2].T)
    assert moved == pytest.approx(shift, abs=0.02)


def test_what_would_spoil_a_tetrahedron_is_backed_off_and_reported(cup, morph):
    request = waves(cup, 6.0)
    result = morph.morphed(request)
    assert result.tets.volumes.min() > 0.0
    assert 0.0 < result.backed_off <= 1.0
    assert result.deviation == pytest.approx(np.abs(request - result.displacement).max(), rel=1e-3)
    assert np.all(np.abs(result.displacement) <= np.abs(request) + 1e-6)


def test_asking_again_for_what_was_given_changes_nothing(cup, morph):
    once = morph.morphed(waves(cup, 6.0))
    twice = morph.morphed(once.displacement)
    assert twice.backed_off == 0.0
    assert np.array_equal(twice.displacement, once.displacement)
    assert np.array_equal(twice.tets.vertices, once.tets.vertices)


def test_inner_vertices_stay_inside_the_surface(cup, morph):
    result = morph.morphed(waves(cup, 0.5))
    surface = SurfaceMesh(result.tets.vertices, result.tets.boundary_faces)
    assert surface.is_closed
    assert surface.volume == pytest.approx(result.tets.volumes.sum(), rel=1e-9)


@pytest.mark.parametrize("broken", [np.zeros(3), None], ids=["wrong length", "not finite"])
def test_a_request_that_is_no_displacement_is_refused(cup, morph, broken):
    request = np.full(len(cup.vertices), np.nan) if broken is None else broken
    with pytest.raises(BadInput, match=f"needs {len(cup.vertices)} finite numbers"):
        morph.morphed(request)


@pytest.mark.parametrize("seed", range(3))
def test_white_noise_higher_than_the_wall_comes_to_an_end(cup, morph, seed):
    request = np.random.default_rng(seed).normal(0.0, 5.0, len(cup.vertices))
    result = morph.morphed(request)
    assert result.tets.volumes.min() > 0.0
    assert np.array_equal(morph.morphed(result.displacement).tets.vertices, result.tets.vertices)


def test_back_off_stays_where_it_is_needed(cup, morph):
    x, y, z = cup.vertices.T
    dent = np.where((x > 19.9) & (np.abs(y) < 3) & (np.abs(z - 15) < 3), -8.0, 0.0).astype(np.float32)
    without, dented = morph.morphed(waves(cup, 0.3)), morph.morphed(waves(cup, 0.3) + dent)
    far = x < 0
    assert dented.backed_off > without.backed_off
    assert np.array_equal(dented.displacement[far], without.displacement[far])


def test_quality_is_kept_above_its_floor(cup, cup_tets, morph):
    result = morph.morphed(waves(cup, 6.0))
    assert np.all(result.tets.quality >= np.minimum(0.08, 0.5 * cup_tets.quality))


def test_the_laplacian_knows_constants_and_linear_fields(cup_tets):
    stiffness = laplacian(cup_tets)
    inner = np.setdiff1d(np.arange(len(cup_tets.vertices)), cup_tets.boundary_faces)
    assert abs(stiffness - stiffness.T).max() < 1e-9
    assert stiffness @ np.ones(len(cup_tets.vertices)) == pytest.approx(0.0, abs=1e-9)
    assert (stiffness @ cup_tets.vertices)[inner] == pytest.approx(0.0, abs=1e-9)  # linear fields are harmonic
    x = cup_tets.vertices[:, 0]
    assert x @ stiffness @ x == pytest.approx(cup_tets.volumes.sum(), rel=1e-9)  # ∫ |∇x|² = V


@pytest.fixture(scope="module")
def tile(cache):
    """A 24 × 16 × 6 mm slab in even triangles, a brick-like relief all over it, and tetrahedra made for half of that."""
    slab = even(surface_of(Manifold.cube((24.0, 16.0, 6.0))), 1500)
    relief = bricks(slab)
    return slab, relief, fill(slab.displaced(0.5 * relief), 4000, keep=slab.displaced(2.0 * relief), cache=cache / "tets")


def bricks(surface, height=0.6):
    """Blocks with grooves between them, drawn inwards."""
    joints = np.abs(np.sin(0.8 * surface.vertices)).min(axis=1)
    return (-height * np.exp(-((joints / 0.35) ** 2))).astype(np.float32)


def test_tets_made_for_a_displacement_come_back_bit_for_bit(tile):
    slab, relief, tets = tile
    half = 0.5 * relief
    result = Morph(slab, tets, half).morphed(half)
    assert np.array_equal(result.tets.vertices, tets.vertices)
    assert np.array_equal(result.displacement, half)
    assert result.backed_off == 0.0


def test_the_way_to_none_and_to_all_of_the_relief_turns_nothing_inside_out(tile):
    slab, relief, tets = tile
    morph = Morph(slab, tets, 0.5 * relief)
    for wanted in (np.zeros_like(relief), relief):
        result = morph.morphed(wanted)
        assert result.tets.volumes.min() > 0.0
        assert result.backed_off < 0.1
        assert result.tets.volumes.sum() == pytest.approx(slab.displaced(result.displacement).volume, rel=0.01)
        assert np.array_equal(morph.morphed(result.displacement).tets.vertices, result.tets.vertices)


def test_no_node_goes_below_the_floor_of_the_surface_it_follows(tile):
    slab, relief, tets = tile
    morph = Morph(slab, tets, 0.5 * relief)
    for share in (0.0, 0.07, 0.15, 0.9, 1.0):
        result = morph.morphed(share * relief)
        floor = slab.displaced(result.displacement).vertices[:, 2].min()
        assert result.tets.vertices[:, 2].min() >= floor - 1e-9, f"a node stands out at {share:.0%} of the relief"


def test_a_base_that_is_laid_flat_stands_on_all_of_its_nodes(tile):
    """Nodes of which some lay on the floor and others hundredths of a millimetre above it: an impact went through the few."""
    slab, relief, tets = tile
    under = slab.vertices[:, 2] < 1e-6
    laid_flat = np.where(under, np.float32(0.0), relief)
    result = Morph(slab, tets, 0.5 * relief).morphed(laid_flat)
    outer = np.unique(tets.boundary_faces)
    below = TriangleTree(slab.vertices, slab.faces).interpolation(tets.vertices[outer]) @ slab.vertices[:, 2] < 1e-6
    heights = result.tets.vertices[outer[below], 2]
    assert len(heights) > 50
    assert np.mean(heights > 1e-6) < 0.02, "but for those that a tetrahedron would be spoilt by"


def test_without_relief_they_are_the_original(tile):
    slab, relief, tets = tile
    result = Morph(slab, tets, 0.5 * relief).morphed(np.zeros_like(relief))
    outer = np.unique(tets.boundary_faces)
    off = TriangleTree(slab.vertices, slab.faces).nearest(result.tets.vertices[outer]).distance
    assert np.quantile(off, 0.9) < 0.04, "fTetWild's envelope of 0.01 mm, and what vertices may be moved to make tetrahedra higher"
    assert off.max() <= result.deviation + 0.05


def test_what_is_reduced_is_reduced_towards_what_they_were_made_for(tile):
    slab, relief, tets = tile
    half, wanted = 0.5 * relief, 12.0 * relief
    result = Morph(slab, tets, half).morphed(wanted)
    assert result.backed_off > 0.0
    assert np.all(result.displacement <= half + 1e-6)
    assert np.all(result.displacement >= wanted - 1e-6)


def test_they_carry_what_tets_of_the_part_at_rest_do_not(tile, cache):
    slab, relief, tets = tile
    at_rest = Morph(slab, fill(slab, 800, cache=cache / "tets"))
    shares = [followed_share(morph.morphed(relief), relief) for morph in (at_rest, Morph(slab, tets, 0.5 * relief))]
    assert shares[0] < 0.7
    assert shares[1] > 0.9


def test_nothing_grows_where_they_cannot_come_back(tile):
    """A stand-in is no relief: what nobody asked for is not delivered."""
    slab, relief, tets = tile
    half, opposite = 0.5 * relief, -6.0 * relief
    result = Morph(slab, tets, half).morphed(opposite)
    assert result.backed_off > 0.0
    assert result.displacement.min() >= 0.0
    assert result.deviation > 0.0


def followed_share(result, relief):
    wanted = result.displacement - result.displacement.mean()
    return float(wanted @ result.followed / (wanted @ wanted))
