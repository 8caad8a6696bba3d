"""What lies across a gap is not averaged with what is on this side of it; what the body joins in the ball is."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from mechstyle.fea.ball_average import RADIUS, BallAverage
from mechstyle.records.mesh import TetMesh
from mechstyle.simulation.validation.meshes import ball, bracket, lattice


def all_within(average, mesh):
    """How many points lie within the radius of each, whatever is between, shape [point_count]."""
    places = average.points(mesh).reshape(-1, 3)
    return cKDTree(places).query_ball_point(places, average.radius, return_length=True)


def neighbours(average):
    return np.diff(average._near.indptr)


def neighbours_at(average, mesh, place):
    """Points in the ball around the point nearest to a place [mm], shape [n, 3]."""
    places = average.points(mesh).reshape(-1, 3)
    nearest = np.linalg.norm(places - place, axis=1).argmin()
    return places[average._near[[nearest]].indices]


@pytest.mark.parametrize("cell", [0.6, 1.0, 2.0])
@pytest.mark.parametrize(("wall", "slot"), [(0.8, 0.2), (1.2, 0.4), (1.2, 0.8), (2.0, 0.4)])
def test_a_wall_between_two_others_reads_what_it_bears_itself(comb, wall, slot, cell):
    """At 100 MPa, the others without stress: from 2 mm and one tetrahedron above the bottom of the slots."""
    mesh = comb(wall, slot, cell)
    across, _, up = mesh.vertices[mesh.tets].mean(axis=1).T
    middle = (across > wall) & (across < 2.0 * (wall + slot)) & (up > 4.0)
    average = BallAverage(mesh)
    found = average(mesh, 100.0 * middle[:, None] * np.ones(4))
    above = average.points(mesh)[..., 2] > 4.0 + RADIUS + cell
    assert found[middle[:, None] & above].min() == pytest.approx(100.0)
    assert found[~middle[:, None] & above].max() == 0.0
    below = all_within(average, mesh).reshape(above.shape)[above] - neighbours(average).reshape(above.shape)[above]
    assert below.max() > 0, "the walls do lie within 2 mm of each other"


@pytest.mark.parametrize("kind", ["block", "ball", "plate"])
def test_a_convex_body_loses_nothing(kind, block, box):
    body = {"block": block, "ball": ball(6.0, 10, 3.0), "plate": box((5, 8, 8), (1.0, 8.0, 20.0))}[kind]
    average = BallAverage(body)
    assert np.array_equal(neighbours(average), all_within(average, body))


@pytest.mark.parametrize("cell", [0.5, 1.0])
def test_the_legs_of_a_bracket_are_joined_in_their_corner(cell):
    """They open by 90°: what is near both is nearer to the corner."""
    body = bracket(12.0, 4.0, 2.0, cell)
    average = BallAverage(body)
    assert np.array_equal(neighbours(average), all_within(average, body))


def test_around_the_tip_of_a_slit_both_sides_are_joined_where_the_tip_is_in_the_ball():
    """A slit of 0.4 mm through a plate, up to its middle at x = 8 mm."""
    across = np.concatenate([np.linspace(0.0, 3.8, 7), np.linspace(4.2, 8.0, 7)])
    straight = lattice(np.linspace(0.0, 16.0, 25), across, np.linspace(0.0, 2.0, 4))
    x, y, _ = straight.vertices[straight.tets].mean(axis=1).T
    body = TetMesh(straight.vertices, straight.tets[(x > 8.0) | (np.abs(y - 4.0) > 0.2)])
    average = BallAverage(body)
    for place, joined in ((4.0, False), (5.5, False), (7.0, True), (8.0, True), (10.0, True)):
        around = neighbours_at(average, body, [place, 3.6, 1.0])
        assert (around[:, 1] < 3.8).any()
        assert (around[:, 1] > 4.2).any() == joined, place
