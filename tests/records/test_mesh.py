"""The two meshes: frozen arrays, closedness, normals, volumes, digests."""

import itertools
import pickle

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from mechstyle.records.mesh import SurfaceMesh, TetMesh, digest_of, frozen_array

# A corner of a cube cut off: right angles at the first vertex, volume 1/6.
CORNER_TET = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
REGULAR_TET = np.array([(1.0, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])[[0, 2, 1, 3]]
# The cube's corner 4x + 2y + z cut into six tetrahedra around the diagonal 0-7 (Kuhn 1960).
KUHN_TETS = np.array([(0, 4, 6, 7), (0, 6, 2, 7), (0, 2, 3, 7), (0, 3, 1, 7), (0, 1, 5, 7), (0, 5, 4, 7)])


def kuhn_cube(side=10.0):
    return TetMesh(side * np.array(list(itertools.product((0.0, 1.0), repeat=3))), KUHN_TETS)


coordinates = arrays(np.float64, (4, 3), elements=st.floats(-100, 100, allow_subnormal=False))
rotations = st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1), st.floats(0.1, 1)).map(np.array)


def rotation_matrix(quaternion):
    x, y, z, w = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


# --- frozen arrays ------------------------------------------------------------------------------------------------


def test_frozen_array_is_a_copy_that_cannot_be_written():
    source = np.zeros((4, 3))
    frozen = frozen_array(source, np.float32, (None, 3), "points")
    source[0] = 1.0
    assert frozen.dtype == np.float32
    assert not frozen.any()
    with pytest.raises(ValueError, match="read-only"):
        frozen[0] = 1.0


def test_frozen_array_names_the_array_the_shape_wanted_and_the_shape_given():
    with pytest.raises(ValueError, match=r"^stress must have shape \(n, 3\), not \(4, 2\)$"):
        frozen_array(np.zeros((4, 2)), np.float64, (None, 3), "stress")
    with pytest.raises(ValueError, match=r"^stress must have shape \(5\), not \(4, 1\)$"):
        frozen_array(np.zeros((4, 1)), np.float64, (5,), "stress")


@pytest.mark.parametrize("array", ["vertices", "faces"])
def test_surface_arrays_are_write_protected(cube, array):
    with pytest.raises(ValueError, match="read-only"):
        getattr(cube, array)[0] = 0
    with pytest.raises(AttributeError):
        setattr(cube, array, None)


def test_surface_does_not_follow_the_arrays_it_was_made_from(cube):
    vertices = cube.vertices.copy()
    mesh = SurfaceMesh(vertices, cube.faces)
    before = mesh.digest
    vertices += 1.0
    assert np.array_equal(mesh.vertices, cube.vertices)
    assert SurfaceMesh(mesh.vertices, mesh.faces).digest == before


@pytest.mark.parametrize("face", [(0, 1, 8), (-1, 0, 1)])
def test_a_face_that_names_no_vertex_is_refused(cube, face):
    with pytest.raises(ValueError, match="faces must index the 8 vertices"):
        SurfaceMesh(cube.vertices, [face])


def test_wrong_shapes_are_refused_by_name(cube):
    with pytest.raises(ValueError, match="vertices must have shape"):
        SurfaceMesh(cube.vertices[:, :2], cube.faces)
    with pytest.raises(ValueError, match="faces must have shape"):
        SurfaceMesh(cube.vertices, np.zeros((3, 4)))
    with pytest.raises(ValueError, match=r"colours must have shape \(8, 3\)"):
        cube.coloured(np.zeros((7, 3)))


# --- the cube -----------------------------------------------------------------------------------------------------


def test_cube_measures(cube):
    assert cube.volume == pytest.approx(1000.0, rel=1e-14)
    assert cube.face_areas.sum() == pytest.approx(600.0, rel=1e-14)
    assert cube.vertex_areas.sum() == pytest.approx(600.0, rel=1e-14)
    assert cube.extents.tolist() == [10.0, 10.0, 10.0]
    assert cube.size == pytest.approx(10.0 * np.sqrt(3.0))
    assert len(cube.edges) == 18  # Euler: V - E + F = 8 - 18 + 12 = 2
    assert np.all(cube.edges[:, 0] < cube.edges[:, 1])


def test_cube_face_normals_point_away_from_its_centre(cube):
    outwards = cube.corners.mean(axis=1) - 5.0
    assert np.allclose(np.abs(cube.face_normals).max(axis=1), 1.0)
    assert np.all(np.einsum("ij,ij->i", cube.face_normals, outwards) > 4.99)


def test_cube_vertex_normals_are_the_diagonals_however_its_faces_are_cut(cube):
    """Angle weights make the normal of a corner independent of which diagonal cuts each square; area weights do not."""
    diagonals = (cube.vertices - 5.0) / np.linalg.norm(cube.vertices - 5.0, axis=1, keepdims=True)
    assert np.allclose(cube.vertex_normals, diagonals, atol=1e-14)


def test_repr_shows_counts_and_never_arrays(cube):
    assert repr(cube) == "SurfaceMesh(8 vertices, 12 faces, 10.0 x 10.0 x 10.0 mm)"
    assert repr(SurfaceMesh(np.zeros((0, 3)), np.zeros((0, 3)))) == "SurfaceMesh(0 vertices, 0 faces, 0.0 x 0.0 x 0.0 mm)"
    assert repr(kuhn_cube()) == "TetMesh(8 vertices, 6 tets, 1000 mm³)"


# --- closed or not ------------------------------------------------------------------------------------------------


def test_cube_and_sphere_are_closed(cube, sphere):
    assert cube.is_closed
    assert sphere.is_closed


@pytest.mark.parametrize("missing", range(12))
def test_a_hole_opens_it(cube, missing):
    assert not SurfaceMesh(cube.vertices, np.delete(cube.faces, missing, axis=0)).is_closed


@pytest.mark.parametrize("flipped", range(12))
def test_one_face_turned_over_opens_it(cube, flipped):
    faces = cube.faces.copy()
    faces[flipped] = faces[flipped, ::-1]
    assert not SurfaceMesh(cube.vertices, faces).is_closed


def test_all_faces_turned_over_stays_closed_with_negative_volume(cube):
    inside_out = SurfaceMesh(cube.vertices, cube.faces[:, ::-1])
    assert inside_out.is_closed
    assert inside_out.volume == pytest.approx(-1000.0, rel=1e-14)


def test_two_cubes_that_share_an_edge_are_not_a_surface(cube):
    """Four faces meet in the edge 6-7, each direction twice."""
    other = cube.vertices + np.array([10.0, 10.0, 0.0])
    rows = [6, 7, *range(8, 14)]
    faces = np.array(rows)[cube.faces]
    mesh = SurfaceMesh(np.vstack([cube.vertices, other[2:]]), np.vstack([cube.faces, faces]))
    assert np.array_equal(mesh.vertices[[6, 7]], other[:2])
    assert not mesh.is_closed


def test_a_doubled_face_is_not_closed(cube):
    there_and_back = np.vstack([cube.faces, cube.faces[:1], cube.faces[:1, ::-1]])
    assert not SurfaceMesh(cube.vertices, there_and_back).is_closed


def test_two_separate_bodies_are_closed(cube):
    both = SurfaceMesh(np.vstack([cube.vertices, cube.vertices + 20.0]), np.vstack([cube.faces, cube.faces + 8]))
    assert both.is_closed
    assert both.volume == pytest.approx(2000.0)


def test_nothing_is_not_closed():
    assert not SurfaceMesh(np.zeros((0, 3)), np.zeros((0, 3))).is_closed


# --- the sphere ---------------------------------------------------------------------------------------------------


def test_sphere_normals_are_its_radii(sphere):
    """To the square of edge over radius, the order at which a polyhedron departs from the sphere through its corners."""
    longest = np.linalg.norm(np.diff(sphere.vertices[sphere.edges], axis=1), axis=2).max() / 10.0
    assert np.linalg.norm(sphere.vertex_normals - sphere.vertices / 10.0, axis=1).max() < longest**2
    assert np.allclose(np.linalg.norm(sphere.vertex_normals, axis=1), 1.0, atol=1e-14)


def test_sphere_volume_and_area_approach_from_below(sphere):
    """An inscribed polyhedron is smaller, by about the square of edge over radius."""
    volume, area = 4.0 / 3.0 * np.pi * 1000.0, 4.0 * np.pi * 100.0
    assert 0.998 * volume < sphere.volume < volume
    assert 0.999 * area < sphere.face_areas.sum() < area
    assert sphere.vertex_areas.sum() == pytest.approx(sphere.face_areas.sum())


@pytest.mark.parametrize("distance", [-2.0, 0.0, 0.5, 3.0])
def test_sphere_displaced_by_a_constant_is_a_larger_sphere(sphere, distance):
    """Normals 0.005 rad off the radius cost 1 - cos 0.005 = 1.3e-5 of the distance, once more 10/8 on the smallest sphere."""
    radii = np.linalg.norm(sphere.displaced(np.full(len(sphere.vertices), distance)).vertices, axis=1)
    assert np.abs(radii - (10.0 + distance)).max() < 1.7e-5 * abs(distance) + 1e-12


# --- displaced, moved, coloured -----------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_dilated_field_is_the_largest_value_around_each_vertex(sphere, dtype):
    values = np.random.default_rng(3).uniform(-1.0, 1.0, len(sphere.vertices)).astype(dtype)
    given = values.copy()
    expected = [values[[vertex, *sphere.edges[(sphere.edges == vertex).any(axis=1)].ravel()]].max() for vertex in range(len(values))]
    dilated = sphere.dilated(values)
    assert np.array_equal(dilated, expected)
    assert dilated.dtype == dtype
    assert np.array_equal(values, given)


def test_participles_leave_the_original_alone(cube):
    before = cube.digest
    moved = cube.moved(cube.vertices + 1.0)
    grown = cube.displaced(np.ones(8))
    painted = cube.coloured(np.full((8, 3), 0.5))
    assert SurfaceMesh(cube.vertices, cube.faces).digest == before
    assert np.allclose(moved.vertices, cube.vertices + 1.0)
    assert np.allclose(np.linalg.norm(grown.vertices - cube.vertices, axis=1), 1.0)
    assert painted.colours.dtype == np.float32
    assert cube.colours is None
    assert painted.coloured(None).colours is None


def test_what_was_worked_out_is_handed_on_as_far_as_it_holds(sphere):
    fresh = SurfaceMesh(sphere.vertices, sphere.faces)
    areas, edges = fresh.face_areas, fresh.edges
    painted, grown = fresh.coloured(np.full(sphere.vertices.shape, 0.5)), fresh.displaced(np.ones(len(sphere.vertices)))
    assert painted.face_areas is areas
    assert painted.edges is grown.edges is edges
    assert grown.face_areas.sum() == pytest.approx(1.21 * areas.sum(), rel=1e-3)  # of radius 11 instead of 10
    assert grown.digest != fresh.digest


@pytest.mark.parametrize("wrong", [np.ones(7), np.ones(1), np.ones((8, 1)), 1.0])
def test_displaced_refuses_a_wrong_shape_instead_of_spreading_it(cube, wrong):
    with pytest.raises(ValueError, match=r"displacement must have shape \(8\)"):
        cube.displaced(wrong)


def test_displacement_keeps_faces_and_colours(cube):
    painted = cube.coloured(np.full((8, 3), 0.25))
    grown = painted.displaced(np.ones(8))
    assert np.array_equal(grown.faces, cube.faces)
    assert np.array_equal(grown.colours, painted.colours)


@given(quaternion=rotations, shift=arrays(np.float64, 3, elements=st.floats(-1000, 1000)))
def test_volume_and_area_do_not_depend_on_the_place(cube, quaternion, shift):
    elsewhere = cube.moved(cube.vertices @ rotation_matrix(quaternion).T + shift)
    # Signed volumes about the origin cancel: their rounding grows with the cube of the distance, at most 1e-16 (1700 mm)^3.
    assert elsewhere.volume == pytest.approx(1000.0, abs=1e-5)
    assert elsewhere.face_areas.sum() == pytest.approx(600.0, rel=1e-9)


@given(quaternion=rotations)
def test_normals_turn_with_the_part(sphere, quaternion):
    turn = rotation_matrix(quaternion)
    assert np.allclose(sphere.moved(sphere.vertices @ turn.T).vertex_normals, sphere.vertex_normals @ turn.T, atol=1e-12)


@given(factor=st.floats(1e-3, 1e3))
def test_volume_grows_with_the_cube_of_the_scale(cube, factor):
    assert cube.moved(cube.vertices * factor).volume == pytest.approx(1000.0 * factor**3, rel=1e-12)


def test_a_face_without_area_has_a_zero_normal_and_no_nan():
    sliver = SurfaceMesh([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)])
    assert not sliver.face_normals.any()
    assert not sliver.vertex_normals.any()


def test_a_vertex_without_faces_has_a_zero_normal(cube):
    stray = SurfaceMesh(np.vstack([cube.vertices, [(50.0, 50.0, 50.0)]]), cube.faces)
    assert not stray.vertex_normals[8].any()
    assert stray.vertex_areas[8] == 0.0


# --- digests ------------------------------------------------------------------------------------------------------


def test_digest_does_not_depend_on_colours_or_on_memory_layout(cube):
    assert cube.coloured(np.ones((8, 3))).digest == cube.digest
    assert SurfaceMesh(np.asfortranarray(cube.vertices), cube.faces.astype(np.int64)).digest == cube.digest
    assert SurfaceMesh(cube.vertices.tolist(), cube.faces.tolist()).digest == cube.digest


@given(vertex=st.integers(0, 7), axis=st.integers(0, 2))
def test_digest_changes_with_the_last_bit_of_any_coordinate(cube, vertex, axis):
    vertices = cube.vertices.copy()
    vertices[vertex, axis] = np.nextafter(vertices[vertex, axis], np.inf)
    assert cube.moved(vertices).digest != cube.digest


def test_digest_changes_with_the_faces(cube):
    assert SurfaceMesh(cube.vertices, cube.faces[::-1]).digest != cube.digest


def test_digest_of_tells_shapes_and_types_apart():
    flat = np.arange(6, dtype=np.float32)
    same_bytes = [(flat,), (flat.reshape(2, 3),), (flat.reshape(3, 2),), (flat.view(np.int32),), (flat[:3], flat[3:])]
    assert len({digest_of(*these) for these in same_bytes}) == 5


# --- tetrahedra ---------------------------------------------------------------------------------------------------


def test_known_tets():
    corner = TetMesh(CORNER_TET, [(0, 1, 2, 3)])
    regular = TetMesh(REGULAR_TET, [(0, 1, 2, 3)])
    assert corner.volumes[0] == pytest.approx(1.0 / 6.0)
    assert corner.quality[0] == pytest.approx(12.0 * 0.5 ** (2.0 / 3.0) / 9.0)  # three edges of 1, three of √2
    assert regular.volumes[0] == pytest.approx(8.0 / 3.0)  # edge √8: l³/(6√2)
    assert regular.quality[0] == pytest.approx(1.0)


def test_a_tet_inside_out_is_negative_in_volume_and_quality():
    inverted = TetMesh(REGULAR_TET, [(0, 2, 1, 3)])
    assert inverted.volumes[0] == pytest.approx(-8.0 / 3.0)
    assert inverted.quality[0] == pytest.approx(-1.0)


@pytest.mark.parametrize("points", [np.zeros((4, 3)), np.eye(4, 3) * [1, 1, 0]], ids=["shrunk to a point", "flat"])
def test_a_tet_without_volume_has_quality_zero_and_no_nan(points):
    """NaN would pass a check for inverted or poor elements."""
    assert TetMesh(points, [(0, 1, 2, 3)]).quality.tolist() == [0.0]


@given(points=coordinates, quaternion=rotations, factor=st.floats(0.01, 100))
def test_quality_is_at_most_one_and_keeps_under_similarity(points, quaternion, factor):
    tet = TetMesh(points, [(0, 1, 2, 3)])
    longest = np.linalg.norm(points[:, None] - points[None], axis=2).max()
    assume(abs(tet.volumes[0]) > 1e-6 * longest**3)  # flatter: what rounding leaves of its volume has no shape
    similar = tet.moved(factor * points @ rotation_matrix(quaternion).T)
    assert abs(tet.quality[0]) <= 1.0 + 1e-12
    assert similar.quality[0] == pytest.approx(tet.quality[0], abs=1e-6)
    assert similar.volumes[0] == pytest.approx(factor**3 * tet.volumes[0], rel=1e-6)


def test_tet_boundary_of_a_single_tet_points_outwards():
    tet = TetMesh(CORNER_TET, [(0, 1, 2, 3)])
    surface = SurfaceMesh(tet.vertices, tet.boundary_faces)
    assert surface.is_closed
    assert surface.volume == pytest.approx(1.0 / 6.0)


def test_kuhn_cube_fills_the_cube_and_its_boundary_is_the_cube():
    tets = kuhn_cube()
    assert np.allclose(tets.volumes, 1000.0 / 6.0)
    assert len(tets.boundary_faces) == 12  # 24 faces, of which 6 pairs are inside
    boundary = SurfaceMesh(tets.vertices, tets.boundary_faces)
    assert boundary.is_closed
    assert boundary.volume == pytest.approx(1000.0)


@given(points=arrays(np.float64, (8, 3), elements=st.floats(-1, 1)))
def test_tets_and_their_boundary_hold_the_same_volume_even_when_bent(points):
    bent = kuhn_cube().moved(kuhn_cube().vertices + points)
    surface = SurfaceMesh(bent.vertices, bent.boundary_faces)
    assert surface.volume == pytest.approx(bent.volumes.sum(), rel=1e-9)


def test_tets_are_frozen_checked_and_named_by_content():
    tets = kuhn_cube()
    with pytest.raises(ValueError, match="read-only"):
        tets.tets[0] = 0
    with pytest.raises(ValueError, match="tets must index the 8 vertices"):
        TetMesh(tets.vertices, [(0, 1, 2, 8)])
    assert kuhn_cube().digest == tets.digest
    assert tets.moved(tets.vertices * 2.0).digest != tets.digest
    assert tets.moved(tets.vertices * 2.0).volumes.sum() == pytest.approx(8000.0)


def test_a_mesh_is_pickled_as_its_arrays_alone():
    """What is derived may be added to by another thread meanwhile, which would stop the pickling."""
    mesh = SurfaceMesh(np.eye(4)[:, :3], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
    bare = pickle.dumps(mesh)
    assert np.isfinite(mesh.vertex_normals).all()
    assert pickle.dumps(mesh) == bare
    back = pickle.loads(bare)
    assert back.digest == mesh.digest
    assert back.colours is None
