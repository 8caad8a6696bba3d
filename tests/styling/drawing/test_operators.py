import numpy as np

from mechstyle.styling.drawing.operators import Operators


def test_cotangent_weights_of_a_right_angled_grid(stand):
    # Across the diagonal of a square both angles are right: cotangents of 0, kept positive at 0.05. Along its sides they are ½ + ½.
    operators = Operators(stand)
    length = np.linalg.norm(operators.edge_vectors, axis=1)
    assert np.allclose(operators.weights[length > 4.1], 0.05)
    assert np.allclose(operators.weights[length < 4.1], 1.0)


def test_the_laplacian_of_a_constant_vanishes_and_of_x_gives_minus_the_mean_curvature_normal(sphere):
    operators = Operators(sphere)
    assert np.abs(operators.laplacian @ np.ones(len(sphere.vertices))).max() < 1e-12
    # On a sphere of radius 10 mm the mean curvature is 1/10: Δx = 2 H n (area-weighted).
    curvature = operators.laplacian @ sphere.vertices / sphere.vertex_areas[:, None]
    assert np.abs(np.einsum("ij,ij->i", curvature, sphere.vertex_normals).mean() - 0.2) < 0.004


def test_transport_over_an_edge_and_back_is_no_turn(sphere):
    operators = Operators(sphere)
    x, y = operators.frames
    here = np.cos(0.3) * x[operators.tail] + np.sin(0.3) * y[operators.tail]
    there = operators.carried(here)
    angle = 0.3 + operators.transport
    expected = np.cos(angle)[:, None] * x[operators.head] + np.sin(angle)[:, None] * y[operators.head]
    assert np.abs(there - expected).max() < 1e-9
    assert np.abs(np.linalg.norm(there, axis=1) - 1.0).max() < 1e-9


def test_the_slope_of_the_height_is_one_on_a_wall_and_scales_with_it(stand):
    operators = Operators(stand)
    z = stand.vertices[:, 2]
    slope = operators.slope(z)
    wall = (np.abs(stand.vertex_normals[:, 1]) > 0.999) & (z > 20.0) & (z < 70.0)
    # Its edges run along both axes and one diagonal: half of their squared length is up the wall.
    assert np.allclose(slope[wall], 1.0)
    assert np.allclose(operators.slope(0.5 * z), 0.5 * slope)


def test_the_room_of_a_place_is_its_way_to_the_nearest_sharp_edge(stand):
    operators = Operators(stand)
    x, y, z = stand.vertices.T
    back = (np.abs(y - 48.0) < 1e-6) & (z > 0.0)
    inside = np.min([x, 60.0 - x, z, 80.0 - z], axis=0)
    assert np.array_equal(operators.sharp[back], inside[back] == 0.0)
    assert np.allclose(operators.room[back], inside[back])  # along the edges of a grid


def test_sides_end_at_sharp_edges_and_a_ball_has_one(stand, sphere):
    sides = Operators(stand).sides
    back, bottom = np.abs(stand.vertices[:, 1] - 48.0) < 1e-6, stand.vertices[:, 2] < 1e-6
    assert sides[back & bottom].tolist() == [-1] * int((back & bottom).sum())
    assert len(np.unique(sides[sides >= 0])) == 8  # an L-shaped prism
    ball = Operators(sphere)
    assert not ball.sides.any()
    assert np.isinf(ball.room).all()
