"""Models one grips: utensil grip."""

from __future__ import annotations

import math

import numpy as np

from mechstyle.gallery import _solids
from mechstyle.records.mesh import SurfaceMesh


def utensil_grip(
    *,
    length: float = 112.0,
    diameter: float = 34.0,
    waves: int = 4,
    relief: float = 1.0,
    slot_width: float = 15.0,
    slot_height: float = 4.5,
    slot_depth: float = 78.0,
) -> SurfaceMesh:
    """A thick handle that a spoon or fork is pushed into, for hands that cannot close; it lies on a flat.

    Args:
        length: Length [mm].
        diameter: Greatest diameter [mm].
        waves: Waves for the fingers along it.
        relief: Depth of a wave, from its middle [mm].
        slot_width: Width of the slot for the utensil [mm].
        slot_height: Height of that slot [mm].
        slot_depth: How far the slot reaches in [mm].
    """
    _solids.within(length=(length, 70, 180), diameter=(diameter, 22, 60), relief=(relief, 0, 0.08 * diameter))
    _solids.within(slot_width=(slot_width, 5, 0.55 * diameter), slot_height=(slot_height, 2, 0.3 * diameter))
    _solids.within(slot_depth=(slot_depth, 20, length - 10))
    waves = _solids.count("waves", waves, 0, 8)
    path, radius = _profile(length, diameter / 2, waves, relief)
    body = _solids.swept(np.column_stack([path, np.zeros_like(path)]), np.column_stack([2.0 * radius, 1.84 * radius]), power=2.2)
    body = body.trim_by_plane((0.0, 0.0, 1.0), -0.33 * diameter)  # deeper than the waves, so that the flat is one face
    mouth = _solids.box(slot_width, slot_height, 0.35 * slot_height)
    slot = _solids.pocket(mouth, slot_depth, floor=0.3 * slot_height, flare=1.2).rotate((90.0, 0.0, 0.0))
    return _solids.standing(body - slot.translate((0.0, -length / 2, 0.0)))


def _profile(length: float, radius: float, waves: int, relief: float) -> tuple[np.ndarray, np.ndarray]:
    """Stations along y and radii there: round ends, a swell towards the back, waves between [mm]."""
    turn = np.linspace(0.0, math.pi, 97)
    along = -0.5 * length * np.cos(turn)
    share = 0.5 * (1.0 - np.cos(turn))
    end = 0.32 * radius
    near = np.clip((0.5 * length - np.abs(along)) / end, 0.0, 1.0)
    cap = 1.0 - 0.30 * (1.0 - np.sqrt(np.clip(1.0 - (1.0 - near) ** 2, 0.0, 1.0)))
    swell = (radius - relief) * (0.90 + 0.10 * np.sin(math.pi * share**1.4))
    wave = relief * np.sin(math.pi * share) ** 0.5 * np.cos(2 * math.pi * waves * (share - 0.5))
    return along, (swell + wave) * cap
