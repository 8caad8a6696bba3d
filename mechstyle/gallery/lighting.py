"""Models around a lamp: lampshade."""

from __future__ import annotations

import math

import numpy as np
from manifold3d import CrossSection, Manifold

from mechstyle.errors import BadInput
from mechstyle.gallery import _shells, _solids
from mechstyle.records.mesh import SurfaceMesh


def lampshade(
    *,
    lower: float = 130.0,
    upper: float = 84.0,
    height: float = 110.0,
    wall: float = 2.0,
    lobes: int = 14,
    relief: float = 3.0,
    twist: float = 40.0,
    socket: float = 42.0,
) -> SurfaceMesh:
    """A fluted shade that stands on its wide end, with a ring for the lamp socket on three spokes.

    Args:
        lower: Diameter of the wide end [mm].
        upper: Diameter of the narrow end [mm].
        height: Height [mm].
        wall: Thickness of the shade [mm].
        lobes: Flutes around it.
        relief: Depth of a flute at the wide end, from its middle [mm].
        twist: How far the flutes wind from bottom to top [degrees].
        socket: Opening of the socket ring [mm].
    """
    _solids.within(lower=(lower, 60, 240), upper=(upper, 60, 200), height=(height, 50, 220), wall=(wall, 1.5, 4))
    lobes = _solids.count("lobes", lobes, 0, 36)
    _solids.within(relief=(relief, 0, 6), twist=(twist, -120, 120), socket=(socket, 20, upper - 24))
    if abs(lower - upper) / 2 + relief * lobes * abs(math.radians(twist)) > 0.6 * height:
        raise BadInput(f"a wall {height:g} mm high would lean too far: bring the diameters together or take fewer or straighter flutes")
    turn = _shells.angles(lobes)
    level = np.linspace(0.0, height - wall / 2, 49)
    share = level[:, None] / height
    middle = (lower + (upper - lower) * share) / 2
    outer = middle * (1.0 + relief / (lower / 2) * np.cos(lobes * (turn + math.radians(twist) * share)))
    inner = _shells.inner_radius(outer, level, turn, wall)
    lip, lip_level = _shells.rim(outer[-1], inner[-1], float(level[-1]), wall / 2)
    walls = _shells.rings(np.concatenate([outer, lip, inner[::-1]]), np.concatenate([level, lip_level, level[::-1]]), turn)
    core = _solids.skinned(_shells.rings((outer + inner) / 2, level, turn))
    fitting = _fitting(socket, lower / 2).translate((0.0, 0.0, height - 20.0))
    return _solids.standing(_solids.skinned(walls, closed=True) + (fitting ^ core))


def _fitting(socket: float, reach: float, ring: float = 4.0, deep: float = 5.0) -> Manifold:
    """A ring around a lamp socket with three spokes that reach out and widen, so that they do not tear off the wall [mm]."""
    flat = _solids.disc(socket / 2 + ring)
    spoke = CrossSection.batch_hull([_solids.disc(3.5), _solids.disc(11.0).translate((reach, 0.0))])
    for turn in (90.0, 210.0, 330.0):
        flat += spoke.rotate(turn)
    return _solids.slab(_solids.softened(flat, 1.5, 6.0) - _solids.disc(socket / 2), deep, top=1.2)
