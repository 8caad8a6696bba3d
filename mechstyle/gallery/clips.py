"""Models that keep things together: cable clip, cable winder, bag clip."""

from __future__ import annotations

import numpy as np
from manifold3d import CrossSection

from mechstyle.gallery import _solids
from mechstyle.records.mesh import SurfaceMesh


def cable_clip(
    *,
    cables: int = 3,
    cable: float = 6.0,
    pitch: float = 15.0,
    height: float = 13.0,
    depth: float = 20.0,
) -> SurfaceMesh:
    """A block for the edge of a desk that cables are pressed into from above.

    Args:
        cables: Cables side by side.
        cable: Diameter of a cable [mm].
        pitch: Way from one cable to the next [mm].
        height: Height [mm].
        depth: Depth [mm].
    """
    cables = _solids.count("cables", cables, 1, 8)
    _solids.within(cable=(cable, 3, 12), pitch=(pitch, cable + 6, 40), height=(height, cable + 5, 30), depth=(depth, 10, 60))
    length = cables * pitch + 5.0
    below = CrossSection.square((length + 2, height + 2), center=True).translate((0.0, -height / 2 - 1))
    block = _solids.box(length, 2 * height, 0.62 * height) - below
    for number in range(cables):
        x = (number - (cables - 1) / 2) * pitch
        block -= _solids.disc(cable / 2).translate((x, 2.6 + cable / 2))
        block -= _solids.stroke([(x, 2.6 + cable / 2), (x, height + cable)], 0.62 * cable)
    return _solids.standing(_solids.bar(_solids.softened(block, 0.8, 0.8), depth, 0.9))


def cable_winder(
    *,
    length: float = 92.0,
    width: float = 46.0,
    thickness: float = 4.5,
    waist: float = 26.0,
    slit: float = 3.4,
) -> SurfaceMesh:
    """A flat bone to wind a cable around, with slits that hold its ends.

    Args:
        length: Length [mm].
        width: Width [mm].
        thickness: Thickness [mm].
        waist: Width where the cable lies [mm].
        slit: Width of the slits [mm].
    """
    _solids.within(length=(length, 50, 150), width=(width, 30, 90), thickness=(thickness, 2.4, 10), waist=(waist, 12, width - 10))
    _solids.within(slit=(slit, 2, 7))
    notch = _solids.box(0.56 * length, width - waist, 0.35 * (width - waist))
    outline = _solids.box(length, width, 0.24 * width) - notch.translate((0.0, width / 2)) - notch.translate((0.0, -width / 2))
    place = 0.5 * length - 0.11 * length
    for side in (-1.0, 1.0):
        middle, edge = (side * place, side * 0.22 * width), (side * place, side * width)
        outline -= _solids.stroke([middle, edge], slit) + _solids.disc(0.8 * slit).translate(middle)
    return _solids.standing(_solids.slab(_solids.softened(outline, 1.4, 1.4), thickness, foot=0.6, top=1.2))


def bag_clip(
    *,
    length: float = 116.0,
    depth: float = 14.0,
    thickness: float = 4.2,
    gap: float = 2.6,
    loop: float = 9.0,
) -> SurfaceMesh:
    """Two springy jaws that are pushed over the folded mouth of a bag, lying on their side.

    Args:
        length: Length [mm].
        depth: Depth of the jaws [mm].
        thickness: Thickness of the jaws [mm].
        gap: Space between them [mm].
        loop: Inner radius of the bend that lets them spring [mm].
    """
    _solids.within(length=(length, 60, 180), depth=(depth, 8, 30), thickness=(thickness, 2.4, 8), gap=(gap, 1.2, 8))
    _solids.within(loop=(loop, gap, 20))
    half, radius = (gap + thickness) / 2, loop + thickness / 2
    bend = _solids.arc((radius, 0.0), radius, 38.0, 180.0, 33)
    jaw = [(2 * radius + 8.0, half), (length - 16.0, half), (length - 7.0, half + 1.6), (length, half + 6.0)]
    upper = np.array([*jaw[::-1], *bend])
    line = np.concatenate([upper, upper[::-1][1:] * (1.0, -1.0)])
    outline = _solids.softened(_solids.stroke(line, thickness), 0.35 * thickness, 0.45 * gap)
    return _solids.standing(_solids.slab(outline, depth, foot=0.7, top=0.3 * thickness))
