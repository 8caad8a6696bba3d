"""Rigid flight against closed forms: a fall, a spin about an axis, a free symmetric top, and what never comes back."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mechstyle.fea.discretisation import discretise
from mechstyle.fea.elements import LINEAR
from mechstyle.fea.explicit import MOTION, QUANTITIES
from mechstyle.fea.flight import Motion, RigidBody

UP = np.array([0.0, 0.0, 1.0])
G = 9.81e-3


@pytest.fixture(scope="module")
def rigid():
    """A box of 8 x 8 x 20 mm, its mass in its corners."""
    arms = np.array(list(itertools.product((-4.0, 4.0), (-4.0, 4.0), (-10.0, 10.0))))
    masses = np.full(8, 0.2)
    return RigidBody(masses, arms, arms, (masses[:, None] * arms).T @ arms, G)


def moving(rigid, shift=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), rotation=None, turning=(0.0, 0.0, 0.0)):
    R = np.eye(3) if rotation is None else rotation
    return Motion(np.array(shift), np.array(velocity), R, R @ rigid.inertia @ R.T @ np.array(turning))


def sampled(rigid, rotation, shift, velocities):
    """A sample of a body that has moved rigidly, from its nodes."""
    masses, x = rigid.masses[:, None], rigid.arms @ rotation.T + shift
    u = x - rigid.arms
    sums = [(masses * u).sum(axis=0), (masses * velocities).sum(axis=0), (masses * np.cross(x, velocities)).sum(axis=0)]
    sample = np.zeros(len(QUANTITIES))
    sample[QUANTITIES.index(MOTION[0]) :] = np.concatenate([*sums, ((masses * u).T @ rigid.arms).ravel()])
    return sample


def test_motion_is_read_from_sums_over_the_nodes(rigid):
    R = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix()
    shift, velocity, turning = np.array([3.0, -1.0, 7.0]), np.array([0.5, 2.0, -4.0]), np.array([0.1, -0.3, 0.2])
    found = rigid.motion(sampled(rigid, R, shift, velocity + np.cross(turning, rigid.arms @ R.T)))
    np.testing.assert_allclose(found.shift, shift, atol=1e-12)
    np.testing.assert_allclose(found.velocity, velocity, atol=1e-12)
    np.testing.assert_allclose(found.rotation, R, atol=1e-12)
    np.testing.assert_allclose(rigid.turning(found.rotation, found.spin), turning, atol=1e-12)
    at_nodes = rigid.velocities(found) @ R.T
    np.testing.assert_allclose(at_nodes, velocity + np.cross(turning, rigid.arms @ R.T), atol=1e-12)


def test_a_body_that_falls_touches_when_and_as_fast_as_it_must(rigid):
    touch = rigid.next_touch(moving(rigid, shift=(0.0, 0.0, 0.5), velocity=(1.0, 0.0, 0.1)), UP)
    time = (0.1 + np.sqrt(0.1**2 + 2.0 * G * 0.5)) / G
    assert touch.after == pytest.approx(time, rel=1e-3)
    assert touch.speed == pytest.approx(np.sqrt(0.1**2 + 2.0 * G * 0.5), rel=1e-3)
    np.testing.assert_allclose(touch.motion.shift[:2], [time, 0.0], rtol=1e-3, atol=1e-9)


def test_a_body_that_leaves_comes_back_no_more(rigid):
    assert rigid.next_touch(moving(rigid, velocity=(0.0, 0.0, 2.0)), UP) is None


def test_a_body_that_turns_as_it_rises_touches_with_its_end(rigid):
    """About y, centre rising at V: the lowest corner is c − (10 cos φ + 4 sin φ), c = 10 + V t, until V is too slow to clear it."""
    rise, rate = 0.25, 0.1
    touch = rigid.next_touch(moving(rigid, velocity=(0.0, 0.0, rise), turning=(0.0, rate, 0.0)), UP)
    times = np.linspace(1e-3, 60.0, 600_000)
    heights = 10.0 + rise * times - 0.5 * G * times**2 - 10.0 * np.abs(np.cos(rate * times)) - 4.0 * np.abs(np.sin(rate * times))
    first = int(np.argmax((heights < 0.0) & (np.gradient(heights, times) < 0.0)))
    assert touch.after == pytest.approx(times[first], abs=0.01)
    assert touch.speed == pytest.approx(-np.gradient(heights, times)[first], rel=0.01)


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_a_point_that_touches_is_thrown_back_at_its_share_of_the_speed(rigid, restitution):
    """A smooth floor: what moves along it goes on, and at restitution 1 no energy is lost."""
    tilted = Rotation.from_rotvec([0.3, 0.5, 0.0]).as_matrix()
    touch = rigid.next_touch(moving(rigid, (0.0, 0.0, 3.0), (1.0, 0.5, -2.0), tilted, turning=(0.1, -0.2, 0.05)), UP)
    before, after = touch.motion, rigid.rebound(touch, UP, restitution)
    point = (rigid.arms @ before.rotation.T @ UP).argmin()
    assert np.allclose(touch.arm, before.rotation @ rigid.arms[point])
    speeds = [(rigid.velocities(motion)[point] @ before.rotation.T)[2] for motion in (before, after)]
    assert speeds == pytest.approx([-touch.speed, restitution * touch.speed])
    assert np.allclose(after.velocity[:2], before.velocity[:2])
    energies = [0.5 * float((rigid.masses[:, None] * rigid.velocities(motion) ** 2).sum()) for motion in (before, after)]
    assert energies[1] == pytest.approx(energies[0]) if restitution == 1.0 else energies[1] < energies[0]


def test_behind_a_slow_touch_the_harder_one_is_seen(rigid):
    """One end grazes the floor as the body turns over it, and the other comes down."""
    flat = Rotation.from_rotvec([0.0, 0.5 * np.pi + 0.2, 0.0]).as_matrix()  # its long axis nearly level
    lowest = float((rigid.arms @ flat.T)[:, 2].min()) - float(rigid.arms[:, 2].min())
    motion = moving(rigid, (0.0, 0.0, -lowest), (0.0, 0.0, -2.0), flat, turning=(0.0, -0.17, 0.0))
    first = rigid.next_touch(motion, UP)
    assert first.speed < 1.0
    assert rigid.harder_behind(first, UP, 2.0)
    still = moving(rigid, (0.0, 0.0, -lowest), (0.0, 0.0, -0.2), flat)
    assert not rigid.harder_behind(rigid.next_touch(still, UP), UP, 2.0)


def test_a_symmetric_top_precesses_as_in_the_textbook(rigid):
    """Its axis goes around the angular momentum at the rate L/I⊥ (Landau and Lifshitz, Mechanics, § 33)."""
    tilt = Rotation.from_rotvec([0.5, 0.0, 0.0]).as_matrix()
    motion = moving(rigid, shift=(0.0, 0.0, 40.0), velocity=(0.0, 0.0, -1.0), rotation=tilt, turning=tilt @ np.array([0.0, 0.3, 0.8]))
    touch = rigid.next_touch(motion, UP)
    across = rigid.inertia[0, 0]
    assert rigid.inertia[1, 1] == pytest.approx(across)
    about = Rotation.from_rotvec(motion.spin / across * touch.after).as_matrix()
    np.testing.assert_allclose(touch.motion.rotation[:, 2], about @ tilt[:, 2], atol=5e-3)
    energy = [spin @ rigid.turning(R, spin) for R, spin in ((m.rotation, m.spin) for m in (motion, touch.motion))]
    assert energy[1] == pytest.approx(energy[0], rel=1e-3)


def test_turning_everything_turns_the_answer(rigid):
    Q = Rotation.from_rotvec([0.3, 0.9, -0.4]).as_matrix()
    tilt = Rotation.from_rotvec([0.5, 0.2, 0.0]).as_matrix()
    straight = moving(rigid, velocity=(0.1, 0.0, -0.2), rotation=tilt, turning=(0.05, 0.02, -0.1), shift=(0.0, 0.0, 3.0))
    turned = Motion(Q @ straight.shift, Q @ straight.velocity, Q @ tilt @ Q.T, Q @ straight.spin)
    body = RigidBody(rigid.masses, rigid.arms @ Q.T, rigid.hull @ Q.T, Q @ rigid.spread @ Q.T, G)
    one, other = rigid.next_touch(straight, UP), body.next_touch(turned, Q @ UP)
    assert other.after == pytest.approx(one.after, rel=1e-6)
    assert other.speed == pytest.approx(one.speed, rel=1e-6)
    np.testing.assert_allclose(Q.T @ other.motion.rotation @ Q, one.motion.rotation, atol=1e-6)


def test_a_body_is_known_by_its_nodes_and_its_hull(box, pla):
    body = discretise(box((2, 2, 4), (8.0, 8.0, 20.0)), pla, 0.0, LINEAR)
    found = RigidBody.of(body, G)
    assert found.mass == pytest.approx(pla.density * 8.0 * 8.0 * 20.0)
    np.testing.assert_allclose(found.masses @ found.arms, 0.0, atol=1e-9)
    np.testing.assert_allclose(np.ptp(found.hull, axis=0), [8.0, 8.0, 20.0])
    assert len(found.hull) == 8
