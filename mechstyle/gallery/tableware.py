"""Models for a table, a wash-basin or a drawer: coaster, napkin ring, tealight holder, soap dish, drawer organiser; measures in mm."""

from __future__ import annotations

import numpy as np

from mechstyle.gallery import _solids
from mechstyle.gallery._solids import FOOT
from mechstyle.records.mesh import SurfaceMesh


def coaster(*, diameter: float = 96.0, height: float = 6.0, base: float = 3.6, rim: float = 4.0) -> SurfaceMesh:
    """A round coaster with a raised rim.

    `height` and `rim` are height and width of the rim, `base` the thickness under the glass.
    """
    _solids.within(diameter=(diameter, 60, 160), height=(height, 3, 16), base=(base, 1.6, height - 0.8), rim=(rim, 2, 12))
    radius = diameter / 2
    flat = [(0.0, 0.0), (radius, 0.0), (radius, height), (radius - rim, height), (radius - rim - 0.4, base), (0.0, base)]
    return _solids.standing(_solids.revolved(_solids.polygon(flat), soft=min(0.4 * rim, 0.45 * height, 1.2)))


def napkin_ring(*, bore: float = 40.0, height: float = 30.0, wall: float = 3.0, belly: float = 1.6) -> SurfaceMesh:
    """A ring with a slight belly, standing on its edge.

    `bore` is the inner diameter, `wall` the thickness at both edges, `belly` how much thicker it is in the middle.
    """
    _solids.within(bore=(bore, 26, 80), height=(height, 14, 70), wall=(wall, 1.6, 8), belly=(belly, 0, 6))
    level = np.linspace(-1.0, 1.0, 33)
    outer = np.column_stack([bore / 2 + wall + belly * (1.0 - level**2), height * (1.0 + level) / 2])
    section = _solids.polygon([(bore / 2, 0.0), *outer, (bore / 2, height)])
    return _solids.standing(_solids.revolved(section, soft=0.3 * wall))


def tealight_holder(*, diameter: float = 82.0, height: float = 40.0, cup: float = 41.0, sink: float = 19.0) -> SurfaceMesh:
    """A bellied block with a recess for a tealight.

    `diameter` is the greatest, `cup` that of the recess, `sink` its depth.
    """
    _solids.within(diameter=(diameter, 56, 140), height=(height, 20, 90), cup=(cup, 38, 0.62 * diameter), sink=(sink, 6, height - 5))
    level = np.linspace(0.0, 1.0, 41)
    radius = diameter / 2 * (0.70 + 0.30 * np.sin(np.pi * (0.08 + 0.80 * level)) ** 0.9)
    outer = np.column_stack([radius, height * level])
    recess = [(cup / 2, height), (cup / 2, height - sink), (0.0, height - sink)]
    return _solids.standing(_solids.revolved(_solids.polygon([(0.0, 0.0), *outer, *recess]), soft=1.6))


def soap_dish(
    *, length: float = 124.0, width: float = 86.0, height: float = 24.0, wall: float = 3.0, base: float = 3.4, ribs: int = 5
) -> SurfaceMesh:
    """A rounded dish with ribs under the soap and slits for the water.

    `wall` and `base` are thicknesses; there is a slit between two of the `ribs` across the floor.
    """
    ribs = _solids.count("ribs", ribs, 2, 9)
    _solids.within(length=(length, 80, 180), width=(width, 56, 130), height=(height, 12, 50), wall=(wall, 2, 6), base=(base, 2, 8))
    outline = _solids.polygon(_solids.superellipse(length / 2, width / 2, 3.4, 160))
    dish = _solids.slab(outline, height, foot=FOOT, top=0.45 * wall)
    floor = 0.3 * (height - base)
    dish -= _solids.pocket(_solids.offset(outline, -wall), height - base, floor=floor, flare=0.4 * wall).translate((0.0, 0.0, height))
    span, step = 0.58 * width, 0.72 * (length - 2 * wall) / ribs
    rib = _solids.slab(_solids.box(3.6, span, 1.7), 3.4, foot=0.0, top=1.2).translate((0.0, 0.0, base - 0.4))
    slit = _solids.through(_solids.stroke([(0.0, -0.36 * span), (0.0, 0.36 * span)], 4.0), -1.0, base + 1.0)
    for number in range(ribs):
        x = (number - (ribs - 1) / 2) * step
        dish += rib.translate((x, 0.0, 0.0))
        if number:
            dish -= slit.translate((x - step / 2, 0.0, 0.0))
    return _solids.standing(dish)


def drawer_organiser(
    *, length: float = 152.0, width: float = 104.0, height: float = 38.0, wall: float = 2.0, base: float = 2.0
) -> SurfaceMesh:
    """A tray for a drawer: a long compartment and two short ones.

    `wall` and `base` are thicknesses.
    """
    _solids.within(length=(length, 80, 250), width=(width, 60, 200), height=(height, 15, 90), wall=(wall, 1.4, 5), base=(base, 1.4, 6))
    corner = 7.0
    tray = _solids.slab(_solids.box(length, width, corner + wall), height, foot=FOOT, top=0.45 * wall)
    inner, deep = length - 2 * wall, width - 3 * wall
    back, front, left = 0.38 * deep, 0.62 * deep, 0.4 * (inner - wall)
    cells = [(inner, back, 0.0, width / 2 - wall - back / 2)]
    cells += [(left, front, -length / 2 + wall + left / 2, -width / 2 + wall + front / 2)]
    cells += [(inner - wall - left, front, (wall + left) / 2, -width / 2 + wall + front / 2)]
    for long, wide, x, y in cells:
        tray -= _solids.pocket(_solids.box(long, wide, corner), height - base, floor=4.0, flare=0.4 * wall).translate((x, y, height))
    return _solids.standing(tray)
