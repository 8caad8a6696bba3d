"""The measure of every verdict: σ_V, the stress that more than a volume V0 of a part exceed.

A largest stress has no meaning where contact is a point or a corner is sharp: it grows with every finer mesh. The stress that a given
volume exceeds does not: a singular peak holds no volume (the stressed-volume methods of fatigue: Kuguel 1961; Sonsino and Fischer 2005).
V0 is a cube of 4 mm in a fall, where edges that meet the floor are such peaks, and of 2 mm under a load, which acts for years.

Stress is linear in each tetrahedron between its values at the corners, the volume-weighted means over all tetrahedra there. A plate of
thickness t in bending reads 1 − √(V0 / (A t)) of its fibre stress over an area A. In walls thinner than THIN a volume counts (THIN / t)³
times: without it a rod of 1 mm read a load factor of 3.2, beyond its plastic hinge at 1.7.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from mechstyle.records.mesh import Floats, TetMesh
from mechstyle.records.simulation import Place

LOADED = 2.0
"""Edge of the cube V0 under a load [mm]: what is bent for good has to be as large as that to matter."""
DROPPED = 4.0
"""Edge of the cube V0 in a fall [mm]."""
THIN = 4.0
"""Thickness below which V0 shrinks with the wall [mm]: to a cube of the wall in a fall, of half of it under a load."""

STEPS = 50
"""Bisections of the stress: enough for single precision."""

APART = 1e-6
"""Least difference between the corner values of a tetrahedron, over the largest: the volume above a level divides by it."""


class Exceeded(NamedTuple):
    """A stress that a volume exceeds, σ_V [MPa], and the centre of that volume [mm]."""

    stress: float
    where: Place


@dataclass(frozen=True, eq=False)
class Walls:
    """Wall thickness [mm], shape [n], at points of a part [mm], shape [n, 3], by which small volumes of thin members count."""

    points: Floats
    thickness: NDArray[np.floating]

    def weights(self, tets: TetMesh) -> Floats:
        """Factor on the volume of each tetrahedron, max(1, (THIN / t)³) with the nearest wall's t, shape [tet_count]."""
        _, nearest = cKDTree(self.points).query(tets.vertices[tets.tets].mean(axis=1))
        return np.asarray(np.maximum(THIN / np.maximum(self.thickness[nearest], 1e-3), 1.0) ** 3)


def at_nodes(tets: TetMesh, corners: ArrayLike) -> Floats:
    """Volume-weighted mean at each vertex, shape [vertex_count], of the stress at corners of tetrahedra [MPa], shape [tet_count, 4]."""
    volumes, count = np.repeat(tets.volumes, 4), len(tets.vertices)
    nodes, values = tets.tets.ravel(), np.asarray(corners, np.float64).ravel()
    weights = np.bincount(nodes, volumes, count)
    return np.bincount(nodes, volumes * values, count) / np.where(weights > 0.0, weights, 1.0)


def exceeded(tets: TetMesh, nodal: ArrayLike, weights: Floats | float, volume: float) -> Exceeded:
    """σ_V of a stress that is linear in each tetrahedron; the smallest stress if the part has no more than V0, `volume` [mm³].

    `nodal` is the stress at its vertices [MPa], shape [vertex_count], `weights` a factor on the volume of each tetrahedron.
    """
    values = np.sort(np.asarray(nodal, np.float64)[tets.tets], axis=1)
    if not np.isfinite(values).all():
        return Exceeded(float("nan"), (0.0, 0.0, 0.0))
    volumes: Floats = tets.volumes * weights
    low, high = float(values.min()), float(values.max())
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        reached = values[:, 3] > middle
        more = float((volumes[reached] * share_above(values[reached], middle)).sum()) > volume
        low, high = (middle, high) if more else (low, middle)
    there = values[:, 3] >= low
    held = volumes[there] * share_above(values[there], low)
    centre = np.average(tets.vertices[tets.tets[there]].mean(axis=1), axis=0, weights=held if held.sum() > 0.0 else None)
    x, y, z = centre
    return Exceeded(high, (float(x), float(y), float(z)))


def share_above(values: Floats, level: float) -> Floats:
    """Share of each tetrahedron in which a linear field is above a level, shape [n], by its values at the corners, ascending, shape [n, 4].

    The share below is the divided difference of (level − f)₊³ over the corner values f (Curry and Schoenberg 1966).
    """
    gap = APART * np.maximum(np.abs(values).max(axis=1, keepdims=True, initial=0.0), 1e-30) * np.arange(4)
    apart = np.maximum.accumulate(values - gap, axis=1) + gap
    a, b, c, d = apart.T
    below, above = level <= a, level >= d
    first = np.clip(level - a, 0.0, None) ** 3 / ((b - a) * (c - a) * (d - a))
    second = np.clip(level - b, 0.0, None) ** 3 / ((b - a) * (c - b) * (d - b))
    last = np.clip(d - level, 0.0, None) ** 3 / ((d - a) * (d - b) * (d - c))
    share: NDArray[np.float64] = np.where(level < c, 1.0 - first + second, last)
    return np.where(below, 1.0, np.where(above, 0.0, np.clip(share, 0.0, 1.0)))
