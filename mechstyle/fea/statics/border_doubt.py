"""What coarse elements may hide where a support or load ends: on a short arm the stress one element away is much less than at the clamp.

The surface itself is read from 2 mm on beside such a border, `surface_stress.BORDER_REACH`; where elements are longer than that it is read
from the next vertex on. Cantilevers 15 to 24 mm long, of elements of 3 to 6 mm, read 82 to 65 where beam theory has 100 at the clamp. Going
on to the border as the stress rises from the second vertex to the first gives 91 to 99, on arms of three elements up to 131.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from mechstyle.fea.surface_stress import BORDER_REACH
from mechstyle.records.mesh import Bools, Floats, TetMesh

FROM, TO = 0.5, 1.5
"""Lengths of the elements from the border between which the first vertices lie, and from these as far the second."""


def heading_for(tets: TetMesh, border: Bools, field: Floats) -> float:
    """The stress that the surface heads for where supports and loads end [MPa]; 0 where elements are short enough to be read there.

    Args:
        tets: The body.
        border: Which vertices lie on the border of a support or load, shape [vertex_count].
        field: The stress that decides [MPa], shape [vertex_count].
    """
    outer = np.unique(tets.boundary_faces)
    coarse = border & (_edge_lengths(tets) > BORDER_REACH)
    if not coarse.any():
        return 0.0
    places, stress, length = tets.vertices[outer], field[outer], _edge_lengths(tets)[coarse]
    away, nearest = cKDTree(tets.vertices[coarse]).query(places)
    size = length[nearest]
    first = np.flatnonzero((away > FROM * size) & (away <= TO * size))
    around = cKDTree(places).query_ball_point(places[first], TO * size[first])
    found = [_going_on(int(spot), np.array(near), away, stress, size[spot]) for spot, near in zip(first, around, strict=True)]
    return float(max(found, default=0.0))


def _going_on(spot: int, near: np.ndarray, away: Floats, stress: Floats, size: float) -> float:
    """The stress at the border if it goes on rising as it does from what is beyond a spot to the spot [MPa]; beyond the end it is 0."""
    beyond = near[away[near] >= away[spot] + FROM * size]
    last = beyond[np.argmax(stress[beyond])] if len(beyond) else None
    way, rise = (size, stress[spot]) if last is None else (away[last] - away[spot], stress[spot] - stress[last])
    return float(stress[spot] + max(rise, 0.0) * away[spot] / way)


def _edge_lengths(tets: TetMesh) -> Floats:
    """Mean length of the boundary's edges at each vertex [mm], shape [vertex_count]; 0 inside."""
    faces, count = tets.boundary_faces, len(tets.vertices)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    lengths = np.linalg.norm(tets.vertices[edges[:, 0]] - tets.vertices[edges[:, 1]], axis=1)
    total, number = (np.bincount(edges.ravel(), np.repeat(what, 2), count) for what in (lengths, np.ones(len(edges))))
    return np.divide(total, number, out=np.zeros(count), where=number > 0.0)
