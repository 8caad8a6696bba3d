"""Models that things hang from: S-hook, coat hook, bag carrier."""

from __future__ import annotations

import numpy as np

from mechstyle.gallery import _solids
from mechstyle.records.mesh import SurfaceMesh


def s_hook(
    *,
    opening: float = 26.0,
    thickness: float = 8.0,
    depth: float = 9.0,
    mouth: float = 70.0,
) -> SurfaceMesh:
    """A hook in the form of an S, lying flat.

    Args:
        opening: Inner diameter of both bends [mm].
        thickness: Thickness of the bar [mm].
        depth: How thick it lies [mm].
        mouth: Angle by which both bends are open [degrees].
    """
    _solids.within(opening=(opening, 12, 60), thickness=(thickness, 4, 16), depth=(depth, 4, 20), mouth=(mouth, 45, 110))
    bend = (opening + thickness) / 2
    upper = _solids.arc((0.0, bend), bend, mouth - 90.0, 270.0, 65)
    line = np.concatenate([upper, -upper[::-1][1:]])
    return _solids.standing(_solids.slab(_solids.stroke(line, thickness), depth, foot=0.8, top=0.32 * thickness))


def coat_hook(
    *,
    door: float = 40.0,
    drop: float = 96.0,
    reach: float = 34.0,
    width: float = 26.0,
    thickness: float = 5.6,
) -> SurfaceMesh:
    """A coat hook that hangs over a door, lying on its side as it is printed.

    Args:
        door: Thickness of the door [mm].
        drop: From the top of the door to the middle of the bend [mm].
        reach: Inner width of the bend [mm].
        width: Width [mm].
        thickness: Thickness of the strap [mm].
    """
    _solids.within(door=(door, 15, 60), drop=(drop, 50, 180), reach=(reach, 18, 60), width=(width, 14, 50))
    _solids.within(thickness=(thickness, 4, 10))
    front, bend = door + thickness, (reach + thickness) / 2
    hanger = [(0.0, -0.45 * drop), (0.0, 0.0), (front, 0.0), (front, -drop)]
    curl = _solids.arc((front + bend, -drop), bend, 180.0, 380.0)
    lift = curl[-1] + np.array([0.34, 0.94]) * 0.28 * reach
    strap = _solids.softened(_solids.stroke([*hanger, *curl[1:], lift], thickness), 0.3 * thickness, 4.0)
    return _solids.standing(_solids.slab(strap, width, foot=0.8, top=0.28 * thickness))


def bag_carrier(
    *,
    grip: float = 104.0,
    bend: float = 22.0,
    thickness: float = 11.0,
    depth: float = 22.0,
    bow: float = 7.0,
) -> SurfaceMesh:
    """A grip with a hook at each end for the handles of heavy bags, lying flat.

    Args:
        grip: Length of the grip between the hooks [mm].
        bend: Inner diameter of the hooks [mm].
        thickness: Thickness of the bar [mm].
        depth: How thick it lies, which is what the hand closes around [mm].
        bow: How far the grip is bowed upwards [mm].
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
