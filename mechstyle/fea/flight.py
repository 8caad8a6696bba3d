"""Rigid flight between two touches: the motion of a body as a whole, and where and when its hull meets the floor again.

Everything is seen from where the body was, undeformed, when the phase began: its centre of mass is the origin, n the floor normal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull

from mechstyle.fea.discretisation import Discretisation
from mechstyle.fea.explicit import MOTION, QUANTITIES
from mechstyle.records.mesh import Floats

TURN = 0.02
"""Most rotation in a step [rad]; the midpoint rule is then 1e-5 off in a turn."""

NEAR = 1e-4
"""Distance from the floor that counts as a touch, and least way of a step, over the distance of the farthest point from the centre."""

RESTITUTIONS = 0.1, 0.25, 0.5, 1.0
"""Shares of its speed at which a point that touches slowly may be thrown back; 0.5 and 1 alone miss 6 of 157 harder touches behind it."""

IN_A_ROW = 8
"""Touches that are looked ahead; a body that clatters is slower with each."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a body as a whole.

    Attributes:
        shift: Where its centre of mass has come to [mm], shape [3].
        velocity: Of the centre [mm/ms], shape [3].
        rotation: Of the body, shape [3, 3].
        spin: Angular momentum about the centre [g mm²/ms], shape [3].
    """

    shift: Floats
    velocity: Floats
    rotation: Floats
    spin: Floats


@dataclass(frozen=True, eq=False)
class Touch:
    """A hull that meets the floor.

    Attributes:
        after: Time of flight [ms].
        speed: Speed at which the touching point meets the floor [mm/ms].
        arm: From the centre of mass to that point [mm], shape [3].
        motion: The motion then.
    """

    after: float
    speed: float
    arm: Floats
    motion: Motion


@dataclass(frozen=True, eq=False)
class RigidBody:
    """What rigid motion needs to know of a body.

    Attributes:
        masses: Of the nodes [g], shape [node_count].
        arms: Nodes seen from the centre of mass [mm], shape [node_count, 3].
        hull: The corners of the convex hull among them, shape [corners, 3].
        spread: Σ m r ⊗ r [g mm²], shape [3, 3].
        gravity: g [mm/ms²].
    """

    masses: Floats
    arms: Floats
    hull: Floats
    spread: Floats
    gravity: float

    @classmethod
    def of(cls, body: Discretisation, gravity: float) -> RigidBody:
        """The body, undeformed."""
        arms = body.arms
        corners = arms[np.sort(ConvexHull(arms).vertices)]
        return cls(body.masses, arms, corners, (body.masses[:, None] * arms).T @ arms, gravity)

    @property
    def mass(self) -> float:
        """[g]."""
        return float(self.masses.sum())

    @cached_property
    def inertia(self) -> Floats:
        """Moments of inertia about the centre [g mm²], shape [3, 3]."""
        return np.asarray(np.trace(self.spread) * np.eye(3) - self.spread)

    @cached_property
    def _softness(self) -> Floats:
        """Inverse of the inertia."""
        return np.asarray(np.linalg.inv(self.inertia))

    @cached_property
    def reach(self) -> float:
        """Distance of the farthest point from the centre [mm]."""
        return float(np.linalg.norm(self.hull, axis=1).max())

    def motion(self, sample: Floats) -> Motion:
        """The motion nearest to that of the nodes, from a sample of `explicit.QUANTITIES`: same momenta, rotation by least squares."""
        sums = sample[QUANTITIES.index(MOTION[0]) :]
        shift, velocity = sums[:3] / self.mass, sums[3:6] / self.mass
        left, _, right = np.linalg.svd(self.spread + sums[9:].reshape(3, 3))
        rotation = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
        return Motion(shift, velocity, rotation, sums[6:9] - self.mass * np.cross(shift, velocity))

    def kinetic_energy(self, motion: Motion) -> float:
        """Of the motion as a whole [mJ]."""
        turning = self.turning(motion.rotation, motion.spin)
        return 0.5 * float(self.mass * motion.velocity @ motion.velocity + turning @ motion.spin)

    def turning(self, rotation: Floats, spin: Floats) -> Floats:
        """Angular velocity [rad/ms], shape [3]."""
        return np.asarray(rotation @ (self._softness @ (rotation.T @ spin)))

    def velocities(self, motion: Motion) -> Floats:
        """Velocity of every node in the frame of the body [mm/ms], shape [node_count, 3]."""
        turning = motion.rotation.T @ self.turning(motion.rotation, motion.spin)
        return np.asarray(motion.rotation.T @ motion.velocity + np.cross(turning, self.arms))

    def next_touch(self, motion: Motion, normal: Floats) -> Touch | None:
        """Where a body in free flight meets the floor on which it stood, None if it leaves it for good.

        It has left when its centre is higher than its farthest point reaches: the weight will bring it back, but that is another fall.
        No step is longer than the lowest point needs to the floor at the most speed there is, so none is missed.
        """
        reach, most_turning = self.reach, self._most_turning(motion)
        floor, turning = float((self.arms @ normal).min()), self.turning(motion.rotation, motion.spin)
        shift, velocity, rotation, time = motion.shift, motion.velocity, motion.rotation, 0.0
        while True:
            low, rate = rotation.T @ normal, _cross(normal, turning) @ rotation
            heights = shift @ normal + self.hull @ low - floor
            falling = velocity @ normal + self.hull @ rate
            meeting = np.flatnonzero((heights <= NEAR * reach) & (falling < 0.0))
            if len(meeting):
                point = meeting[falling[meeting].argmin()]
                there = Motion(shift, velocity, rotation, motion.spin)
                return Touch(float(time), -float(falling[point]), rotation @ self.hull[point], there)
            if shift @ normal - floor > reach and velocity @ normal >= 0.0:
                return None
            speed = abs(float(velocity @ normal)) + most_turning * reach + np.sqrt(2.0 * self.gravity * reach)
            step = min(max(float(heights.min()), NEAR * reach) / speed, TURN / max(float(np.linalg.norm(turning)), 1e-12))
            middle = _turned(rotation, turning * (0.5 * step))
            rotation = _turned(rotation, self.turning(middle, motion.spin) * step)
            shift = shift + step * velocity - 0.5 * step**2 * self.gravity * normal
            velocity, time = velocity - step * self.gravity * normal, time + step
            turning = self.turning(rotation, motion.spin)

    def rebound(self, touch: Touch, normal: Floats, restitution: float) -> Motion:
        """The motion after a frictionless touch, by Newton's law of restitution for a rigid body.

        Args:
            touch: Where and how fast it touches.
            normal: Of the floor, shape [3].
            restitution: Share of its speed with which the touching point is thrown back.
        """
        motion, lever = touch.motion, np.cross(touch.arm, normal)
        inverse_mass = 1.0 / self.mass + lever @ self.turning(motion.rotation, lever)  # of the touching point, along the normal
        impulse = (1.0 + restitution) * touch.speed / inverse_mass
        return replace(motion, velocity=motion.velocity + impulse / self.mass * normal, spin=motion.spin + impulse * lever)

    def harder_behind(self, touch: Touch, normal: Floats, enough: float) -> bool:
        """Whether one of the next touches after a slow one may be as fast as `enough` [mm/ms], by rigid rebounds at RESTITUTIONS.

        Args:
            touch: The slow touch. What it leaves of the motion is not known before it is simulated.
            normal: Of the floor, shape [3].
            enough: Speed of a touching point that is looked for [mm/ms].
        """
        for restitution in RESTITUTIONS:
            motion = self.rebound(touch, normal, restitution)
            for _ in range(IN_A_ROW):
                falling = np.sqrt(4.0 * self.gravity * self.reach)  # by twice its reach at most before it touches or has left for good
                fastest = np.linalg.norm(motion.velocity) + self._most_turning(motion) * self.reach + falling
                behind = self.next_touch(motion, normal) if fastest >= enough else None
                if behind is None:
                    break
                if behind.speed >= enough:
                    return True
                motion = self.rebound(behind, normal, restitution)
        return False

    def _most_turning(self, motion: Motion) -> float:
        """Angular velocity [rad/ms] that a free flight never exceeds: 2 T ≥ I_min ω²."""
        turning = self.turning(motion.rotation, motion.spin)
        return float(np.sqrt(max(turning @ motion.spin, 0.0) / np.linalg.eigvalsh(self.inertia)[0]))


def _turned(rotation: Floats, by: Floats) -> Floats:
    """A rotation followed by a small one about an axis [rad], shape [3, 3]: Rodrigues' formula."""
    x, y, z = by
    angle = math.sqrt(x * x + y * y + z * z)
    if angle == 0.0:
        return rotation
    axis = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) / angle
    about = axis @ rotation
    return np.asarray(rotation + math.sin(angle) * about + (1.0 - math.cos(angle)) * (axis @ about))


def _cross(a: Floats, b: Floats) -> Floats:
    """The cross product of two vectors: numpy's own takes ten times as long, and a flight is followed in thousands of steps."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
