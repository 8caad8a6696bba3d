"""Models that hold things or surround them: pen holder, vase, pill box, planter, toothbrush holder, lampshade; measures in mm."""

from __future__ import annotations

import math

import numpy as np
from manifold3d import CrossSection

from mechstyle.errors import BadInput
from mechstyle.gallery import _solids
from mechstyle.gallery._solids import FOOT
from mechstyle.records.mesh import Floats, SurfaceMesh


def pen_holder(*, diameter: float = 80.0, height: float = 100.0, wall: float = 3.0, base: float = 3.2) -> SurfaceMesh:
    """A round cup for pens with a rounded rim.

    `diameter` is the outer one; `wall` and `base` are thicknesses, here and below.
    """
    _solids.within(diameter=(diameter, 30, 200), height=(height, 30, 250), wall=(wall, 1.2, 8), base=(base, 1.2, 10))
    radius, half = diameter / 2, wall / 2
    inside, fillet = radius - wall, min(5.0, 0.2 * (diameter - 2 * wall))
    over = np.linspace(0.0, math.pi, 13)
    into = np.linspace(0.0, math.pi / 2, 9)
    outer = [(radius - FOOT, 0.0), (radius, FOOT)]
    rim = np.column_stack([radius - half + half * np.cos(over), height - half + half * np.sin(over)])
    floor = np.column_stack([inside - fillet * (1 - np.cos(into)), base + fillet * (1 - np.sin(into))])
    return _solids.standing(_solids.turned(np.concatenate([outer, rim, floor])))


def vase(
    *, height: float = 150.0, diameter: float = 96.0, wall: float = 2.4, base: float = 3.0, lobes: int = 9, relief: float = 2.2,
    twist: float = 70.0,
) -> SurfaceMesh:  # fmt: skip
    """A bellied vase with a narrow neck and lobes that wind around it.

    `diameter` is the greatest between the `lobes` around it, `relief` the depth of a wave from its middle, `twist` how far the waves wind
    from foot to rim [degrees].
    """
    _solids.within(height=(height, 60, 260), diameter=(diameter, 40, 200), wall=(wall, 1.5, 6), base=(base, 1.2, 10))
    _solids.within(relief=(relief, 0, 5), twist=(twist, -180, 180))
    lobes = _solids.count("lobes", lobes, 3, 24)
    if relief * lobes > 0.35 * diameter:
        raise BadInput(f"{lobes} waves of {relief:g} mm are too steep for a vase of {diameter:g} mm: take fewer or flatter ones")
    turn = _solids.angles(lobes)
    up = np.concatenate([[0.0], np.linspace(FOOT / height, 1.0 - wall / (2 * height), 64)])
    # Waves start round at the foot and calm down at the lip.
    fade = _smoothstep(up / 0.2) * (1.0 - 0.6 * _smoothstep((up - 0.75) / 0.25))
    waves = fade[:, None] * np.cos(lobes * (turn + math.radians(twist) * up[:, None]))
    weights = (0.58, 0.80, 1.55, 1.05, 0.10, 0.45, 0.62)  # of a Bernstein polynomial: foot, belly, neck and lip, over the greatest radius
    belly = np.asarray(sum(w * math.comb(6, k) * up**k * (1 - up) ** (6 - k) for k, w in enumerate(weights)))
    outer = belly[:, None] * (diameter / 2 + relief * waves)
    inner = _solids.inner_radius(outer, up * height, turn, wall)
    outer[0] -= FOOT
    lip, lip_level = _solids.rim(outer[-1], inner[-1], up[-1] * height, wall / 2)
    bowl, bowl_level = _solids.bowl(inner, up * height, base, fillet=6.0)
    radius, level = np.concatenate([outer, lip, bowl]), np.concatenate([up * height, lip_level, bowl_level])
    return _solids.standing(_solids.skinned(_solids.rings(radius, level, turn)))


def pill_box(
    *, cells: int = 7, width: float = 18.0, length: float = 26.0, depth: float = 15.0, wall: float = 2.0, base: float = 2.2
) -> SurfaceMesh:
    """A tray with a row of cells, rounded inside so that pills slide out.

    `width` along the row, `length` across it and `depth` are the inner ones of a cell.
    """
    cells = _solids.count("cells", cells, 1, 14)
    _solids.within(width=(width, 12, 60), length=(length, 12, 80), depth=(depth, 6, 60))
    _solids.within(wall=(wall, 1.2, 5), base=(base, 1.2, 6))
    corner = min(6.0, 0.3 * min(width, length))
    outline = _solids.box(cells * (width + wall) + wall, length + 2 * wall, corner + wall)
    tray = _solids.slab(outline, base + depth, foot=FOOT, top=0.5 * wall)
    cell = _solids.pocket(_solids.box(width, length, corner), depth, floor=min(0.9 * corner, 0.5 * depth), flare=0.45 * wall)
    for number in range(cells):
        tray -= cell.translate(((number - (cells - 1) / 2) * (width + wall), 0.0, base + depth))
    return _solids.standing(tray)


def planter(
    *, diameter: float = 106.0, height: float = 92.0, wall: float = 3.0, base: float = 4.0, taper: float = 12.0, drain: float = 7.0
) -> SurfaceMesh:
    """A flower pot with a collar and drain holes.

    `diameter` is that of the collar, `taper` how much narrower the foot is on each side, `drain` the diameter of the five holes.
    """
    _solids.within(diameter=(diameter, 50, 220), height=(height, 40, 200), wall=(wall, 2.0, 8), base=(base, 2.0, 10))
    _solids.within(taper=(taper, 0, 0.22 * diameter), drain=(drain, 3, 0.14 * (diameter - 2 * taper)))
    collar, band = 0.22 * height, 0.9 * wall
    mouth = diameter / 2 - band
    foot = mouth - taper
    at_band = foot + taper * (1.0 - collar / height)
    outer = [(0.0, 0.0), (foot, 0.0), (at_band, height - collar - band), (mouth + band, height - collar)]
    outer += [(mouth + band, height), (0.0, height)]
    lean = math.hypot(1.0, taper / height)
    low, high = foot - wall * lean + taper * base / height, mouth - wall * lean
    inside = _solids.polygon([(0.0, base), (low, base), (high, height), (high, height + 9.0), (0.0, height + 9.0)])
    inside = _solids.softened(inside + inside.mirror((1.0, 0.0)), 6.0, 0.5)
    pot = _solids.revolved(_solids.polygon(outer) - inside, soft=0.42 * wall)
    hole = _solids.through(_solids.disc(drain / 2), -1.0, base + 1.0)
    for turn in range(5):
        pot -= hole.translate((0.55 * foot, 0.0, 0.0)).rotate((0.0, 0.0, 72.0 * turn))
    return _solids.standing(pot)


def toothbrush_holder(
    *, height: float = 84.0, brush: float = 21.0, tube: float = 46.0, wall: float = 2.4, base: float = 3.0
) -> SurfaceMesh:
    """Three wells for brushes grown together with a wide one for the tube.

    `brush` is the diameter of the well of a brush, `tube` the inner width of that of the tube.
    """
    _solids.within(height=(height, 40, 140), brush=(brush, 14, 32), wall=(wall, 1.6, 5), base=(base, 1.6, 8))
    _solids.within(tube=(tube, 1.2 * brush, 2.9 * brush))
    step, deep = brush + wall, 0.62 * tube
    wells = [(_solids.disc(brush / 2), x, brush / 2 + wall) for x in (-step, 0.0, step)]
    wells.append((_solids.box(tube, deep, 0.42 * deep), 0.0, -deep / 2))
    outline = sum((_solids.offset(well, wall).translate((x, y)) for well, x, y in wells), CrossSection())
    body = _solids.slab(_solids.softened(outline, wall, 9.0), height, foot=FOOT, top=0.45 * wall)
    for well, x, y in wells:
        body -= _solids.pocket(well, height - base, floor=0.25 * brush, flare=0.4 * wall).translate((x, y, height))
    return _solids.standing(body)


def _smoothstep(x: Floats) -> Floats:
    t = np.clip(x, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


SHOULDER, COLLAR = 0.64, 0.92
"""Where the wall of a lampshade turns inwards and where it is upright again, over its height."""
FLATTEST = 1.2
"""How far a shoulder may reach in for each millimetre it rises, 50 degrees from upright: more is not printed without support."""


def lampshade(
    *, lower: float = 120.0, upper: float = 80.0, height: float = 104.0, wall: float = 2.4, lobes: int = 12, relief: float = 2.5,
    twist: float = 30.0, socket: float = 42.0,
) -> SurfaceMesh:  # fmt: skip
    """A fluted bell that stands on its wide end; its shoulder narrows to a collar for the lamp socket.

    A ring on spokes would be printed in the air, and bent between the spokes wherever it lands: a shell hands on what it is struck with.

    `lower` is the diameter of the wide end, `upper` that to which the wall leans before its shoulder, `relief` the depth of one of the
    `lobes` at the wide end, from its middle, `twist` how far they wind from bottom to top [degrees], `socket` the opening of the collar.
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
    turned_in = _smoothstep(rise)
    leaning = (lower + (upper - lower) * share) / 2
    middle = leaning + (socket / 2 + wall - leaning) * turned_in
    depth = relief / (lower / 2) * (1.0 - turned_in)
    outer = middle * (1.0 + depth * np.cos(lobes * (turn + math.radians(twist) * share)))
    inner = _solids.inner_radius(outer, level, turn, wall)
    lip, lip_level = _solids.rim(outer[-1], inner[-1], float(level[-1]), wall / 2)
    walls = _solids.rings(np.concatenate([outer, lip, inner[::-1]]), np.concatenate([level, lip_level, level[::-1]]), turn)
    return _solids.standing(_solids.skinned(walls, closed=True))
