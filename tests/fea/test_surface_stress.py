"""Stress on the surface against beam theory and handbooks, and where a mean over a ball decides instead."""

import numpy as np
import pytest

from mechstyle.fea.ball_average import largest_around
from mechstyle.fea.criterion import measures
from mechstyle.fea.statics.load_test import StaticTest
from mechstyle.fea.surface_stress import RESOLVED, SurfaceStress, worst
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.mesh import TetMesh
from mechstyle.simulation.validation import bending
from mechstyle.simulation.validation.bending import CLAMP, held_and_loaded
from mechstyle.simulation.validation.notches import THICKNESS, WIDTH, bar_with_fillets, bar_with_hole


def held_and_pulled(mesh, force, material):
    """Held at its low end along x and loaded at the other: response, what reads it, and the deciding stress."""
    found = held_and_loaded(mesh, force, material)
    return found.response, found.reading, found.load


def bent(mesh, stress, material):
    """A cantilever along x with a given stress at the clamp by beam theory [MPa]."""
    found = bending.bent(mesh, stress, material)
    return found.response, found.reading, found.load


@pytest.mark.parametrize("counts", [(25, 5, 1), (34, 6, 2)])
def test_a_cantilever_of_4_mm_has_the_safety_factor_of_beam_theory_within_a_tenth(box, pla, counts):
    _, _, found = bent(box(counts, (100.0, 20.0, 4.0)), CLAMP, pla)
    assert 1.10 <= pla.yield_strength / found.peak <= 1.34


@pytest.mark.parametrize(
    ("thickness", "counts"), [(0.8, (50, 10, 1)), (2.0, (40, 8, 1)), (4.0, (33, 7, 2)), (6.0, (33, 7, 2)), (8.0, (25, 5, 2))]
)
def test_plates_of_every_thickness_read_their_bending_stress_within_a_tenth(box, pla, thickness, counts):
    """Beyond 3 mm of the clamp; the mean over a ball reads about half of it in the thin ones, as the last line holds fast."""
    mesh = box(counts, (100.0, 20.0, thickness))
    response, reading, _ = bent(mesh, CLAMP, pla)
    along = reading.along(mesh, reading.at_vertices(mesh, response.corners)[0])
    x = reading.sides.positions[:, 0]
    far = (x >= 3.0) & (x <= 97.0)
    assert along[far].max() == pytest.approx(CLAMP * (1.0 - x[far].min() / 100.0), rel=0.1)
    in_ball = largest_around(mesh, response.von_mises, reading.average)[reading.sides.vertices[far]].max()
    assert in_ball < {0.8: 0.6, 2.0: 0.6, 4.0: 0.65}.get(thickness, 0.85) * CLAMP


def test_a_plate_whose_clamp_sees_80_mpa_is_not_read_below_yield(box, pla):
    _, _, found = bent(box((25, 5, 1), (60.0, 12.0, 3.0)), 80.0, pla)
    assert found.surface > 1.5 * pla.yield_strength
    assert found.peak == found.surface == measures(box((25, 5, 1), (60.0, 12.0, 3.0)), np.ones((750, 4)), found).peak


@pytest.mark.parametrize("fineness", [(24, 5, 1), (24, 5, 2), (32, 6, 2)])
def test_a_hole_concentrates_stress_as_in_the_handbook(pla, fineness):
    """Ø 6 in a bar of 20 mm: 3.35 times the stress far away (Howland 1930)."""
    mesh = bar_with_hole(3.0, *fineness)
    _, _, found = held_and_pulled(mesh, (10.0 * WIDTH * THICKNESS, 0.0, 0.0), pla)
    assert found.resolved == pytest.approx(33.5, rel=0.1)
    assert found.peak == found.resolved
    assert np.hypot(*found.where[:2]) == pytest.approx(3.0, abs=1e-6)
    assert found.averaged == pytest.approx(0.82 * 33.5, rel=0.05)  # the mean of 1 + 2 cos 2φ over 2 mm to both sides of the highest


def test_the_same_part_meshed_otherwise_reads_the_same(pla):
    found = [held_and_pulled(bar_with_hole(3.0, *cells), (800.0, 0.0, 0.0), pla)[2].averaged for cells in ((24, 5, 2), (32, 6, 2))]
    assert np.ptp(found) < 0.03 * np.mean(found)


@pytest.mark.parametrize("fineness", [(4, 10, 1), (6, 12, 2)])
def test_a_fillet_concentrates_stress_as_in_the_handbook(pla, fineness):
    """Radius 2 mm where 16 mm grow to 20 mm: 1.86 times the stress in the narrow part (Pilkey, Peterson's Stress Concentration Factors)."""
    mesh = bar_with_fillets(2.0, *fineness)
    _, _, found = held_and_pulled(mesh, (10.0 * (WIDTH - 4.0) * THICKNESS, 0.0, 0.0), pla)
    assert found.resolved == pytest.approx(18.6, rel=0.12)
    assert 0.65 * 18.6 < found.averaged < found.resolved
    assert 0.0 <= found.where[0] <= 2.0


def test_twice_the_stress_reads_twice(block):
    reading, rng = SurfaceStress(block), np.random.default_rng(0)
    points, corners = rng.uniform(0.0, 50.0, (2, len(block.tets), 4))
    marked = block.vertices[:, 2] < 1.0
    for read in (reading.of_landing, reading.of_load):
        once, twice = read(block, points, corners, marked), read(block, 2.0 * points, 2.0 * corners, marked)
        np.testing.assert_allclose(twice.field, 2.0 * once.field)
        for name in ("surface", "contact", "averaged", "resolved", "peak"):
            assert getattr(twice, name) == pytest.approx(2.0 * getattr(once, name))
        assert twice.where == once.where


def test_more_stress_anywhere_never_reads_as_less_in_a_landing(block):
    reading, rng = SurfaceStress(block), np.random.default_rng(1)
    points, corners, more = rng.uniform(0.0, 50.0, (3, len(block.tets), 4))
    touched = block.vertices[:, 2] < 1.0
    less = reading.of_landing(block, points, corners, touched)
    other = reading.of_landing(block, points + more.min(axis=1, keepdims=True), corners + more, touched)
    assert (other.field >= less.field - 1e-9).all()


def test_the_field_on_the_surface_is_what_decides(block):
    reading, rng = SurfaceStress(block), np.random.default_rng(2)
    points, corners = rng.uniform(0.0, 50.0, (2, len(block.tets), 4))
    found = reading.of_landing(block, points, corners, block.vertices[:, 2] < 1.0)
    on = np.unique(block.boundary_faces)
    assert found.field[on].max() == found.peak == max(found.surface, found.contact)
    assert min(found.surface, found.contact) > 0.0
    assert found.where == tuple(block.vertices[on[found.field[on].argmax()]])
    inside = np.setdiff1d(np.arange(len(block.vertices)), on)
    ball = largest_around(block, points, reading.average)
    assert np.array_equal(found.field[inside], ball[inside])
    assert found.contact == ball[found.field == ball][np.isin(np.flatnonzero(found.field == ball), on)].max()


def test_stress_at_a_vertex_is_the_mean_over_its_tetrahedra_and_jumps_by_what_the_largest_exceeds_it(block):
    corners = np.random.default_rng(3).uniform(1.0, 50.0, (len(block.tets), 4))
    stress, jump = SurfaceStress(block).at_vertices(block, corners)
    for vertex in (0, 40, 99):
        tet, corner = np.nonzero(block.tets == vertex)
        expected = np.average(corners[tet, corner], weights=block.volumes[tet])
        assert stress[vertex] == pytest.approx(expected)
        assert jump[vertex] == pytest.approx(corners[tet, corner].max() / expected - 1.0)


def test_what_the_mesh_does_not_resolve_counts_as_the_mean_along_the_surface(box):
    """A peak at one vertex of the upper side, the same from all its tetrahedra, or from one of them only."""
    mesh = box((8, 8, 2), (8.0, 8.0, 4.0))
    top = int(np.argmin(np.linalg.norm(mesh.vertices - [4.0, 4.0, 4.0], axis=1)))
    reading, nowhere = SurfaceStress(mesh), np.zeros(len(mesh.vertices), bool)
    even, odd = np.full((2, len(mesh.tets), 4), 10.0)
    even[mesh.tets == top] = 100.0
    odd[tuple(np.argwhere(mesh.tets == top)[0])] = 100.0
    resolved = reading.of_load(mesh, even, even, nowhere)
    assert resolved.peak == resolved.resolved == pytest.approx(100.0)
    assert resolved.averaged < 60.0
    unresolved = reading.of_load(mesh, odd, odd, nowhere)
    stress, jump = reading.at_vertices(mesh, odd)
    assert jump[top] > RESOLVED
    assert unresolved.resolved < stress[top]
    assert reading.of_landing(mesh, even, even, nowhere).peak == pytest.approx(resolved.averaged)


def test_the_narrow_top_of_a_rib_is_not_averaged_with_its_sides(box):
    """Bending of a rib 1 mm wide: its top carries the most, its sides less the deeper; all vertices lie on sharp edges."""
    mesh = box((20, 1, 4), (20.0, 1.0, 6.0))
    corners = 50.0 * np.abs(mesh.vertices[mesh.tets][..., 2] - 3.0) / 3.0
    found = SurfaceStress(mesh).of_landing(mesh, corners, corners, np.zeros(len(mesh.vertices), bool))
    assert found.surface == pytest.approx(50.0)


def test_each_landing_has_its_own_zone_and_the_worst_is_the_larger_place_by_place(box):
    mesh = box((10, 4, 4), (30.0, 8.0, 8.0))
    reading = SurfaceStress(mesh)
    stress = np.where(mesh.vertices[mesh.tets][..., 0] < 3.5, 80.0, 20.0)
    touched = [mesh.vertices[:, 0] < 0.5, mesh.vertices[:, 0] > 29.5]
    there, elsewhere = (reading.of_landing(mesh, stress, stress, one) for one in touched)
    assert (there.contact, elsewhere.contact) == (pytest.approx(80.0, rel=0.05), pytest.approx(20.0))
    assert there.surface < 80.0 == pytest.approx(elsewhere.surface)
    both = worst([there, elsewhere])
    assert np.array_equal(both.field, np.maximum(there.field, elsewhere.field))
    assert (both.surface, both.contact) == (elsewhere.surface, there.contact)
    assert both.peak == max(there.peak, elsewhere.peak)
    assert (both.surface_where, both.contact_where) == (elsewhere.surface_where, there.contact_where)
    assert both.contact_where[0] < 3.5, "the largest stress in a zone is told where it is, not where the surface bears most"


def test_pressure_on_a_whole_side_does_not_hide_the_bending_of_that_side(box, pla):
    """Only the border of a load has no limit: with the whole side as a zone a ball would halve what the side carries."""
    mesh, end = box((20, 5, 1), (40.0, 10.0, 2.0)), Patch(plane=(0, 0, 0, -1, 0, 0))
    top = Patch(plane=(0, 0, 2, 0, 0, 1))
    test = StaticTest(mesh, (LoadCase(name="snow", supports=(Support(at=end),), loads=(Load(at=top, pressure=0.02),)),))
    response, reading = test.run(mesh, pla)["snow"], SurfaceStress(mesh)
    zone = reading.border_zone(test.borders["snow"])
    middle = (np.abs(reading.sides.positions[:, 1] - 5.0) < 2.5) & (reading.sides.positions[:, 0] > 3.0)
    middle &= (reading.sides.positions[:, 0] < 37.0) & np.isclose(reading.sides.positions[:, 2], 2.0)
    assert middle.any()
    assert not zone[middle].any()
    found = reading.of_load(mesh, response.von_mises, response.corners, test.borders["snow"])
    x = reading.sides.positions[middle, 0]
    theory = 0.02 * 10.0 * (40.0 - x) ** 2 / 2.0 / (10.0 * 2.0**2 / 6.0)
    assert found.field[reading.sides.vertices[middle]] == pytest.approx(theory, rel=0.15, abs=1.0)


def with_thorn(mesh, at, outwards):
    """A mesh with one more tetrahedron, on the face of its boundary that is nearest to a place."""
    faces = mesh.boundary_faces
    face = faces[np.linalg.norm(mesh.vertices[faces].mean(axis=1) - at, axis=1).argmin()]
    apex = mesh.vertices[face].mean(axis=0) + outwards
    return TetMesh(np.concatenate([mesh.vertices, [apex]]), np.concatenate([mesh.tets, [[*face, len(mesh.vertices)]]]))


@pytest.mark.parametrize("edge", [1.0, 2.0])
def test_a_thorn_beside_contact_is_contact_although_its_upper_side_looks_away(box, edge):
    count = round(8.0 / edge)
    mesh = with_thorn(box((count, count, count), (8.0, 8.0, 8.0)), (4.0, 0.0, 0.5 * edge), (0.0, -0.8 * edge, 0.0))
    reading = SurfaceStress(mesh)
    thorn = np.isin(reading.sides.vertices, mesh.tets[-1])
    upper = thorn & (reading.sides._directions[:, 2] > 0.3)
    assert upper.sum() == 3
    assert reading.contact_zone(np.isclose(mesh.vertices[:, 2], 0.0))[thorn].all()


def test_a_thorn_over_contact_bends_with_the_floor_it_is_on(box):
    """One of the sides of the thorn looks down the slope; taking that for contact would see half of the bending of a floor of 1 mm."""
    mesh = with_thorn(box((20, 20, 1), (20.0, 20.0, 1.0)), (10.0, 10.0, 1.0), (0.4, 0.0, 0.3))
    reading = SurfaceStress(mesh)
    thorn = np.isin(reading.sides.vertices, mesh.tets[-1])
    assert reading._splinters[thorn].any()
    assert not reading.contact_zone(np.isclose(mesh.vertices[:, 2], 0.0))[thorn].any()


@pytest.mark.parametrize("bears", [200.0, 400.0])
def test_a_splinter_of_the_mesh_is_no_side_that_a_stress_is_averaged_over(box, bears):
    """A dart of 0.01 mm² told 188 MPa on a hook whose next largest stress was 60: what its side lacks is averaged around it."""
    mesh = with_thorn(box((12, 12, 4), (6.0, 6.0, 2.0)), (3.0, 3.0, 2.0), (0.1, 0.0, 0.3))
    corners = np.full((len(mesh.tets), 4), 10.0)
    corners[-1] = bears
    reading = SurfaceStress(mesh)
    nothing = np.zeros(len(mesh.vertices), dtype=bool)
    found = reading.of_landing(mesh, corners, corners, nothing)
    assert 10.0 < found.surface < 0.2 * bears
    assert found.outside[reading.sides.vertices].max() == found.surface
    assert reading.of_load(mesh, corners, corners, nothing).peak < 0.2 * bears, "one tetrahedron has no jump, and resolves nothing"


@pytest.mark.parametrize("width", [0.4, 0.6])
def test_a_narrow_side_that_bears_the_most_is_still_one(box, pla, width):
    """The unsafe side: a strip as wide as a line of plastic has less than 2 mm² within 2 mm, and bends all the same."""
    mesh = box((50, 1, 5), (100.0, width, 10.0))
    response, reading, _ = bent(mesh, CLAMP, pla)
    along = reading.along(mesh, reading.at_vertices(mesh, response.corners)[0])
    x = reading.sides.positions[:, 0]
    far = (x >= 3.0) & (x <= 97.0)
    assert along[far].max() == pytest.approx(CLAMP * (1.0 - x[far].min() / 100.0), rel=0.1)


def test_of_the_upper_side_of_a_floor_none_but_a_pointed_corner_may_count_as_contact(box):
    """There is less than a splinter of it within 2 mm of the corner, where nothing bends; 1 mm further the side is told from the other."""
    straight = box((20, 20, 1), (20.0, 20.0, 1.0))
    mesh = straight.moved(straight.vertices + straight.vertices[:, 1:2] * [1.0, 0.0, 0.0])
    reading = SurfaceStress(mesh)
    zone = reading.contact_zone(np.isclose(mesh.vertices[:, 2], 0.0))
    upper = reading.sides._directions[:, 2] > 0.9
    corner = np.linalg.norm(reading.sides.positions[:, None] - [[0.0, 0.0, 1.0], [40.0, 20.0, 1.0]], axis=2).min(axis=1) < 0.1
    assert upper.sum() > 400
    assert not zone[upper & ~corner].any()


def test_zones_reach_5_mm_from_contact_and_2_mm_from_a_border(box):
    mesh = box((20, 20, 4), (20.0, 20.0, 8.0))
    reading = SurfaceStress(mesh)
    one = np.linalg.norm(mesh.vertices - [10.0, 10.0, 8.0], axis=1) < 0.1
    distance = np.linalg.norm(reading.sides.positions - [10.0, 10.0, 8.0], axis=1)
    assert one.sum() == 1
    assert np.array_equal(reading.contact_zone(one), distance <= 5.0), "a mean over 2 mm sees nothing nearer than 3 mm"
    assert np.array_equal(reading.border_zone(one), distance <= 2.0)


def test_the_floor_of_a_joint_is_read_without_the_bricks_beside_it_on_a_mesh_with_all_of_its_relief(box):
    """With half of the relief its walls are less than 60° steep, and a mean over 2 mm takes them and the bricks for the same side."""
    straight = box((40, 10, 4), (40.0, 10.0, 6.0))
    joint = np.isclose(straight.vertices[:, 2], 6.0) & (np.abs(straight.vertices[:, 0] - 20.0) < 1.1)
    half, whole = (straight.moved(straight.vertices - np.outer(depth * joint, [0.0, 0.0, 1.0])) for depth in (1.3, 2.6))

    def read(made_from):
        reading = SurfaceStress(made_from)
        middle = np.isclose(straight.vertices[reading.sides.vertices], [20.0, 5.0, 6.0]).all(axis=1)
        assert middle.sum() == 1
        return reading.along(whole, joint.astype(np.float64))[middle][0]

    assert read(whole) == pytest.approx(1.0)
    assert read(half) < 0.85
