"""Models one grips: utensil grip, key turner, bottle opener, drawer knob; measures in mm."""

from __future__ import annotations

import math

import numpy as np

from mechstyle.gallery import _solids
from mechstyle.records.mesh import SurfaceMesh


def utensil_grip(
    *, length: float = 112.0, diameter: float = 34.0, waves: int = 4, relief: float = 1.0, slot_width: float = 15.0,
    slot_height: float = 4.5, slot_depth: float = 78.0,
) -> SurfaceMesh:  # fmt: skip
    """A thick handle that a spoon or fork is pushed into, for hands that cannot close; it lies on a flat.

    `diameter` is the greatest; `waves` for the fingers are `relief` deep, from their middle; `slot_depth` is how far the slot reaches in.
    """
    _solids.within(length=(length, 70, 180), diameter=(diameter, 22, 60), relief=(relief, 0, 0.08 * diameter))
    _solids.within(slot_width=(slot_width, 5, 0.55 * diameter), slot_height=(slot_height, 2, 0.3 * diameter))
    _solids.within(slot_depth=(slot_depth, 20, length - 10))
    waves = _solids.count("waves", waves, 0, 8)
    # Stations along y and radii there: round ends, a swell towards the back, waves between.
    turn = np.linspace(0.0, math.pi, 97)
    path, share = -0.5 * length * np.cos(turn), 0.5 * (1.0 - np.cos(turn))
    near = np.clip((0.5 * length - np.abs(path)) / (0.32 * (diameter / 2)), 0.0, 1.0)
    cap = 1.0 - 0.30 * (1.0 - np.sqrt(np.clip(1.0 - (1.0 - near) ** 2, 0.0, 1.0)))
    swell = (diameter / 2 - relief) * (0.90 + 0.10 * np.sin(math.pi * share**1.4))
    radius = (swell + relief * np.sin(math.pi * share) ** 0.5 * np.cos(2 * math.pi * waves * (share - 0.5))) * cap
    body = _solids.swept(np.column_stack([path, np.zeros_like(path)]), np.column_stack([2.0 * radius, 1.84 * radius]), power=2.2)
    body = body.trim_by_plane((0.0, 0.0, 1.0), -0.33 * diameter)  # deeper than the waves, so that the flat is one face
    mouth = _solids.box(slot_width, slot_height, 0.35 * slot_height)
    slot = _solids.pocket(mouth, slot_depth, floor=0.3 * slot_height, flare=1.2).rotate((90.0, 0.0, 0.0))
    return _solids.standing(body - slot.translate((0.0, -length / 2, 0.0)))


def key_turner(
    *, length: float = 104.0, width: float = 40.0, thickness: float = 16.0, slot_width: float = 22.0, slot_height: float = 3.6,
    slot_depth: float = 24.0, pin: float = 3.4,
) -> SurfaceMesh:  # fmt: skip
    """A wide handle for a key, for hands that cannot pinch; it lies flat, its slot to the right, and shows the key in a scoop.

    Without the scoop the cheek over the slot goes on falling in its middle where its sides have landed, and tears at the ends of the slot.

    `width` is that of both ends, `slot_width` and `slot_height` are for the head of the key, `pin` is the hole for the screw from below
    through its eye.
    """
    _solids.within(length=(length, 70, 160), width=(width, 26, 60), thickness=(thickness, slot_height + 4, 26))
    _solids.within(slot_width=(slot_width, 10, width - 8), slot_height=(slot_height, 2, 6), slot_depth=(slot_depth, 12, 0.4 * length))
    _solids.within(pin=(pin, 2, 6))
    end = length / 2 - width / 2
    outline = _solids.disc(width / 2).translate((-end, 0.0)) + _solids.box(width, width, 7.0).translate((end, 0.0))
    outline = _solids.softened(outline + _solids.stroke([(-end, 0.0), (end, 0.0)], 0.58 * width), 5.0, 0.7 * width)
    scoop = min(0.4 * slot_width, width / 2 - 11.0)  # leaves cheeks wider than both their rounded corners
    outline -= _solids.disc(scoop).translate((length / 2 + 2.0, 0.0))
    body = _solids.lofted(_solids.softened(outline, 5.0, 1.0), _pillow(thickness, min(0.27 * thickness, 4.6)))
    mouth = _solids.box(slot_height, slot_width, 0.45 * slot_height)
    slot = _solids.pocket(mouth, slot_depth, floor=0.35 * slot_height, flare=0.8).rotate((0.0, 90.0, 0.0))
    hole = _solids.through(_solids.disc(pin / 2), -1.0, 0.75 * thickness)  # from below: through the upper cheek it would be torn at
    body -= slot.translate((length / 2, 0.0, thickness / 2))
    return _solids.standing(body - hole.translate((length / 2 - 0.75 * slot_depth, 0.0, 0.0)))


def bottle_opener(
    *, length: float = 122.0, head: float = 54.0, grip: float = 26.0, thickness: float = 8.0, mouth: float = 31.0, tooth: float = 6.0
) -> SurfaceMesh:
    """A flat opener for crown caps with a tooth in its ring; it lies flat.

    `head` is the diameter of the ring, `grip` the width of the grip, `mouth` that of the opening, `tooth` how far the tooth reaches into
    it.
    """
    _solids.within(length=(length, 80, 180), head=(head, 44, 80), grip=(grip, 16, 0.7 * head), thickness=(thickness, 5, 14))
    _solids.within(mouth=(mouth, 26, head - 16), tooth=(tooth, 3, 0.35 * mouth))
    middle, tail = length / 2 - head / 2, -length / 2 + grip / 2
    outline = _solids.disc(head / 2).translate((middle, 0.0)) + _solids.disc(grip / 2).translate((tail, 0.0))
    outline = _solids.softened(outline + _solids.stroke([(tail, 0.0), (middle, 0.0)], 0.82 * grip), 4.0, 0.8 * grip)
    opening = _solids.polygon(_solids.superellipse(0.42 * mouth, mouth / 2, 2.6, 96)).translate((middle, 0.0))
    lip = _solids.stroke([(-mouth, 0.0), (tooth - 0.42 * mouth - 3.0, 0.0)], 0.36 * mouth).translate((middle, 0.0))
    eye = _solids.disc(3.0).translate((tail - 0.05 * grip, 0.0))
    flat = outline - _solids.softened(opening - lip, 1.6, 1.6) - eye
    return _solids.standing(_solids.lofted(flat, _pillow(thickness, 1.4)))


def drawer_knob(*, diameter: float = 34.0, height: float = 28.0, neck: float = 15.0, foot: float = 21.0, bore: float = 4.2) -> SurfaceMesh:
    """A round knob on a slender neck with a bore for its screw, standing on its foot.

    `diameter` is that of the head, and `neck`, `foot` and `bore` are diameters.
    """
    _solids.within(diameter=(diameter, 22, 60), height=(height, 18, 50), neck=(neck, 0.35 * diameter, 0.75 * diameter))
    _solids.within(foot=(foot, neck, diameter), bore=(bore, 2, neck - 6))
    share = np.linspace(0.0, 1.0, 41)
    waist = neck / 2 + (foot - neck) / 2 * (1 - share / 0.45).clip(0, 1) ** 2
    swell = (diameter - neck) / 2 * np.sin(0.5 * math.pi * ((share - 0.3) / 0.34).clip(0, 1)) ** 2
    dome = np.sqrt((1.0 - ((share - 0.72) / 0.28).clip(0, 1) ** 2).clip(0.0))
    outer = np.column_stack([(waist + swell) * dome, height * share])
    section = _solids.polygon([(0.0, 0.0), *outer[:-1], (0.0, height)])
    deep, side = 0.6 * height, bore / 2
    screw = _solids.polygon([(-side, -1.0), (side, -1.0), (side, deep), (0.0, deep + side), (-side, deep)])
    return _solids.standing(_solids.revolved(section - screw, soft=0.7))


def _pillow(thickness: float, edge: float) -> list[_solids.Level]:
    """Levels of a slab whose upper and lower edges are rounded alike."""
    upper = [(thickness - edge + z, inset) for z, inset in _solids.round_edge(edge)]
    return [*((thickness - z, inset) for z, inset in reversed(upper)), *upper]
