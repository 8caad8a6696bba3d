"""Places on a body: what each shape picks, with its own area whatever the mesh, and what a support there holds."""

import numpy as np
import pytest

from mechstyle.errors import BadInput
from mechstyle.fea.elements import QUADRATIC, element_named, with_nodes
from mechstyle.fea.statics import POINTS, Boundary, pick
from mechstyle.records.load_cases import Patch
from mechstyle.records.mesh import TetMesh

SIZE = (12.0, 10.0, 16.0)


@pytest.fixture(scope="module", params=["tet4", "tet10"])
def body(request, box):
    """A straight block of 12 x 10 x 16 mm."""
    return Boundary(with_nodes(box((4, 3, 4), SIZE), element_named(request.param)))


def test_the_points_of_a_triangle_integrate_quadratics_exactly():
    """∫ L_i L_j dA = A/12 for i ≠ j, A/6 for i = j; and all lie inside."""
    assert POINTS.min() > 0.0
    products = POINTS.T @ POINTS / len(POINTS)
    assert products == pytest.approx((np.ones((3, 3)) + np.eye(3)) / 12.0)


@pytest.mark.parametrize("order", [[0, 1, 2, 3], [1, 2, 0, 3], [3, 0, 2, 1], [2, 1, 3, 0]])
def test_middles_of_a_side_are_between_its_corners(box, order):
    """Whichever of its sides a tetrahedron has outside; the orders are even, so that volumes stay positive."""
    straight = box((4, 3, 4), SIZE)
    body = Boundary(with_nodes(TetMesh(straight.vertices, straight.tets[:, order]), QUADRATIC))
    nodes, sides = body.mesh.nodes, body.sides
    for middle, (first, second) in zip((3, 4, 5), ((0, 1), (0, 2), (1, 2)), strict=True):
        assert nodes[sides[:, middle]] == pytest.approx(0.5 * (nodes[sides[:, first]] + nodes[sides[:, second]]))
    assert body.areas.sum() == pytest.approx(2 * (120.0 + 160.0 + 192.0))
    outward = np.einsum("fx,fx->f", body.area_vectors, body.points.mean(axis=1) - np.array(SIZE) / 2)
    assert np.all(outward > 0.0)


def test_a_facet_ends_where_its_face_ends(box):
    """Of a U the tops of both legs look up at one height, but are not connected."""
    whole = box((6, 2, 4), (30.0, 10.0, 20.0))
    centre = whole.vertices[whole.tets].mean(axis=1)
    legs = TetMesh(whole.vertices, whole.tets[(np.abs(centre[:, 0] - 15.0) > 5.0) | (centre[:, 2] < 5.0)])
    boundary = Boundary(with_nodes(legs, QUADRATIC))
    assert pick(boundary, Patch(facet=(5, 5, 20))).area(boundary) == pytest.approx(100.0)
    assert pick(boundary, Patch(plane=(0, 0, 20, 0, 0, 1))).area(boundary) == pytest.approx(200.0)


@pytest.mark.parametrize(
    ("place", "area", "held"),
    [
        ("resting face", 120.0, lambda x: x[:, 2] == 0.0),
        (Patch(plane=(0, 0, 16, 0, 0, 1)), 120.0, lambda x: x[:, 2] == 16.0),
        (Patch(box=(12, 0, 0, 12, 10, 16)), 160.0, lambda x: x[:, 0] == 12.0),
        (Patch(box=(12.000005, 0, 0, 13, 10, 16)), 160.0, lambda x: x[:, 0] == 12.0),
        (Patch(facet=(6, -3, 8)), 192.0, lambda x: x[:, 1] == 0.0),
        (Patch(facet=(6, -3, 8), angle=90), 192.0 + 2 * 160.0 + 2 * 120.0, lambda x: x[:, 1] < 10.0),
    ],
)
def test_a_whole_face_has_its_area_and_its_nodes(body, place, area, held):
    picked = pick(body, place)
    assert picked.area(body) == pytest.approx(area)
    on_boundary = np.zeros(len(body.mesh.nodes), bool)
    on_boundary[body.sides] = True
    expected = held(body.mesh.nodes) & on_boundary
    if getattr(place, "angle", 20.0) < 90.0:
        assert np.array_equal(picked.nodes, expected)


@pytest.mark.parametrize(
    ("place", "area"),
    [
        (Patch(near=(6, 5, 30, 3)), np.pi * 9.0),
        (Patch(sphere=(6, 5, 16, 3)), np.pi * 9.0),
        (Patch(box=(2, 2, 15, 5, 6, 17)), 12.0),
        (Patch(plane=(0, 0, 13, 0, 0, 1)), 120.0 + 3 * 44.0),
    ],
)
def test_a_piece_cut_off_across_the_sides_of_the_mesh_has_its_own_area(body, place, area):
    assert pick(body, place).area(body) == pytest.approx(area, rel=0.08)


def test_near_picks_one_side_of_a_wall_and_a_sphere_both(box):
    wall = Boundary(with_nodes(box((6, 1, 6), (20.0, 1.0, 20.0)), QUADRATIC))
    near, sphere = (pick(wall, patch) for patch in (Patch(near=(10, -2, 10, 4)), Patch(sphere=(10, 0, 10, 4))))
    assert near.area(wall) == pytest.approx(np.pi * 16.0, rel=0.05)
    assert sphere.area(wall) == pytest.approx(np.pi * (16.0 + 15.0), rel=0.05)
    assert np.unique(wall.mesh.nodes[near.nodes, 1]) == pytest.approx([0.0])


def test_a_piece_smaller_than_a_side_is_held_by_the_sides_it_touches(body):
    picked = pick(body, Patch(sphere=(5.1, 4.2, 0.0, 0.6)))
    assert picked.nodes.sum() >= 3
    assert np.linalg.norm(body.mesh.nodes[picked.nodes] - (5.1, 4.2, 0.0), axis=1).max() < 6.0


def test_a_traction_is_shared_out_consistently(body):
    """The corners of a quadratic triangle get nothing, the middles a third each; of a linear one, the corners a third."""
    picked, force = pick(body, "resting face"), np.array([3.0, -1.0, -5.0])
    spread = body.forces(picked.inside, np.outer(body.areas, force / picked.area(body)))
    assert spread.sum(axis=0) == pytest.approx(force)
    assert np.cross(body.mesh.nodes, spread).sum(axis=0) == pytest.approx(np.cross([6.0, 5.0, 0.0], force))
    corners = spread[: len(body.mesh.tets.vertices)]
    assert np.abs(corners).max() == pytest.approx(0.0, abs=1e-12) if body.sides.shape[1] == 6 else np.abs(corners).max() > 0.1


@pytest.mark.parametrize("place", [Patch(sphere=(6, 5, 8, 2)), Patch(box=(20, 0, 0, 30, 9, 9)), Patch(plane=(0, 0, 17, 0, 0, 1))])
def test_a_place_without_surface_is_named_with_what_the_part_spans(body, place):
    with pytest.raises(BadInput, match=r"selects no surface: the part spans x 0\.0 to 12\.0, y 0\.0 to 10\.0, z 0\.0 to 16\.0 mm"):
        pick(body, place)


def test_a_part_on_its_corner_has_no_resting_face(block):
    turn = np.linalg.qr(np.array([[1.0, 1.0, 1.0], [1.0, -1.0, 0.2], [0.3, 1.0, -1.0]]))[0]
    tilted = block.moved(block.vertices @ (turn * np.linalg.det(turn)))
    with pytest.raises(BadInput, match="no flat face to stand on"):
        pick(Boundary(with_nodes(tilted, QUADRATIC)), "resting face")
