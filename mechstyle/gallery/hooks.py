"""Models that hang on a wall or hold an angle: S-hook, coat hook, bag carrier, brackets, book-end; measures in mm."""

from __future__ import annotations

import math

import numpy as np
from manifold3d import CrossSection

from mechstyle.gallery import _solids
from mechstyle.records.mesh import SurfaceMesh


def s_hook(*, opening: float = 26.0, thickness: float = 8.0, depth: float = 9.0, mouth: float = 70.0) -> SurfaceMesh:
    """A hook in the form of an S, lying flat.

    `opening` is the inner diameter of both bends, `depth` how thick it lies, `mouth` the angle by which both bends are open [degrees].
    """
    _solids.within(opening=(opening, 12, 60), thickness=(thickness, 4, 16), depth=(depth, 4, 20), mouth=(mouth, 45, 110))
    bend = (opening + thickness) / 2
    upper = _solids.arc((0.0, bend), bend, mouth - 90.0, 270.0, 65)
    line = np.concatenate([upper, -upper[::-1][1:]])
    return _solids.standing(_solids.slab(_solids.stroke(line, thickness), depth, foot=0.8, top=0.32 * thickness))


def coat_hook(*, door: float = 40.0, drop: float = 96.0, reach: float = 34.0, width: float = 26.0, thickness: float = 5.6) -> SurfaceMesh:
    """A coat hook that hangs over a door, lying on its side as it is printed.

    `door` is the thickness of the door, `drop` the way from its top to the middle of the bend, `reach` the inner width of the bend.
    """
    _solids.within(door=(door, 15, 60), drop=(drop, 50, 180), reach=(reach, 18, 60), width=(width, 14, 50))
    _solids.within(thickness=(thickness, 4, 10))
    front, bend = door + thickness, (reach + thickness) / 2
    hanger = [(0.0, -0.45 * drop), (0.0, 0.0), (front, 0.0), (front, -drop)]
    curl = _solids.arc((front + bend, -drop), bend, 180.0, 380.0)
    lift = curl[-1] + np.array([0.34, 0.94]) * 0.28 * reach
    strap = _solids.softened(_solids.stroke([*hanger, *curl[1:], lift], thickness), 0.3 * thickness, 4.0)
    return _solids.standing(_solids.slab(strap, width, foot=0.8, top=0.28 * thickness))


def bag_carrier(*, grip: float = 104.0, bend: float = 22.0, thickness: float = 11.0, depth: float = 22.0, bow: float = 7.0) -> SurfaceMesh:
    """A grip with a hook at each end for the handles of heavy bags, lying flat.

    `grip` is its length between the hooks, `bend` their inner diameter, `depth` what the hand closes around, `bow` how far the grip is
    bowed.
    """
    _solids.within(grip=(grip, 80, 150), bend=(bend, 12, 40), thickness=(thickness, 7, 18))
    _solids.within(depth=(depth, 12, 34), bow=(bow, 0, 0.12 * grip))
    radius, end = (bend + thickness) / 2, grip / 2
    share = np.linspace(-1.0, 1.0, 33)[1:-1]
    arch = np.column_stack([end * share, bow * (1.0 - share**2)])
    right = np.concatenate([_solids.arc((end + radius, -0.35 * bend), radius, 180.0, 360.0), [(end + 2 * radius + 0.8, 0.45 * bend)]])
    left = (right * (-1.0, 1.0))[::-1]
    outline = _solids.softened(_solids.stroke([*left, *arch, *right], thickness), 0.3 * thickness, 5.0)
    return _solids.standing(_solids.slab(outline, depth, foot=1.0, top=0.36 * thickness))


def shelf_bracket(
    *, depth: float = 120.0, height: float = 96.0, width: float = 24.0, thickness: float = 8.0, screw: float = 4.5
) -> SurfaceMesh:
    """A bracket with a curved brace for a shelf, lying on its side as it is printed: the wall left, the shelf on top.

    `depth` is the reach under the shelf, `thickness` that of legs and brace, `screw` the diameter of the two holes in each leg.
    """
    _solids.within(depth=(depth, 70, 220), height=(height, 60, 200), width=(width, 14, 50), thickness=(thickness, 5, 14))
    _solids.within(screw=(screw, 2.5, 0.4 * width))
    legs = _solids.stroke([(depth, 0.0), (0.0, 0.0)], thickness) + _solids.stroke([(0.0, 0.0), (0.0, -height)], thickness)
    turn = np.linspace(0.0, math.pi / 2, 33)
    hollow = np.column_stack([1 - np.cos(turn), np.sin(turn) - 1])
    straight = np.linspace((0.0, -1.0), (1.0, 0.0), len(turn))
    curve = (0.3 * hollow + 0.7 * straight) * (0.88 * depth, 0.88 * height)
    outline = _solids.softened(legs + _solids.stroke(curve, 0.85 * thickness), 0.38 * thickness, 6.0)
    body = _solids.slab(outline, width, foot=0.8, top=1.6)
    hole = _solids.through(_solids.disc(screw / 2), -thickness, thickness)
    for share in (0.2, 0.94):
        body -= hole.rotate((90.0, 0.0, 0.0)).translate((share * depth, 0.0, width / 2))
        body -= hole.rotate((0.0, 90.0, 0.0)).translate((0.0, -share * height, width / 2))
    return _solids.standing(body)


def corner_bracket(
    *, leg: float = 58.0, width: float = 42.0, thickness: float = 5.0, gusset: float = 4.0, screw: float = 4.5
) -> SurfaceMesh:
    """A right angle with a gusset on both sides and countersunk holes, standing on one leg.

    `leg` is the length of both legs, `thickness` theirs, `gusset` that of the gussets, `screw` the diameter of the two holes in each leg.
    """
    _solids.within(leg=(leg, 36, 110), width=(width, 24, 90), thickness=(thickness, 3.5, 10), gusset=(gusset, 2.4, 0.2 * width))
    _solids.within(screw=(screw, 2.5, min(0.14 * width, 1.2 * thickness)))
    angle = _solids.polygon([(0.0, 0.0), (leg, 0.0), (leg, thickness), (thickness, thickness), (thickness, leg), (0.0, leg)])
    body = _solids.bar(_solids.softened(angle, 0.35 * thickness, 4.0), width, 0.22 * thickness)
    inner = 0.4 * thickness
    web = _solids.softened(_solids.polygon([(inner, inner), (0.84 * leg, inner), (inner, 0.84 * leg)]), 1.2, 1.0)
    rib = _solids.bar(web, gusset, 0.2 * gusset)
    for side in (-1.0, 1.0):
        body += rib.translate((0.0, side * (width / 2 - gusset / 2 - 0.3 * thickness), 0.0))
    hole = _solids.screw_hole(screw, thickness)
    for share in (0.36, 0.76):
        body -= hole.translate((share * leg, 0.0, thickness))
        body -= hole.rotate((0.0, 90.0, 0.0)).translate((thickness, 0.0, share * leg))
    return _solids.standing(body)


def book_end(
    *, height: float = 132.0, depth: float = 100.0, width: float = 104.0, thickness: float = 5.0, window: float = 26.0
) -> SurfaceMesh:
    """A book-end: a plate that books stand on, and one with rounded shoulders and a window that they lean against.

    `depth` is that of the plate under the books, `thickness` that of both plates, `window` the width of the window, whose ends are round.
    """
    _solids.within(height=(height, 80, 200), depth=(depth, 60, 160), width=(width, 60, 160), thickness=(thickness, 3, 10))
    _solids.within(window=(window, 16, min(width - 40, 0.4 * height)))
    line = [(depth, thickness / 2), (thickness / 2, thickness / 2), (thickness / 2, height - thickness / 2)]
    body = _solids.bar(_solids.softened(_solids.stroke(line, thickness), 0.38 * thickness, 9.0), width, 0.3 * thickness)
    corner = 0.24 * width
    front = CrossSection.batch_hull([_solids.box(width, 2 * height, corner), _solids.box(width, 6.0, 1.0)])
    plan = _solids.box(2 * depth + thickness, width, corner)
    body = body ^ _solids.through(front, -1.0, depth + thickness).rotate((90.0, 0.0, 90.0))
    body = body ^ _solids.through(plan, -1.0, height + 1.0)
    foot, head = (_solids.disc(window / 2).translate((0.0, share * height)) for share in (0.36, 0.64))
    slot = CrossSection.batch_hull([head, foot])
    body -= _solids.through(slot, -1.0, 1.5 * thickness).rotate((90.0, 0.0, 90.0))
    return _solids.standing(body.rotate((0.0, 0.0, 90.0)))
