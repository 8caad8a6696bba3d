"""Thin-walled shapes around the z axis, given by an outer radius over height and angle; lengths in mm, angles in radians."""

from __future__ import annotations

import math

import numpy as np

from mechstyle.records.mesh import Floats


def inner_radius(outer: Floats, height: Floats, turn: Floats, wall: float) -> Floats:
    """Radius inside a wall of constant thickness along its normal, to first order [mm].

    Args:
        outer: Outer radius [mm], shape [levels, points].
        height: Rising heights of the levels [mm], shape [levels].
        turn: Evenly spaced angles of the points, shape [points].
        wall: Thickness [mm].
    """
    steep = np.gradient(outer, height, axis=0)
    around = (np.roll(outer, -1, axis=1) - np.roll(outer, 1, axis=1)) / (2.0 * turn[1] * outer)
    return np.asarray(outer - wall * np.sqrt(1.0 + steep**2 + around**2))


def rim(outer: Floats, inner: Floats, height: float, rise: float, steps: int = 10) -> tuple[Floats, Floats]:
    """Radii [steps - 1, points] and heights [steps - 1] of a round rim from the outer to the inner edge of a wall, both left out."""
    over = np.linspace(0.0, math.pi, steps + 1)[1:-1]
    return (outer + inner) / 2 + (outer - inner) / 2 * np.cos(over)[:, None], height + rise * np.sin(over)


def bowl(inner: Floats, height: Floats, base: float, fillet: float, steps: int = 8) -> tuple[Floats, Floats]:
    """The inside of a vessel in rings, from its upper edge down over a fillet to the floor at `base`.

    Args:
        inner: Inner radius [mm], shape [levels, points].
        height: Rising heights of the levels [mm], shape [levels].
        base: Height of the floor [mm].
        fillet: How far the wall runs out onto the floor [mm].
        steps: Rings of the fillet.

    Returns:
        Radii [mm], shape [k, points], and falling heights [mm], shape [k].
    """
    into = np.linspace(0.0, math.pi / 2, steps + 1)
    above = height > base + fillet
    level = np.concatenate([height[above][::-1], base + fillet * (1.0 - np.sin(into))])
    radius = np.stack([np.interp(level, height, column) for column in inner.T], axis=1)
    radius[-len(into) :] -= fillet * (1.0 - np.cos(into))[:, None]
    return radius, level


def rings(radius: Floats, level: Floats, turn: Floats) -> Floats:
    """Points at radii [levels, points], heights [levels] and angles [points], shape [levels, points, 3]."""
    z = np.broadcast_to(level[:, None], radius.shape)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=-1)


def angles(waves: int) -> Floats:
    """Evenly spaced angles, at least 16 for each of the waves around a shell."""
    return np.linspace(0.0, 2.0 * math.pi, max(16 * waves, 192), endpoint=False)
