"""Models that keep things together or are carried along: clips, cable winder, spectacle frame, key tag; measures in mm."""

from __future__ import annotations

import math

import numpy as np
from manifold3d import CrossSection, Manifold

from mechstyle.gallery import _solids
from mechstyle.records.mesh import SurfaceMesh


def cable_clip(*, cables: int = 3, cable: float = 6.0, pitch: float = 15.0, height: float = 13.0, depth: float = 20.0) -> SurfaceMesh:
    """A block for the edge of a desk that cables are pressed into from above.

    `cables` side by side, each of a diameter `cable`, `pitch` from one to the next.
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
    *, length: float = 92.0, width: float = 46.0, thickness: float = 4.5, waist: float = 26.0, slit: float = 3.4
) -> SurfaceMesh:
    """A flat bone to wind a cable around, with slits that hold its ends.

    `waist` is its width where the cable lies, `slit` that of the slits.
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


def bag_clip(*, length: float = 116.0, depth: float = 14.0, thickness: float = 4.2, gap: float = 2.6, loop: float = 9.0) -> SurfaceMesh:
    """Two springy jaws that are pushed over the folded mouth of a bag, lying on their side.

    `depth` and `thickness` of the jaws, the `gap` between them, and the inner radius `loop` of the bend that lets them spring.
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


def spectacle_frame(
    *, lens_width: float = 49.0, lens_height: float = 41.0, bridge: float = 19.0, rim: float = 4.2, depth: float = 4.4
) -> SurfaceMesh:
    """The front of a pair of spectacles, lying flat.

    `bridge` is the gap between the lens openings, `rim` its width around a lens, `depth` the thickness of the front.
    """
    _solids.within(lens_width=(lens_width, 36, 64), lens_height=(lens_height, 26, 56), bridge=(bridge, 14, 28))
    _solids.within(rim=(rim, 2.5, 0.45 * bridge), depth=(depth, 2.5, 8))
    lens = _lens(lens_width, lens_height)
    middle = (lens_width + bridge) / 2
    lenses = lens.translate((-middle, 0.0)) + lens.mirror((1.0, 0.0)).translate((middle, 0.0))
    around = _solids.offset(lenses, rim)
    spots = np.linspace(-1.0, 1.0, 9)
    arch = np.column_stack([spots * (0.5 * bridge + 0.5 * rim), lens_height * (0.20 + 0.06 * (1 - spots**2))])
    edge, brow = lens_width + bridge / 2, 0.24 * lens_height
    outline = around + _solids.stroke(arch, 1.25 * rim)
    for side in (-1.0, 1.0):
        outline += _solids.stroke([(side * edge, brow), (side * (edge + rim + 3.5), brow + 1.5)], 1.6 * rim)
    rounding = 0.3 * min(rim, depth)
    front = _solids.softened(outline, rounding + 0.6, 3.0) - lenses
    return _solids.standing(_solids.slab(front, depth, foot=0.5, top=rounding))


def key_tag(*, length: float = 64.0, width: float = 30.0, thickness: float = 3.0, border: float = 1.4, eye: float = 5.0) -> SurfaceMesh:
    """A tag for a key ring with a raised border, lying flat.

    `thickness` is that of its face, `border` the height of the border above it, `eye` the diameter of the hole.
    """
    _solids.within(length=(length, 36, 110), width=(width, 18, 60), thickness=(thickness, 1.6, 8), border=(border, 0.4, 3))
    _solids.within(eye=(eye, 3, 0.3 * width))
    corner = 0.36 * width
    place = (-length / 2 + 0.5 * width, 0.0)
    outline = CrossSection.batch_hull([_solids.box(length, width, corner), _solids.disc(width / 2).translate(place)])
    hole = _solids.disc(eye / 2).translate((place[0] - 0.18 * width, 0.0))
    edge = outline - _solids.offset(outline, -2.6) + _solids.offset(hole, 2.6)
    face, frame = (outline, thickness, 0.0), (_solids.softened(edge, 0.9, 0.9), thickness + border, 0.8)
    tag = sum((_solids.slab(section, high, foot=0.5, top=top) for section, high, top in (face, frame)), Manifold())
    return _solids.standing(tag - _solids.through(hole, -1.0, thickness + border + 1.0))


def _lens(width: float, height: float) -> CrossSection:
    """A panto lens for the left of the wearer's picture: flat brow, narrower towards the cheek."""
    line = _solids.superellipse(width / 2, height / 2, 2.5, 120)
    down = 0.5 - line[:, 1] / height
    line[:, 0] *= 1.0 - 0.10 * down**2
    line[:, 0] -= 0.03 * width * np.sin(math.pi * (down - 0.5))
    return _solids.polygon(line)
