"""Patterns on the cells of rows that several styles share: folded stripes, scales laid over each other, fans of half rounds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.canvas import Bond, Canvas


def folded(phase: Floats) -> Floats:
    """Distance of a phase to the nearest whole number, in [0, ½]."""
    return np.asarray(np.abs(phase - np.round(phase)))


def dome(reach: Floats) -> Floats:
    """Height of half a ball of radius and height 1 at a distance from its middle."""
    return np.asarray(np.sqrt(np.clip(1.0 - reach**2, 0.0, 1.0)))


class Place(NamedTuple):
    """A place on a scale.

    Attributes:
        aside: 0 on its middle line, 1 at its flanks, shape [n].
        down: 0 on the line it hangs from, 1 at its tip, shape [n].
    """

    aside: Floats
    down: Floats


def hanging(bond: Bond) -> Place:
    """The place on the scale that hangs from this row of a running bond."""
    return Place(2.0 * np.abs(bond.x), 0.5 - bond.y)


def beneath(place: Place) -> Place:
    """The same place on the scale below, half a scale aside and a row down, which shows where the upper one ends."""
    return Place(1.0 - place.aside, place.down - 1.0)


def own_of_scales(canvas: Canvas, bond: Bond, inside: Floats, salt: str) -> Floats:
    """A random number in [-½, ½) for each scale, 0 in their corners; `inside` is positive on the upper scale, shape [n]."""
    aside, down = hanging(bond)
    # Scales of one row touch in their corners, where the one above has its tip.
    apart = np.minimum(np.hypot(1.0 - aside, down), np.hypot(aside, 1.0 - down)) > 0.25
    return (canvas.random(canvas.pieces(apart, bond.odd ^ (inside > 0.0)), salt) - 0.5) * apart


def fans(bond: Bond) -> tuple[Floats, Floats]:
    """Overlapping half rounds on a running bond of cells four times as wide as high, every row in front of the one above (seigaiha).

    Returns:
        Distance from the centre of the half round in front over its radius, in [0, 1], and angle from the upright [rad], at least 0.
    """
    # Centres lie on this row and the two below it, every second one half a round aside; the lowest round that reaches is in front.
    aside, up = np.abs(bond.x) * 2.0, bond.y * 0.5
    sideways = np.stack([1.0 - aside if step % 2 else aside for step in range(3)])
    upwards = np.stack([up + 0.5 * step for step in range(3)])
    reach = np.hypot(sideways, upwards)
    front = (2 - (reach[::-1] < 1.0).argmax(axis=0))[None]
    here, x, y = (np.take_along_axis(field, front, axis=0)[0] for field in (reach, sideways, upwards))
    return np.minimum(here, 1.0), np.asarray(np.arctan2(x, y))
