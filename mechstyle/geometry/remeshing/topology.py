"""The connections of a closed surface: its edges with their faces, and edges drawn together, many at once, so that it stays one."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechstyle._warp import wp
from mechstyle.geometry.kernels import sound_collapses
from mechstyle.records.mesh import Bools, Floats, Indices

SCATTER = 2_654_435_761  # 2³² over the golden ratio: spreads equals that stand in a row, of which only the first could change in a round


class EdgePairs(NamedTuple):
    """The edges of a closed surface with their two faces."""

    edges: Indices  # vertices of each, directed as in its first face, shape [k, 2]
    faces: NDArray[np.int64]  # its two faces, shape [k, 2]
    across: Indices  # the third vertex of each of them, shape [k, 2]

    def some(self, which: NDArray[np.bool_]) -> EdgePairs:
        """Subset of the edges selected by `which`, shape [k]."""
        return EdgePairs(self.edges[which], self.faces[which], self.across[which])


def edges_of(faces: Indices) -> Indices:
    """The edges of a closed surface, each once, its lower vertex first: in one of its two faces it runs that way."""
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    return directed[directed[:, 0] < directed[:, 1]]


def edge_pairs(faces: Indices) -> EdgePairs:
    """The edges of a closed surface, each once."""
    directed = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    start, end = directed.T
    key = np.maximum(start, end) * (np.int64(faces.max()) + 1) + np.minimum(start, end)
    order = np.argsort(key, kind="stable")  # each edge is there twice, now side by side
    across = faces[:, [2, 0, 1]].reshape(-1)[order]
    return EdgePairs(directed[order][::2], (order // 3).reshape(-1, 2), across.reshape(-1, 2))


def edge_keys(pairs: Indices, count: int) -> NDArray[np.int64]:
    """A number for each unordered pair of so many vertices, in the order in which `edge_pairs` lists edges."""
    one, other = pairs.T
    return np.maximum(one, other).astype(np.int64) * count + np.minimum(one, other)


def among(wanted: NDArray[np.int64], there: NDArray[np.int64]) -> Bools:
    """Whether keys are among others, which ascend."""
    return there[np.minimum(np.searchsorted(there, wanted), len(there) - 1)] == wanted


def valid_collapses(vertices: Floats, faces: Indices, edges: Indices, meeting: Floats, *, longest: float, cosine: float) -> Bools:
    """Whether the ends of edges can meet: the surface stays one (the link condition), no edge gets too long, no triangle turns."""
    count, corners = len(vertices), faces.ravel()
    first = np.concatenate([[0], np.cumsum(np.bincount(corners, minlength=count))]).astype(np.int32)
    around = (np.argsort(corners, kind="stable") // 3).astype(np.int32)
    sound: Any = wp.empty(len(edges), dtype=wp.bool, device="cpu")
    given = [
        wp.array(edges, dtype=wp.vec2i, device="cpu"),
        wp.array(meeting, dtype=wp.vec3d, device="cpu"),
        wp.array(vertices, dtype=wp.vec3d, device="cpu"),
        wp.array(faces, dtype=wp.vec3i, device="cpu"),
        wp.array(first, dtype=wp.int32, device="cpu"),
        wp.array(around, dtype=wp.int32, device="cpu"),
    ]
    wp.launch(sound_collapses, dim=len(edges), inputs=[*given, longest, cosine, sound], device="cpu")
    return sound.numpy()


def far_apart(edges: Indices, urgency: NDArray[Any], faces: Indices, count: int) -> Bools:
    """Which edges come before all others within one triangle of them, so that they can collapse at once."""
    order = ranks(urgency)
    at_vertex = least(edges, np.repeat(order, 2), count, len(order))
    around = least(faces, np.repeat(at_vertex[faces].min(axis=1), 3), count, len(order))
    return around[edges].min(axis=1) == order


def merged(vertices: Floats, faces: Indices, stays: Indices, goes: Indices) -> tuple[Floats, Indices]:
    """The surface with vertices become others, their common triangles gone."""
    becomes = np.arange(len(vertices), dtype=np.int32)
    becomes[goes] = stays
    left = np.delete(np.arange(len(vertices)), goes)
    rank = np.empty(len(vertices), np.int32)
    rank[left] = np.arange(len(left), dtype=np.int32)
    named = becomes[faces]
    whole = (named != np.roll(named, 1, axis=1)).all(axis=1)
    return vertices[left], rank[named[whole]]


def ranks(urgency: NDArray[Any]) -> NDArray[np.int64]:
    """The place of each in ascending order, no two the same."""
    found = np.empty(len(urgency), np.int64)
    scattered = np.arange(len(urgency)) * SCATTER % 2**32
    found[np.lexsort((scattered, urgency))] = np.arange(len(urgency))
    return found


def least(owners: NDArray[np.integer], values: NDArray[np.int64], count: int, most: int) -> NDArray[np.int64]:
    """The least of the values that each of `count` owners has, `most` for one with none."""
    found = np.full(count, most, np.int64)
    np.minimum.at(found, owners.ravel(), values)
    return found
