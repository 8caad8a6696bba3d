"""Models around a lamp: lampshade."""

from __future__ import annotations

import math

import numpy as np

from mechstyle.errors import BadInput
from mechstyle.gallery import _solids
from mechstyle.records.mesh import SurfaceMesh

SHOULDER, COLLAR = 0.64, 0.92
"""Where the wall of a lampshade turns inwards and where it is upright again, over its height."""
FLATTEST = 1.2
"""How far a shoulder may reach in for each millimetre it rises, 50 degrees from upright: more is not printed without support."""


def lampshade(
    *,
    lower: float = 120.0,
    upper: float = 80.0,
    height: float = 104.0,
    wall: float = 2.4,
    lobes: int = 12,
    relief: float = 2.5,
    twist: float = 30.0,
    socket: float = 42.0,
) -> SurfaceMesh:
    """A fluted bell that stands on its wide end; its shoulder narrows to a collar for the lamp socket.

    A ring on spokes would be printed in the air, and bent between the spokes wherever it lands: a shell hands on what it is struck with.

    Args:
        lower: Diameter of the wide end [mm].
        upper: Diameter to which the wall leans before its shoulder [mm].
        height: Height [mm].
        wall: Thickness of the shade [mm].
        lobes: Flutes around it.
        relief: Depth of a flute at the wide end, from its middle [mm].
        twist: How far the flutes wind from bottom to top [degrees].
        socket: Opening of the collar [mm].
    """
    _solids.within(lower=(lower, 60, 240), upper=(upper, 60, 200), height=(height, 50, 220), wall=(wall, 1.5, 4))
    lobes = _solids.count("lobes", lobes, 0, 36)
    _solids.within(relief=(relief, 0, 6), twist=(twist, -120, 120), socket=(socket, 20, upper - 24))
    if abs(lower - upper) / 2 + relief * lobes * abs(math.radians(twist)) > 0.6 * height:
        raise BadInput(f"a wall {height:g} mm high would lean too far: bring the diameters together or take fewer or straighter flutes")
    if 1.5 * ((upper - socket) / 2 - wall) > FLATTEST * (COLLAR - SHOULDER) * height:  # where it is flattest
        raise BadInput(f"a shoulder from {upper:g} to {socket:g} mm would lie too flat: bring the two together or make the shade taller")
    turn = _solids.angles(lobes)
    level = np.linspace(0.0, height - wall / 2, 65)
    share = level[:, None] / height
    rise = np.clip((share - SHOULDER) / (COLLAR - SHOULDER), 0.0, 1.0)
    turned_in = np.asarray(rise**2 * (3.0 - 2.0 * rise))
    leaning = (lower + (upper - lower) * share) / 2
    middle = leaning + (socket / 2 + wall - leaning) * turned_in
    depth = relief / (lower / 2) * (1.0 - turned_in)
    outer = middle * (1.0 + depth * np.cos(lobes * (turn + math.radians(twist) * share)))
    inner = _solids.inner_radius(outer, level, turn, wall)
    lip, lip_level = _solids.rim(outer[-1], inner[-1], float(level[-1]), wall / 2)
    walls = _solids.rings(np.concatenate([outer, lip, inner[::-1]]), np.concatenate([level, lip_level, level[::-1]]), turn)
    return _solids.standing(_solids.skinned(walls, closed=True))
