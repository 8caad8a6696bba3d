"""A surface in the colours of a few filaments, and what its print costs before any slicer has seen it.

Of a changer that feeds one nozzle. The changes are counted: a layer of n colours takes n − 1, and one more where it shares none with the
layer below.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.cluster.vq import kmeans2
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra

from mechstyle._colour import from_oklab, linear_to_srgb, oklab, srgb_to_linear
from mechstyle.errors import BadInput
from mechstyle.records.mesh import Bools, Floats, Indices, SurfaceMesh

MOST = 16
"""Most filaments: no slicer paints more in all of its versions."""
USUAL = 2
"""Filaments that are chosen unasked: one change a layer, where four of a changer's would make three."""
LINE = 0.42
"""Width of a line of plastic from a nozzle of 0.4 mm [mm]."""

Palette = tuple[str, ...]
"""Colours of filaments, `#RRGGBB`, that of filament 1 first."""


@dataclass(frozen=True, eq=False)
class Painted:
    """A surface in the colours of filaments."""

    mesh: SurfaceMesh  # the surface
    palette: Palette  # the filaments' colours
    filament: Indices  # place in the palette of each vertex, shape [vertex_count]
    merged: int = 0  # islands that were too small to print and went to their neighbours

    @property
    def shown(self) -> SurfaceMesh:
        """The surface as it looks in these colours; a border runs through the faces between two vertices."""
        return self.mesh.coloured(display(self.palette)[self.filament])


def palette_of(text: str | Sequence[str]) -> Palette:
    """A palette as people write it: "#111111, #f4f1e8, c0392b", or these one by one.

    Raises:
        BadInput: If a colour cannot be read or comes twice, or there are more than MOST.
    """
    given = text.split(",") if isinstance(text, str) else list(text)
    colours = []
    for one in given:
        if not re.fullmatch(r"#?[0-9a-fA-F]{6}", one.strip()):
            raise BadInput(f"{one.strip()!r} is no colour of a palette: write six hexadecimal digits, such as #c0392b, with commas between")
        colours.append("#" + one.strip().lstrip("#").upper())
    if twice := [one for one in colours if colours.count(one) > 1]:
        raise BadInput(f"{twice[0]} is twice in the palette: name each filament once")
    _check_count(len(colours))
    return tuple(colours)


def _check_count(count: int) -> None:
    if not 1 <= count <= MOST:
        raise BadInput(f"{count} colours: a palette has 1 to {MOST}, as many as the printer has filaments")


def code_of(colour: Sequence[float]) -> str:
    """`#RRGGBB` of a display RGB in [0, 1]."""
    return "#{:02X}{:02X}{:02X}".format(*(round(255.0 * channel) for channel in colour))


def display(palette: Palette) -> Floats:
    """Display RGB in [0, 1], shape [count, 3]."""
    return np.array([list(bytes.fromhex(colour[1:])) for colour in palette]) / 255.0


def clustered(colours: NDArray[np.floating], count: int = USUAL) -> Palette:
    """At most `count` colours, from 1 to MOST, that stand for those given, the one of most vertices first: k-means in Oklab, seeded.

    Args:
        colours: Display RGB, clipped to [0, 1], shape [n, 3].
        count: How many; colours that are no more than that are kept as they are.
    """
    _check_count(count)
    eight_bits = np.round(np.clip(colours, 0.0, 1.0) * 255.0).astype(np.uint8)
    label: NDArray[np.integer]
    names, label = np.unique(eight_bits.astype(np.int32) @ (1 << 16, 1 << 8, 1), return_inverse=True)  # rows are sorted ten times as slowly
    exact = np.stack([names >> 16, names >> 8 & 255, names & 255], axis=1).astype(np.uint8)
    if len(exact) > count:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a cluster that ran empty is a colour less, no fault
            centres, label = kmeans2(oklab(srgb_to_linear(eight_bits / 255.0)), count, iter=12, minit="++", seed=0, missing="warn")
        exact = np.round(linear_to_srgb(from_oklab(centres)) * 255.0).astype(np.uint8)
    codes = ["#{:02X}{:02X}{:02X}".format(*rgb) for rgb in exact]
    often = np.bincount(label.reshape(-1), minlength=len(exact))
    order = np.argsort(-often, kind="stable")
    return tuple(dict.fromkeys(codes[k] for k in order if often[k]))


def nearest(colours: NDArray[np.floating], palette: Palette) -> Indices:
    """Place in the palette of the colour that looks most like each, by distance in Oklab; display RGB, shape [n, 3]; gives [n]."""
    places = oklab(srgb_to_linear(np.clip(colours, 0.0, 1.0)))
    distance = [((places - filament) ** 2).sum(axis=1) for filament in oklab(srgb_to_linear(display(palette)))]
    return np.argmin(distance, axis=0).astype(np.int32)


def painted(mesh: SurfaceMesh, palette: Palette, *, line: float = LINE) -> Painted:
    """A coloured surface in the colours of filaments, without islands that are nowhere two lines wide: no nozzle draws them.

    `line` is the width of a line [mm]; with 0 every island stays. A surface without colours is all of filament 1.
    """
    if mesh.colours is None:
        return Painted(mesh, palette, np.zeros(len(mesh.vertices), np.int32))
    return merged(Painted(mesh, palette, nearest(mesh.colours, palette)), line)


def in_bands(mesh: SurfaceMesh, palette: Palette) -> Painted:
    """A surface with the filaments one above the other in bands of equal height: the fewest changes that show them all."""
    height = mesh.vertices[:, 2] - mesh.vertices[:, 2].min()
    band = np.floor(height / max(float(height.max()), 1e-9) * len(palette)).astype(np.int32)
    return Painted(mesh, palette, np.minimum(band, len(palette) - 1))


def merged(whole: Painted, line: float = LINE) -> Painted:
    """The same with islands that are nowhere two lines wide given to the nearest larger one along the surface."""
    mesh, filament, count = whole.mesh, whole.filament, len(whole.filament)
    (one, other), lengths = mesh.edges.T, np.linalg.norm(np.diff(mesh.vertices[mesh.edges], axis=1)[:, 0], axis=1)
    lengths = np.maximum(lengths, 1e-9)  # an edge of no length is an edge still, which a stored zero would not be
    alike = filament[one] == filament[other]
    inside = coo_array((lengths[alike], (one[alike], other[alike])), shape=(count, count)).tocsr()
    islands, island = connected_components(inside, directed=False)
    # Distance of each vertex along the edges of its island from where other colours begin, half-way along an edge; infinite if nowhere.
    border = np.full(count, np.inf)
    np.minimum.at(border, mesh.edges[~alike].ravel(), np.repeat(0.5 * lengths[~alike], 2))
    start, edges = np.flatnonzero(np.isfinite(border)), inside.tocoo()
    rows, columns = np.concatenate([edges.row, start]), np.concatenate([edges.col, np.full(len(start), count)])
    graph = coo_array((np.concatenate([edges.data, border[start]]), (rows, columns)), shape=(count + 1, count + 1)).tocsr()
    widest = np.zeros(islands)
    np.maximum.at(widest, island, dijkstra(graph, directed=False, indices=count)[:count])
    small = widest[island] < line
    if not small.any() or small.all():
        return whole
    links = coo_array((lengths, (one, other)), shape=(count, count)).tocsr()
    _, _, source = dijkstra(links, directed=False, indices=np.flatnonzero(~small), min_only=True, return_predecessors=True)
    taken = np.where(small & (source >= 0), filament[np.maximum(source, 0)], filament)
    return Painted(mesh, whole.palette, taken.astype(np.int32), whole.merged + int((widest < line).sum()))


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
    """An estimate of a print."""

    palette: tuple[str, ...]  # filaments that are used
    layers: int  # how many
    changes: int  # changes of filament
    purged: tuple[float, float]  # least and most plastic purged with them [mm³]

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
    changes, used = changes_of(shown), np.flatnonzero(shown.any(axis=0))
    purged = (changes * PURGED[0], changes * PURGED[1])
    return PrintCost(palette=tuple(paint.palette[place] for place in used), layers=len(shown), changes=changes, purged=purged)


def colours_by_layer(paint: Painted, layer: float = LAYER) -> Bools:
    """Which filaments each layer shows, from the lowest, shape [layer_count, palette_size].

    A slicer cuts a layer at its middle, and paints all solid layers of floors and tops as what looks up or down there.
    """
    mesh, top = paint.mesh, float(np.ptp(paint.mesh.vertices[:, 2]))
    count = max(int(np.ceil(top / layer - 1e-6)), 1)
    middles = np.minimum((np.arange(count) + 0.5) * layer, 0.5 * (top + (count - 1) * layer))
    looks = mesh.face_normals[:, 2]
    begun = np.zeros((count + 1, len(paint.palette)), dtype=np.int64)
    up, down = (mesh.faces[tilted][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2) for tilted in (looks > TILT, looks < -TILT))  # edges
    for edges, beneath, over in ((mesh.edges, 0, 0), (up, TOPS, 0), (down, 0, FLOORS)):
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


def changes_of(shown: Bools) -> int:
    """Changes for the colours of each layer, shape [layer_count, palette_size]: a layer begins with what the one below ended with."""
    within = int(np.maximum(shown.sum(axis=1) - 1, 0).sum())
    return within + sum(not (below & above).any() for below, above in pairwise(shown))


def cheaper(paint: Painted, layer: float = LAYER) -> list[PrintCost]:
    """What the part would cost with fewer of its filaments, in layers of a height [mm].

    Down to one, leaving out the one that saves most changes each time.
    """
    offers, now = [], paint
    while (used := np.unique(now.filament)).size > 1:
        now = min((_without(now, int(one)) for one in used), key=lambda other: changes_of(colours_by_layer(other, layer)))
        offers.append(print_cost(now, layer))
    return offers


def banded(paint: Painted, layer: float = LAYER) -> PrintCost:
    """What the part would cost with its filaments in bands one above the other, in layers of a height [mm]."""
    return print_cost(in_bands(paint.mesh, paint.palette), layer)


def _without(paint: Painted, left_out: int) -> Painted:
    """The part without one of its filaments: what was of that one is of the one that looks most like it."""
    used = np.unique(paint.filament)
    others = tuple(paint.palette[place] for place in used if place != left_out)
    return Painted(paint.mesh, others, nearest(display(paint.palette), others)[paint.filament], paint.merged)
