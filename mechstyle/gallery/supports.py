"""Models that carry things: phone stand, wall hook, tablet stand, door stop; measures in mm."""

from __future__ import annotations

import math

import numpy as np
from manifold3d import CrossSection

from mechstyle.errors import BadInput
from mechstyle.gallery import _solids
from mechstyle.records.mesh import SurfaceMesh


def phone_stand(
    *, width: float = 72.0, height: float = 108.0, angle: float = 66.0, ledge: float = 15.0, thickness: float = 5.0, slot: float = 14.0
) -> SurfaceMesh:
    """A desk stand for a phone: a leaning back on a strut, a ledge with a lip, a slot for the cable.

    `height` is the length of the back, `angle` its lean above the desk [degrees], `ledge` the depth of the ledge, `thickness` that of every
    bar, `slot` the width of the cable slot.
    """
    _solids.within(width=(width, 40, 140), height=(height, 60, 180), angle=(angle, 50, 80), ledge=(ledge, 8, 30))
    _solids.within(thickness=(thickness, 3, 10), slot=(slot, 6, 0.4 * width))
    along = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    across = np.array([-along[1], along[0]])
    heel, end = (12.0 + 1.6 * thickness) * along, ledge + 0.5 * thickness
    foot, rear, brace = (-0.22 * height, 0.0), (0.62 * height, 0.0), 0.64 * height * along
    lines = ([foot, rear, brace], [(0.0, 0.0), height * along], [heel, heel + end * across, heel + end * across + 9.0 * along])
    side = sum((_solids.stroke(np.array(line), thickness) for line in lines), CrossSection())
    stand = _solids.bar(_solids.softened(side, 0.3 * thickness, 4.0), width, 0.25 * thickness)
    front, depth = heel - (0.5 * thickness + 2.0) * along + (0.5 * thickness + 1.0) * across, (ledge + 2.0 * thickness) * across
    cut = _solids.polygon([front, front + 40.0 * along, front + 40.0 * along + depth, front + depth])
    return _solids.standing((stand - _solids.bar(cut, slot, 0.0)).rotate((0.0, 0.0, 90.0)))


def wall_hook(
    *, height: float = 100.0, width: float = 34.0, plate: float = 6.0, reach: float = 48.0, thickness: float = 12.0, screw: float = 4.5
) -> SurfaceMesh:
    """A coat hook with a screw plate, lying on the plate as it is printed.

    `height`, `width` and the thickness `plate` are those of the plate, `reach` is how far the hook stands out from the wall, `thickness`
    that of the arm, `screw` the diameter of the two holes.
    """
    _solids.within(height=(height, 60, 160), width=(width, 24, 80), plate=(plate, 3, 12), reach=(reach, 32, 90))
    _solids.within(thickness=(thickness, 7, 18), screw=(screw, 2.5, min(0.2 * width, (plate - 1.8) / 0.55)))
    hole_place, root = 0.5 * height - 0.42 * width, 0.16 * height
    if hole_place - 1.1 * screw < root + 0.8 * thickness + 1.5:
        raise BadInput(f"a plate {width:g} x {height:g} mm has no room for {screw:g} mm screws beside a {thickness:g} mm arm: lengthen it")
    outline = _solids.softened(_solids.box(width, height, 0.42 * width), 3.0, 3.0)
    body = _solids.slab(outline, plate, top=0.35 * plate)
    # Middle line (y, z) and sizes of the arm, which leaves the plate, bends upwards and ends round.
    bend = 0.42 * reach
    straight, turn = reach - thickness / 2 - bend, np.linspace(0.0, math.radians(78.0), 25)
    arc = np.column_stack([bend * (1 - np.cos(turn)), straight + bend * np.sin(turn)])
    tip = arc[-1] + 0.32 * reach * np.linspace(0.0, 1.0, 25)[1:, None] * np.array([math.sin(turn[-1]), math.cos(turn[-1])])
    path = np.concatenate([np.column_stack([np.zeros(20), np.linspace(0.5 * plate, straight, 20)]), arc[1:], tip])
    way = np.concatenate([[0.0], np.linalg.norm(np.diff(path, axis=0), axis=1).cumsum()])
    flare = 1.0 + 0.55 * np.exp(-np.maximum(way - 0.5 * plate, 0.0) / 5.0)
    left = (way[-1] - way) / (0.5 * thickness)
    end = np.sqrt(np.clip(1.0 - (1.0 - np.clip(left, 0.0, 1.0)) ** 2, 0.02, 1.0))
    wide = 0.62 * width * np.minimum(flare, 1.3) * (1.0 - 0.25 * way / way[-1]) * end
    body += _solids.swept(path - (root, 0.0), np.column_stack([wide, thickness * flare * end]))
    sink = 0.55 * screw
    hole = _solids.turned([(screw / 2, -1.0), (screw / 2, plate - sink), (screw / 2 + sink + 1.0, plate + 1.0)])
    for y in (-hole_place, hole_place):
        body -= hole.translate((0.0, y, 0.0))
    return _solids.standing(body)


def tablet_stand(
    *, width: float = 128.0, height: float = 140.0, angle: float = 64.0, ledge: float = 15.0, thickness: float = 5.0, middle: float = 36.0
) -> SurfaceMesh:
    """A desk stand for a tablet: two triangles with hooks, joined by a leaning back that is cut out from above.

    Nothing wide lies level, because that is what a flat landing bends: see docs/gallery.md.

    `height` is the length of the back, `middle` that in its middle, `angle` its lean above the desk [degrees], `ledge` the room for a
    tablet in its cover, `thickness` that of the back; the triangles have 2.2 times that.
    """
    _solids.within(width=(width, 80, 200), height=(height, 100, 220), angle=(angle, 52, 76), ledge=(ledge, 8, 24))
    _solids.within(thickness=(thickness, 4, 8), middle=(middle, 16, 0.8 * height))
    along = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    top, triangle = height * along, 2.2 * thickness
    up = top / np.linalg.norm(top)
    across = np.array([-up[1], up[0]])
    # Side view: a triangle from heel to top with an opening, and a hook in front of its heel.
    frame = _solids.offset(_solids.polygon(np.array([[0.0, 0.0], [0.68 * float(np.linalg.norm(top)), 0.0], top])), 1.2 * thickness)
    rest = 26.0 * up + 1.2 * thickness * across  # of the tablet's edge
    lip, dot = rest + (ledge + 0.8 * thickness) * across, _solids.disc(0.9 * thickness)
    around = (lip + thickness * up, lip, (-1.2 * thickness, 0.9 * thickness), (0.0, 0.0), rest)
    hook = CrossSection.batch_hull([dot.translate((float(x), float(y))) for x, y in around])
    room = _solids.polygon([rest, rest + 60.0 * up, rest + 60.0 * up + ledge * across, rest + ledge * across])
    outline = _solids.softened(frame + (hook - _solids.softened(room, min(5.0, 0.4 * ledge), 0.1)), 0.6 * thickness, 1.2 * thickness)
    opening = _solids.offset(_solids.offset(frame, -21.0 - 1.2 * thickness), 7.0)
    # Simplified, else hairlines in some of its corners are creases, too.
    side = _solids.bar((outline - opening).simplify(0.05), triangle, 2.0)
    apart = 0.5 * (width - triangle)
    stand = side.translate((0.0, apart, 0.0)) + side.translate((0.0, -apart, 0.0))
    valley = CrossSection([_solids.superellipse(apart - 0.5 * triangle - 1.5 - thickness, height - middle, 2.4, 120)])
    low, high = -2.4 * thickness, height + 1.0  # beyond the floor, where it is cut, and to where the triangles are round
    plate = _solids.box(2.0 * apart, high - low, 1.0).translate((0.0, 0.5 * (low + high))) - valley.translate((0.0, height))
    edge = _solids.round_edge(1.2)  # below and above
    levels = [*((1.2 - z, inset) for z, inset in reversed(edge)), *((thickness - 1.2 + z, inset) for z, inset in edge)]
    back = _solids.lofted(_solids.softened(plate, 2.0, 2.0), levels)
    behind = -0.2 * thickness  # of the line from heel to top, so that the tablet lies on the triangles
    (x, z), across = along, np.array([-along[1], along[0]])
    place = np.array([[0.0, x, across[0], behind * across[0]], [-1.0, 0.0, 0.0, 0.0], [0.0, z, across[1], behind * across[1]]])
    stand = (stand + back.transform(place)).trim_by_plane((0.0, 0.0, 1.0), 0.0)  # so that all it stands on is one plane
    return _solids.standing(stand.rotate((0.0, 0.0, 90.0)))


def door_stop(*, length: float = 118.0, width: float = 44.0, height: float = 30.0, toe: float = 4.0, eye: float = 13.0) -> SurfaceMesh:
    """A wedge for under a door with an eye to hang it up by.

    `height` is that of the thick end, `toe` that of the thin end, `eye` the diameter of the eye.
    """
    _solids.within(length=(length, 70, 180), width=(width, 24, 80), height=(height, 18, 50), toe=(toe, 2.4, 0.4 * height))
    _solids.within(eye=(eye, 6, 0.55 * height))
    share = np.linspace(0.0, 1.0, 25)
    ramp = np.column_stack([length * share, toe + (height - toe) * share**1.15])
    wedge = _solids.softened(_solids.polygon(np.concatenate([[(0.0, 0.0), (length, 0.0)], ramp[::-1]])), 0.42 * toe, 1.0)
    hole = _solids.disc(eye / 2).translate((length - 0.5 * height, 0.48 * height))
    return _solids.standing(_solids.bar(wedge - hole, width, min(1.6, 0.4 * toe)).rotate((0.0, 0.0, 90.0)))
