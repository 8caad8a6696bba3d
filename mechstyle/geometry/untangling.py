"""A relief lowered where the surface would pass through itself: in inner corners, and at edges that are cut into from both sides."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from mechstyle.geometry.going_on import GoOn, regardless
from mechstyle.geometry.print_quality import turned_over
from mechstyle.geometry.self_intersections import crossings
from mechstyle.records.mesh import Bools, Field, SurfaceMesh

ROUNDS = 20
"""Times it is looked for crossings; a towel hook in brick needed five, of 200 000 faces and 2138 crossings."""
TAKEN = 0.25
"""Share of the relief that is taken in a round from vertices of faces that cross."""
SPREAD = 2
"""How many edges around them some is taken, ever less, so that the relief has no step there."""


def untangled(surface: SurfaceMesh, relief: Field, go_on: GoOn = regardless) -> Field:
    """A relief [mm], shape [vertex_count], less what makes faces cross or turn over; as it is if none do.

    Faces that cross in the unstylized surface stay as they are, and those left after `ROUNDS` rounds.

    Args:
        surface: The unstylized surface.
        relief: Along its vertex normals [mm], shape [vertex_count].
        go_on: Asked before each round; what it raises ends the work.
    """
    share, near, crossed = np.ones(len(relief), np.float32), None, crossings(surface).other >= 0
    for _ in range(ROUNDS):
        go_on()
        tangled = _tangled(surface, relief * share, crossed)
        if not tangled.any():
            break
        near = _means(surface) if near is None else near
        taken = np.zeros(len(relief), np.float32)
        taken[surface.faces[tangled]] = TAKEN
        for _ in range(SPREAD):
            taken = np.maximum(taken, near @ taken)
        share *= 1.0 - taken
    return np.asarray(relief * share, np.float32)


def _tangled(surface: SurfaceMesh, relief: Field, crossed: Bools) -> Bools:
    """Faces that cross others, or turn over, and did not before, shape [face_count]."""
    styled = surface.displaced(relief)
    other = np.where(crossed, -1, crossings(styled).other)
    tangled = turned_over(surface, styled) | (other >= 0)
    tangled[other[other >= 0]] = True
    return tangled


def _means(surface: SurfaceMesh) -> Any:
    """Takes the mean over a vertex and those next to it, sparse, shape [vertex_count, vertex_count]."""
    count, ends = len(surface.vertices), surface.edges
    joined: NDArray[np.int64] = np.concatenate([ends, ends[:, ::-1], np.repeat(np.arange(count)[:, None], 2, axis=1)])
    ones = sp.coo_array((np.ones(len(joined), np.float32), (joined[:, 0], joined[:, 1])), shape=(count, count)).tocsr()
    return sp.diags_array(1.0 / ones.sum(axis=1)) @ ones
