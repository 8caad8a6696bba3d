"""One step of one node: free flight, the floor, friction, and what the floor takes."""

import numpy as np
import pytest

from mechstyle._warp import wp
from mechstyle.fea.backends.kernels import advance, common_gradient, quadratic_gradient, values_ahead
from mechstyle.fea.elements import QUADRATIC

DT, GRAVITY, FRICTION, MASS = 1e-3, 9.81e-3, 0.3, 2.0
UP = np.array([0.0, 0.0, 1.0])


def stepped(velocity, height, *, force=(0.0, 0.0, 0.0), friction=FRICTION):
    """Displacement, velocity, impulse and loss after one step of a node at a height above the floor."""
    u, v = (wp.array(np.array([[vector]], np.float32), dtype=wp.vec3f, device="cpu") for vector in ((0.0, 0.0, 0.0), velocity))
    impulse, lost = wp.zeros((1, 1), dtype=float, device="cpu"), wp.zeros((1, 1), dtype=float, device="cpu")
    forces = wp.array(np.array([[force], [force]], np.float32) / 2.0, dtype=wp.vec3f, device="cpu")  # of two tetrahedra
    of_node = [wp.array([0, 2], dtype=int, device="cpu"), wp.array([MASS], dtype=float, device="cpu")]
    place = [wp.array([[height]], dtype=float, device="cpu"), wp.array([UP], dtype=wp.vec3f, device="cpu")]
    wp.launch(advance, (1, 1), [forces, *of_node, *place, DT, GRAVITY, friction, u, v, impulse, lost], device="cpu")
    return u.numpy()[0, 0], v.numpy()[0, 0], float(impulse.numpy()[0, 0]), float(lost.numpy()[0, 0])


def test_in_the_air_weight_and_the_forces_of_its_tetrahedra_alone_act():
    u, v, impulse, lost = stepped((1.0, 0.0, -2.0), 10.0, force=(4.0, 0.0, 0.0))
    np.testing.assert_allclose(v, [1.0 + DT * 2.0, 0.0, -2.0 - DT * GRAVITY], rtol=1e-6)
    np.testing.assert_allclose(u, DT * v, rtol=1e-6)
    assert (impulse, lost) == (0.0, 0.0)


@pytest.mark.parametrize("height", [0.0, 1e-3])
def test_it_ends_the_step_on_the_floor_and_never_below(height):
    u, v, impulse, _ = stepped((0.0, 0.0, -5.4), height)
    assert u[2] == pytest.approx(-height, abs=1e-9)
    assert impulse == pytest.approx(MASS * (v[2] + 5.4 + DT * GRAVITY), rel=1e-6)


def test_one_that_rises_from_the_floor_is_not_held():
    _, v, impulse, _ = stepped((0.0, 0.0, 1.0), 0.0)
    assert (v[2] > 0.99, impulse) == (True, 0.0)


@pytest.mark.parametrize(("sideways", "sticks"), [(0.5, True), (5.0, False)])
def test_friction_takes_mu_times_the_push_at_most(sideways, sticks):
    _, v, impulse, _ = stepped((sideways, 0.0, -5.4), 0.0)
    wanted = 0.0 if sticks else sideways - FRICTION * impulse / MASS
    assert v[0] == pytest.approx(wanted, abs=1e-5)
    assert stepped((sideways, 0.0, -5.4), 0.0, friction=0.0)[1][0] == pytest.approx(sideways)


def test_what_the_floor_takes_is_the_kinetic_energy_that_is_gone():
    before = np.array([5.0, 0.0, -5.4])
    _, v, _, lost = stepped(before, 0.0)
    weight = -MASS * GRAVITY * DT * (before[2] + v[2]) / 2.0  # its work, by the same mean of velocities
    assert lost == pytest.approx(0.5 * MASS * (before @ before - v @ v) + weight, rel=1e-5)


@wp.kernel
def gradient_at(
    u: wp.array2d(dtype=wp.vec3f), v: wp.array2d(dtype=wp.vec3f), nodes: wp.array2d(dtype=int), G: wp.mat33f, q: int,
    found: wp.array(dtype=wp.mat33f),
):  # fmt: skip
    """The gradient of u + v / 2 at a point of one element."""
    x = values_ahead(u, v, 0.5, nodes, 0, 0)
    found[0] = quadratic_gradient(common_gradient(x, G), x, G, q)


@pytest.mark.parametrize("point", range(4))
def test_the_gradient_in_a_quadratic_element_is_that_of_its_shape_functions(point):
    random = np.random.default_rng(5)
    corners, u, v = random.normal(size=(4, 3)), *random.normal(size=(2, 10, 3))
    last_three = np.linalg.inv((corners[1:] - corners[0]).T)  # ∇L_1 to ∇L_3
    barycentric = np.vstack([-last_three.sum(axis=0), last_three])
    expected = (u + 0.5 * v).T @ QUADRATIC.derivatives[point] @ barycentric
    found = wp.zeros(1, dtype=wp.mat33f, device="cpu")
    fields = [wp.array(field[:, None].astype(np.float32), dtype=wp.vec3f, device="cpu") for field in (u, v)]
    nodes = wp.array(np.arange(10, dtype=np.int32)[None], dtype=int, device="cpu")
    wp.launch(gradient_at, 1, [*fields, nodes, wp.mat33f(*last_three.ravel()), point, found], device="cpu")
    np.testing.assert_allclose(found.numpy()[0], expected, rtol=1e-4, atol=1e-4)
