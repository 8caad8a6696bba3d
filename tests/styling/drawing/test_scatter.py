import numpy as np
from scipy.spatial.distance import pdist

from mechstyle.styling.drawing.operators import Operators
from mechstyle.styling.drawing.scatter import poisson_disc, stamps, worley


def test_poisson_points_of_one_side_keep_their_distance_and_leave_no_hole(sphere):
    points = poisson_disc(sphere, 3.0, seed=1)
    chosen = sphere.vertices[points]
    # Normals differ by distance / radius, which lengthens distances by sqrt(1 + (0.6·3/10)²) = 1.6 %.
    assert pdist(chosen).min() > 3.0 / 1.02
    gaps = np.linalg.norm(sphere.vertices[:, None] - chosen[None], axis=2).min(axis=1)
    assert gaps.max() < 3.0


def test_the_two_sides_of_a_wall_do_not_share_cells(holder):
    radius = np.hypot(holder.vertices[:, 0], holder.vertices[:, 1])
    middle = np.abs(holder.vertices[:, 2] - 50.0) < 30.0
    outer, inner = middle & (np.abs(radius - 40.0) < 0.1), middle & (np.abs(radius - 37.0) < 0.1)
    points = poisson_disc(holder, 15.0, seed=0)
    cells = worley(holder.vertices, holder.vertex_normals, points, holder.vertices, 15.0)
    assert not set(cells.identity[outer]) & set(cells.identity[inner])


def test_cells_belong_to_the_nearest_point_and_end_where_two_are_equally_near(sphere):
    points = poisson_disc(sphere, 4.0, seed=0)
    cells = worley(sphere.vertices, sphere.vertex_normals, points, sphere.vertices, 4.0)
    assert np.array_equal(cells.identity[points], np.arange(len(points)))
    assert cells.edge.min() >= 0.0
    borders = cells.identity[sphere.edges[:, 0]] != cells.identity[sphere.edges[:, 1]]
    length = np.linalg.norm(np.diff(sphere.vertices[sphere.edges], axis=1)[:, 0], axis=1)
    # Along an edge that crosses a border, the two distances to it add up to no more than about the edge.
    assert np.all(cells.edge[sphere.edges].min(axis=1)[borders] < 0.75 * length[borders])


def test_a_stamp_has_its_own_upright_axes(stand):
    front = (np.abs(stand.vertices[:, 1] - 40.0) < 1e-6) & (stand.vertices[:, 2] > 12.0)
    centre = int(np.flatnonzero(front & (np.linalg.norm(stand.vertices - [32.0, 40.0, 48.0], axis=1) < 0.1))[0])
    axis = np.tile([1.0, 0.0, 0.0], (len(stand.vertices), 1))
    around = stamps(Operators(stand), np.array([centre]), axis, 3, 20.0)
    assert around.x.shape == (len(stand.vertices), 1)  # three were asked for, one there is
    inside = np.flatnonzero(front & (stand.vertices[:, 0] > 4.0) & (stand.vertices[:, 0] < 56.0))
    offset = stand.vertices[inside] - stand.vertices[centre]
    assert np.allclose(around.x[inside, 0], offset[:, 0])
    assert np.allclose(around.y[inside, 0], offset[:, 2])
    assert np.allclose(around.facing[inside, 0], stand.vertex_normals[inside] @ stand.vertex_normals[centre])
    assert np.allclose(around.facing[centre, 0], 1.0)


def test_a_stamp_ends_at_sharp_edges(stand):
    operators = Operators(stand)
    normal = stand.vertex_normals
    front = (normal[:, 1] < -0.999) & (stand.vertices[:, 2] > 12.0)
    back = normal[:, 1] > 0.999
    centre = int(np.flatnonzero(front)[0])
    axis = np.tile([1.0, 0.0, 0.0], (len(stand.vertices), 1))
    facing = stamps(operators, np.array([centre]), axis, 1, 20.0).facing[:, 0]
    edge = operators.sharp & (np.abs(normal @ normal[centre]) > 0.5)  # turned by 45°: the stamp may end on it
    assert np.allclose(facing[front], 1.0)
    assert np.all(facing[back] == -1.0)
    assert np.all(facing[np.abs(normal[:, 0]) > 0.999] == -1.0)  # faces beside it, which a wide stamp would run on over
    assert np.allclose(facing[edge], (normal @ normal[centre])[edge])


def test_the_nearest_border_counts_whoever_is_behind_it():
    """The second nearest point is close to the nearest one, on its far side, and so is their border."""
    places = np.array([[0.0, 0.0, 0.0], [-0.25, 0.43, 0.0], [2.4, 0.0, 0.0], [1.0, 0.0, 0.0]])
    cells = worley(places, np.tile([0.0, 0.0, 1.0], (4, 1)), np.array([0, 1, 2]), places, 4.0)
    far = np.linalg.norm(places[:3] - places[3], axis=1)
    assert far.argsort().tolist() == [0, 1, 2]
    assert cells.identity[3] == 0
    assert cells.beside[3] == 2
    assert np.isclose(cells.edge[3], 0.2)  # half way to it is 1.2 from the nearest
