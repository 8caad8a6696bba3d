"""Models one wears or carries along: spectacle frame, key tag."""

from __future__ import annotations

import math

import numpy as np
from manifold3d import CrossSection, Manifold

from mechstyle.gallery import _solids
from mechstyle.records.mesh import SurfaceMesh


def spectacle_frame(
    *,
    lens_width: float = 49.0,
    lens_height: float = 41.0,
    bridge: float = 19.0,
    rim: float = 4.2,
    depth: float = 4.4,
) -> SurfaceMesh:
    """The front of a pair of spectacles, lying flat.

    Args:
        lens_width: Width of a lens opening [mm].
        lens_height: Height of a lens opening [mm].
        bridge: Gap between the lens openings [mm].
        rim: Width of the rim around a lens [mm].
        depth: Thickness of the front [mm].
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


def key_tag(
    *,
    length: float = 64.0,
    width: float = 30.0,
    thickness: float = 3.0,
    border: float = 1.4,
    eye: float = 5.0,
) -> SurfaceMesh:
    """A tag for a key ring with a raised border, lying flat.

    Args:
        length: Length [mm].
        width: Width [mm].
        thickness: Thickness of its face [mm].
        border: Height of the border above the face [mm].
        eye: Diameter of the eye for the ring [mm].
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
