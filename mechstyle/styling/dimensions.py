"""How large a style is on a part, in millimetres: the depth of its relief, the side it goes to, the size of its features."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.geometry.thickness import face_width, limited_slope
from mechstyle.loop import minimum_wall
from mechstyle.records import Recipe
from mechstyle.records.mesh import Floats, SurfaceMesh
from mechstyle.styling.drawing.canvas import Canvas, scale_by_area
from mechstyle.styling.drawing.operators import Operators
from mechstyle.styling.library import style_named
from mechstyle.styling.prompt import Wish

LEGIBLE, ENOUGH = 0.6, 3.0
"""A relief of the first depth is seen in an unpainted print [mm], one of the second whatever the size of its features …"""
SHALLOWEST, STEEPEST = 0.1, 0.4
"""… if it is at least this share of the size of a feature, and carried by it if it is at most this …"""
SHARE = 0.15
"""… and half of it is at least this share of the wall, by default."""
THIN, TWICE = 1.2, 2.0
"""Out of a wall thinner than the first [mm] a relief may stand as high as that, up to twice what the wall is thick."""
NOMINAL = 2.0
"""Height from the lowest to the highest of a relief as styles draw it, by which a share of the wall is reckoned."""
TAIL = 0.02
"""Share of the surface that may lie beyond what counts as the highest, or the lowest, of a relief."""
CUT = 0.25
"""A relief that is not to go to both sides alike takes at most this share of the wall."""
LEAST_FEATURE = 6.0
"""Features are at least so many nozzles wide unasked, so that the joints between them are about two …"""
ACROSS = 2.0
"""… and at least so many of them lie across a face, where that does not make them finer."""
_WORTH_A_NOTE = 0.02  # share of the surface
_THICKNESS_SLOPE = 0.3  # how fast the relief may grow along the surface where the wall gets thicker [mm/mm]


@dataclass(frozen=True, eq=False)
class Layout:
    """Where a relief lies on the walls of a part."""

    side: str  # where it goes from the surface, one of SIDES
    depth: Floats  # from its lowest to its highest [mm], shape [n]
    room: Floats  # how much of that may be cut into the wall [mm], shape [n]
    span: float | None  # what counts as a height from the lowest to the highest, None for that of the style as it is drawn
    notes: tuple[str, ...]  # what the user should know of it, in sentences

    def displacement(self, height: Floats, areas: Floats, cover: Floats | None = None) -> Floats:
        """The displacement [mm] of a relief as a style draws it, shape [n]; on both sides no volume is gained or lost to first order.

        The areas are those of the vertices, shape [n]; `cover` is as in `Relief`.
        """
        low, high = _range(height, areas) if cover is None else (-1.0, 1.0)
        span = high - low if self.span is None else self.span
        gain = self.depth / span if span > 0.0 else np.zeros_like(self.depth)
        weight = (areas if cover is None else areas * cover) * gain
        mean = float(weight @ height / weight.sum()) if weight.sum() > 0.0 else 0.0
        relief = gain * (height - mean) + self._shift(gain * (mean - low), gain * (high - mean))
        return relief if cover is None else cover * relief

    @property
    def reach(self) -> tuple[Floats, Floats]:
        """How far it may go inwards and outwards [mm], shape [n] each."""
        half = 0.5 * self.depth
        shift = self._shift(half, half)
        return half - shift, half + shift

    def _shift(self, lowest: Floats, highest: Floats) -> Floats:
        """How far outwards a relief is moved as a whole that goes so far inwards and outwards [mm], shape [n]."""
        if self.side == "inwards":
            return -highest
        return np.maximum(lowest - self.room, 0.0)


@dataclass(frozen=True)
class Dimensions:
    """What is asked of the size of a style, on whatever part; attributes as in a recipe."""

    relief: float | None = None
    amplitude: float | None = None
    side: str = "auto"
    feature: float | None = None
    nozzle: float = 0.4
    minimum_wall: float = 0.8

    @classmethod
    def of(cls, recipe: Recipe, wish: Wish | None = None) -> Dimensions:
        """Those of a recipe; what it leaves open the prompt may tell."""
        relief, feature = recipe.style.relief, recipe.style.feature
        if wish is not None:
            relief = wish.relief if relief is None and recipe.style.amplitude is None else relief
            feature = wish.feature if feature is None else feature
        return cls(relief, recipe.style.amplitude, recipe.style.side, feature, recipe.delivery.nozzle, recipe.delivery.minimum_wall)

    def canvas(self, mesh: SurfaceMesh, thickness: ArrayLike, wish: Wish, seed: int) -> Canvas:
        """What to draw a style on, with features of the size that is asked for, or that fits the part and its walls [mm], shape [n]."""
        if not wish.style:
            return Canvas(mesh, seed)
        nominal = style_named(wish.style).feature_mm * scale_by_area(mesh)
        if self.feature is not None:
            size = self.feature / nominal
        elif self.nozzle == 0.0:
            size = wish.size
        else:  # smaller on narrow faces and thin walls, which bear no deep relief, and no smaller than a nozzle prints
            largest = min(face_width(mesh) / ACROSS, float(outwards(np.median(np.asarray(thickness)))) / SHALLOWEST)
            size = wish.size * (max(min(nominal, largest), LEAST_FEATURE * self.nozzle) / nominal)
        return Canvas(mesh, seed, size, wish.colour, wish.shade, nozzle=self.nozzle)

    def layout(self, operators: Operators, thickness: ArrayLike, feature: float | None, amount: float = 1.0) -> Layout:
        """Depth and place of a relief on walls of a local thickness [mm], shape [n].

        No wall counts as thicker than the style's `feature` [mm], or a solid ball would grow spikes; None if it has none. `amount` is the
        factor of the prompt on a depth that is not given in mm.
        """
        wall = np.asarray(thickness, dtype=np.float64)
        counted = wall if feature is None else np.minimum(wall, feature)
        gradual = gradual_thickness(operators, counted)
        wanted = self._depth(gradual, feature, amount)
        span = None if self.amplitude is None or self.relief is not None else NOMINAL
        if self.side == "both":
            return Layout(self.side, wanted, np.full(len(wall), np.inf), span, ())
        whole = gradual if np.array_equal(counted, wall) else gradual_thickness(operators, wall)
        room = _room(self.side, whole, self.minimum_wall)
        depth = np.minimum(wanted, room if self.side == "inwards" else outwards(whole) + room)
        return Layout(self.side, depth, room, span, self._notes(operators.mesh, depth, room, feature, amount))

    def _depth(self, wall: Floats, feature: float | None, amount: float) -> Floats:
        """Depth on walls [mm] that bear it, shape [n]."""
        if self.relief is not None:
            return np.full(len(wall), self.relief)
        if self.amplitude is not None:
            return NOMINAL * (self.amplitude * amount * wall)
        least, most = (LEGIBLE, np.inf) if feature is None else (min(max(LEGIBLE, SHALLOWEST * feature), ENOUGH), STEEPEST * feature)
        return amount * np.minimum(np.maximum(NOMINAL * SHARE * wall, least), most)

    def _notes(self, mesh: SurfaceMesh, depth: Floats, room: Floats, feature: float | None, amount: float) -> tuple[str, ...]:
        areas = mesh.vertex_areas / mesh.vertex_areas.sum()
        asked = self.relief if self.relief is not None else LEGIBLE * min(amount, 1.0)
        short, uncut = depth < 0.99 * asked, room < 0.25 * depth
        notes = []
        if self.side == "auto" and areas[uncut].sum() > _WORTH_A_NOTE:
            notes.append(f"the relief only stands out of the wall on {areas[uncut].sum():.0%} of the surface: it is too thin to be cut")
        if (self.relief is not None or self.amplitude is None) and areas[short].sum() > _WORTH_A_NOTE:
            small = self.relief is None and feature is not None and STEEPEST * feature < LEGIBLE
            why = f"features of {feature:.2g} mm bear" if small else "the walls there bear"
            where = f"on {areas[short].sum():.0%} of the surface"
            notes.append(f"the relief is down to {depth[short].min():.2g} mm deep instead of {asked:.2g} mm {where}: {why} no more")
        return tuple(notes)


def outwards(wall: ArrayLike) -> Floats:
    """How far a relief may stand out of walls [mm], in the shape of `wall`: as far as they are thick, and farther out of thin ones."""
    thick = np.asarray(wall, dtype=np.float64)
    return np.maximum(thick, np.minimum(TWICE * thick, THIN))


def _room(side: str, wall: Floats, minimum: float) -> Floats:
    """How much of a relief walls take [mm], shape [n]."""
    if side == "outwards":
        return np.zeros_like(wall)
    return CUT * wall if side == "inwards" else np.minimum(CUT * wall, minimum_wall.room(wall, minimum))


def _range(height: Floats, areas: Floats) -> tuple[float, float]:
    """The lowest and the highest of a relief, but for a little of the surface."""
    order = np.argsort(height)
    share = np.cumsum(areas[order])
    low, high = np.searchsorted(share, np.array([TAIL, 1.0 - TAIL]) * share[-1])
    return float(height[order][low]), float(height[order][high])


def gradual_thickness(operators: Operators, thickness: Floats) -> Floats:
    """The largest field under the median-filtered thickness [mm] whose slope along edges is bounded (Persson 2006), shape [n].

    A measured thickness jumps, for example from a wall to the block it grows from; relief made from it would have cliffs.
    """
    values, count = thickness, len(thickness)
    centre = np.concatenate([operators.tail, operators.head, np.arange(count)])
    other = np.concatenate([operators.head, operators.tail, np.arange(count)])
    rising = np.argsort(values)
    rank = np.empty(count, np.int64)
    rank[rising] = np.arange(count)
    size = np.bincount(centre, minlength=count)
    first = np.concatenate([[0], np.cumsum(size)[:-1]])
    ranked = values[rising][np.sort(centre * np.int64(count) + rank[other]) % count]  # whole numbers sort several times as fast as pairs
    median = np.asarray(0.5 * (ranked[first + (size - 1) // 2] + ranked[first + size // 2]))
    return limited_slope(median, operators.mesh, _THICKNESS_SLOPE)
