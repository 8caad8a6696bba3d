"""What a print costs, estimated before any slicer has seen it: changes of filament, and the volume they purge.

Of a changer that feeds one nozzle. The changes are counted: a layer of n colours takes n − 1, and one more where it shares none with the
layer below.
"""

from __future__ import annotations

from itertools import pairwise

import msgspec
import numpy as np

from mechstyle.geometry.filaments import Painted, display, in_bands, nearest
from mechstyle.records.mesh import Bools, Floats, Indices

LAYER = 0.2
"""Height of a layer [mm]."""
PURGED = (107.0, 400.0)
"""Least and most plastic purged with a change of filament by an AMS [mm³] (forum.bambulab.com, thread 10037)."""
FLOORS, TOPS = 3, 4
"""Layers that PrusaSlicer paints as what looks down, and as what looks up: at a top one more than are solid (seen in its G-code)."""
TILT = 0.6
"""Slope |n_z| from which a face is a floor or a top: a layer then stands out by 0.15 mm, a third of a line. Of 0.4 to 0.8, with 0.6
and 0.65 changes in bands on eight parts come nearest to PrusaSlicer's."""


class PrintCost(msgspec.Struct, frozen=True, kw_only=True):
    """An estimate of a print.

    Attributes:
        palette: Filaments that are used.
        layers: How many.
        changes: Changes of filament.
        purged: Least and most plastic purged with them [mm³].
    """

    palette: tuple[str, ...]
    layers: int
    changes: int
    purged: tuple[float, float]

    @property
    def words(self) -> str:
        """The estimate in one sentence."""
        if not self.changes:
            return f"no change of filament in {self.layers} layers"
        purged = " to ".join(f"{volume / 1e3:.0f}" for volume in self.purged)
        return f"{self.changes} changes of filament in {self.layers} layers, {purged} cm³ purged"


def print_cost(paint: Painted, layer: float = LAYER) -> PrintCost:
    """What a painted part costs to print as it stands, in layers of a height [mm]."""
    shown = colours_by_layer(paint, layer)
    changes = changes_of(shown)
    return PrintCost(
        palette=tuple(colour for colour, used in zip(paint.palette, np.asarray(shown.any(axis=0)), strict=True) if used),
        layers=len(shown),
        changes=changes,
        purged=(changes * PURGED[0], changes * PURGED[1]),
    )


def colours_by_layer(paint: Painted, layer: float = LAYER) -> Bools:
    """Which filaments each layer shows, from the lowest, shape [layer_count, palette_size].

    A slicer cuts a layer at its middle, and paints all solid layers of floors and tops as what looks up or down there.
    """
    mesh, top = paint.mesh, float(np.ptp(paint.mesh.vertices[:, 2]))
    count = max(int(np.ceil(top / layer - 1e-6)), 1)
    middles = np.minimum((np.arange(count) + 0.5) * layer, 0.5 * (top + (count - 1) * layer))
    looks = mesh.face_normals[:, 2]
    begun = np.zeros((count + 1, len(paint.palette)), dtype=np.int64)
    for edges, beneath, over in (
        (mesh.edges, 0, 0),
        (_sides(mesh.faces[looks > TILT]), TOPS, 0),
        (_sides(mesh.faces[looks < -TILT]), 0, FLOORS),
    ):
        colour, low, high = _halves(paint, edges)
        first = np.searchsorted(middles, low, "right" if beneath else "left") - beneath
        last = np.searchsorted(middles, high, "left" if over else "right") + over - 1
        shown = first <= last
        np.add.at(begun, (np.maximum(first, 0)[shown], colour[shown]), 1)
        np.add.at(begun, (np.minimum(last + 1, count)[shown], colour[shown]), -1)
    return np.asarray(begun.cumsum(axis=0)[:-1] > 0)


def _halves(paint: Painted, edges: Indices) -> tuple[Indices, Floats, Floats]:
    """Filament of each half of some edges, and its lowest and highest place over the part's lowest [mm]; all of an edge of one filament."""
    height = paint.mesh.vertices[:, 2] - paint.mesh.vertices[:, 2].min()
    one, other = np.concatenate([edges, edges[:, ::-1]]).T
    end = np.where(paint.filament[one] == paint.filament[other], height[other], 0.5 * (height[one] + height[other]))
    return paint.filament[one], np.minimum(height[one], end), np.maximum(height[one], end)


def _sides(faces: Indices) -> Indices:
    """The edges of some faces, shape [3 face_count, 2]."""
    return faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)


def changes_of(shown: Bools) -> int:
    """Changes for the colours of each layer, shape [layer_count, palette_size]: a layer begins with what the one below ended with."""
    within = int(np.maximum(shown.sum(axis=1) - 1, 0).sum())
    return within + sum(not (below & above).any() for below, above in pairwise(shown))


def cheaper(paint: Painted, layer: float = LAYER) -> list[PrintCost]:
    """What the part would cost with fewer of its filaments, down to one, leaving out the one that saves most changes each time."""
    offers, now = [], paint
    while (used := np.unique(now.filament)).size > 1:
        now = min((_without(now, int(one)) for one in used), key=lambda other: changes_of(colours_by_layer(other, layer)))
        offers.append(print_cost(now, layer))
    return offers


def banded(paint: Painted, layer: float = LAYER) -> PrintCost:
    """What the part would cost with its filaments in bands one above the other."""
    return print_cost(in_bands(paint.mesh, paint.palette), layer)


def _without(paint: Painted, left_out: int) -> Painted:
    """The part without one of its filaments: what was of that one is of the one that looks most like it."""
    used = np.unique(paint.filament)
    others = tuple(paint.palette[place] for place in used if place != left_out)
    return Painted(paint.mesh, others, nearest(display(paint.palette), others)[paint.filament], paint.merged)
