"""How long a printer lays plastic, as a slicer plans it: walls around each region of one colour, solid floors and tops, infill, and moves.

Speeds and widths are those PrusaSlicer 2.5 has unless told, with layers of 0.2 mm and a nozzle of 0.4 mm. A printer paints inwards from the
surface: what lies inside a layer takes the colour of the nearest place of its outline, as in a Voronoi diagram, and every region of one
colour gets walls all around, also where it meets the next. That, besides changes of filament, is what makes colours slow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import QhullError, Voronoi

from mechstyle.records.mesh import Bools, Floats, Indices, SurfaceMesh

WIDTH = 0.45
"""Width of a line [mm]: 1.125 nozzles."""
SPEEDS = np.array([30.0, 60.0, 60.0])
"""Speeds of the walls, the outermost first [mm/s]."""
SMALL, SLOW = 2.0 * np.pi * 6.5, 15.0
"""Walls shorter than this [mm] are printed at this speed [mm/s]."""
SOLID, SPARSE = 20.0, 80.0
"""Speeds of solid filling and of infill [mm/s] …"""
DENSITY, SOLIDS = 0.2, 3
"""… share of plastic in infill, and solid layers of a floor or a top."""
COOL = 5.0
"""Least time for a layer [s]."""
CURVES = 1.3
"""Factor on walls for slowing down in bends: 1.0 to 1.4 in the G-code of four parts, the more the finer their relief …"""
MOVE = 0.1
"""… and time to retract and go to the next wall [s], measured in the same."""
SAMPLED = 32
"""Layers looked at, evenly chosen."""
GRID, ASIDE, FLAT = 0.2, 0.05, 0.9
"""Steps between places of an outline, how far they stand to both sides of it [mm], and slope |n_z| of painted floors and tops."""


@dataclass(frozen=True, eq=False)
class _Layer:
    """Places of a layer that have a colour, those around it that have none, and the borders between the cells of any two.

    Attributes:
        corners: Vertices of the surface by which each coloured place has its colour, shape [place_count, 3].
        cells: The two cells of each border, shape [border_count, 2]; from place_count on they lie outside.
        length: Length of each border [mm].
        apart: Distance of its two places [mm].
        area: Area of the layer [mm²].
    """

    corners: Indices
    cells: Indices
    length: Floats
    apart: Floats
    area: float

    def regions(self, filament: Indices) -> tuple[Floats, Floats]:
        """Length around each region of one colour [mm], and its area [mm²]."""
        one, other, last = filament[self.corners].T
        inside = len(one)
        colour = np.full(max(inside, int(self.cells.max(initial=-1)) + 1), -1)
        colour[:inside] = np.where(other == last, other, one)
        meets = colour[self.cells[:, 0]] == colour[self.cells[:, 1]]
        graph = coo_array((np.ones(np.count_nonzero(meets)), self.cells[meets].T), shape=(len(colour), len(colour)))
        count, region = connected_components(graph, directed=False)
        around, area = np.zeros(count), np.zeros(count)
        for side in self.cells.T:
            around += np.bincount(region[side[~meets]], self.length[~meets], count)
            area += np.bincount(region[side], 0.25 * self.length * self.apart, count)  # a triangle from the place to the border
        kept = np.unique(region[:inside])
        return around[kept], area[kept] * min(1.0, self.area / max(float(area[kept].sum()), 1e-9))


@dataclass(frozen=True, eq=False)
class Slices:
    """A part in layers, of which some were looked at.

    Attributes:
        sampled: Those.
        count: How many there are.
        height: Height of a layer [mm].
        solid: Area of solid layers [mm²]: SOLIDS under all floors and tops, up to the outline, as they are filled beyond their place.
    """

    sampled: tuple[_Layer, ...]
    count: int
    height: float
    solid: float

    @classmethod
    def of(cls, mesh: SurfaceMesh, height: float) -> Slices:
        """A closed surface [mm] as it stands, in layers of a height [mm]."""
        low, high = float(mesh.vertices[:, 2].min()), float(mesh.vertices[:, 2].max())
        count = max(int(np.ceil((high - low) / height - 1e-6)), 1)
        chosen = np.unique(np.linspace(0, count - 1, min(count, SAMPLED)).round())
        middles = np.minimum(low + (chosen + 0.5) * height, 0.5 * (high + low + (count - 1) * height))
        flat = float(mesh.face_areas @ np.abs(mesh.face_normals[:, 2]))
        return cls(tuple(_cut(mesh, float(z), height) for z in middles), count, height, SOLIDS * flat)

    def seconds(self, filament: Indices) -> float:
        """Seconds to lay the plastic if each vertex is of a filament, shape [vertex_count]; changes of filament apart."""
        spacing = WIDTH - self.height * (1.0 - 0.25 * np.pi)
        found = [_walls(*layer.regions(filament), spacing) for layer in self.sampled]
        walls, loops, rest = np.sum(found, axis=0) * self.count / len(found)
        solid = min(self.solid, rest)
        filling = solid / SOLID + (rest - solid) * DENSITY / SPARSE
        return float(max(CURVES * walls + MOVE * loops + filling / spacing, COOL * self.count))


def _walls(around: Floats, area: Floats, spacing: float) -> tuple[float, float, float]:
    """Seconds that the walls of regions take, how many there are, and the area within [mm²]; without room they are shorter."""
    loops = np.maximum(around[:, None] - 2.0 * np.pi * spacing * (np.arange(len(SPEEDS)) + 0.5), 0.0)
    room = np.minimum(1.0, area / np.maximum(loops.sum(axis=1) * spacing, 1e-9))
    taken = loops / np.where(loops[:, :1] < SMALL, SLOW, SPEEDS)
    inside = area - room * loops.sum(axis=1) * spacing
    return float(taken.sum(axis=1) @ room), float(np.count_nonzero(loops)), float(inside.sum())


def _cut(mesh: SurfaceMesh, z: float, height: float) -> _Layer:
    """The layer at a height [mm]."""
    corners, place, outwards, shared, area = _outline(mesh, z)
    near = np.flatnonzero(_painted_flat(mesh, z, height))
    near = near[_thinned(mesh.vertices[near, :2], np.zeros(len(near)), 2.0 * GRID)]
    places = np.concatenate([place - ASIDE * outwards, mesh.vertices[near, :2], (place + ASIDE * outwards)[~shared]])
    cells, length, apart = _borders(places)
    return _Layer(np.concatenate([corners, np.repeat(near[:, None], 3, axis=1)]), cells, length, apart, area)


def _outline(mesh: SurfaceMesh, z: float) -> tuple[Indices, Floats, Floats, Bools, float]:
    """Faces that a plane cuts, the middles of the cuts, the ways out there, whether two bodies meet there, and the area within [mm²]."""
    above = (mesh.vertices[:, 2] > z)[mesh.faces]
    cut = above.any(axis=1) & ~above.all(axis=1)
    corners, above = mesh.faces[cut], above[cut]
    alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    apex, one, other = (corners[np.arange(len(corners)), (alone + k) % 3] for k in range(3))
    start, end = (_crossing(mesh.vertices, apex, far, z) for far in (one, other))
    outwards = mesh.face_normals[cut, :2] / np.maximum(np.linalg.norm(mesh.face_normals[cut, :2], axis=1, keepdims=True), 1e-12)
    middle = 0.5 * (start + end)
    area = 0.5 * float(np.einsum("ij,ij->i", middle, outwards) @ np.linalg.norm(end - start, axis=1))
    _, where, times = np.unique(np.round(middle, 5), axis=0, return_inverse=True, return_counts=True)
    kept = _thinned(middle, np.round(np.arctan2(*outwards.T)), GRID)  # both sides of a thin wall
    return corners[kept], middle[kept], outwards[kept], times[where.ravel()][kept] > 1, area


def _crossing(vertices: Floats, one: Indices, other: Indices, z: float) -> Floats:
    """Where edges pass a height [mm], shape [k, 2]."""
    start, end = vertices[one], vertices[other]
    share = (z - start[:, 2]) / (end[:, 2] - start[:, 2])
    return np.asarray(start[:, :2] + share[:, None] * (end - start)[:, :2])


def _painted_flat(mesh: SurfaceMesh, z: float, height: float) -> Bools:
    """Whether a layer is within the floor or the top that a vertex is on, and so takes its colour, shape [vertex_count]."""
    above, looks = mesh.vertices[:, 2] - z, mesh.vertex_normals[:, 2]
    return (np.abs(above) < SOLIDS * height) & (np.abs(looks) > FLAT) & (above * looks > 0.0)


def _thinned(points: Floats, kind: Floats, step: float) -> Indices:
    """Indices of the first point of each kind in each square of a grid."""
    return np.unique(np.column_stack([np.round(points / step), kind]), axis=0, return_index=True)[1].astype(np.int32)


def _borders(places: Floats) -> tuple[Indices, Floats, Floats]:
    """Borders between the cells of places (Voronoi): the two places, the border's length, and their distance [mm]."""
    try:
        cells = Voronoi(places)
    except (QhullError, ValueError):  # hardly a place, or all on one line
        return np.zeros((0, 2), np.int32), np.zeros(0), np.zeros(0)
    ends = np.array([border[:2] for border in cells.ridge_vertices])
    closed = (ends >= 0).all(axis=1)
    pairs, ends = cells.ridge_points[closed], ends[closed]
    length, apart = (np.linalg.norm(of[two[:, 0]] - of[two[:, 1]], axis=1) for of, two in ((cells.vertices, ends), (places, pairs)))
    return pairs.astype(np.int32), length, apart
