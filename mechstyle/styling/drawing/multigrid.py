"""Equations of two numbers a vertex on a surface, solved on a few thousand of its vertices and brought from there to all of them.

A vector at a vertex is compared with its neighbours' after each was turned, or mirrored, on the way along the edge. So it is interpolated:
from those vertices that stay, each turned as the matrix has it, by the weights that this has (algebraic multigrid: Brandt,
McCormick and Ruge 1984). Waves much shorter than the distance of the vertices that stay are carried by the turns.
"""

from __future__ import annotations

import warnings

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, cg, lobpcg, splu

from mechstyle.records.mesh import Bools, Floats

FEWEST = 8_000
"""Vertices for which a system is solved as it is."""
STEPS, LOWEST_STEPS = 12, 20
"""Steps of conjugate gradients on all vertices towards a solution, and towards a lowest wave, each with one cycle through the grids …"""
SWEEPS, DAMPING = 2, 0.6
"""… and with so many steps of damped Jacobi on each on the way down, and on the way up."""
STRONG = 0.25
"""A vertex is interpolated from those it is linked to with at least so much of the strongest link of either (Ruge and Stüben 1987)."""
_CONVERGED = 1e-6  # of a wave of mass one, what is left of its equation: lobpcg's own would be 1.5e-8 times the size of the matrix
_SCATTER = 2_654_435_761


class Grids:
    """A symmetric positive matrix of two numbers a vertex on its grids, the finest first; shape [2 n, 2 n], both numbers n rows apart."""

    def __init__(self, matrix: sp.csr_array) -> None:
        self.matrices, self._interpolations = [matrix], list[sp.csr_array]()
        while self.matrices[-1].shape[0] > 2 * FEWEST:
            self._interpolations.append(interpolation(self.matrices[-1]))
            self.matrices.append(sp.csr_array(self._interpolations[-1].T @ self.matrices[-1] @ self._interpolations[-1]))
        options = {"SymmetricMode": True}
        self._coarsest = splu(sp.csc_array(self.matrices[-1]), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)

    def solved(self, right: Floats) -> Floats:
        """About the solution for a right-hand side, shape [2 n]."""
        return np.asarray(cg(self.matrices[0], right, maxiter=STEPS, M=self._inverse)[0])

    def lowest(self, mass: Floats, start: Floats, iterations: int) -> Floats:
        """About the eigenvector of the least eigenvalue, by inverse iteration from a start; masses and start have shape [2 n]."""
        masses, right = sp.csr_array(sp.diags_array(mass)), mass * start
        inertia = masses
        for matrix in self._interpolations:
            masses, right = sp.csr_array(matrix.T @ masses @ matrix), matrix.T @ right
        for _ in range(iterations):
            found = self._coarsest.solve(right)
            found /= np.sqrt(found @ (masses @ found))
            right = masses @ found
        if not self._interpolations:
            return np.asarray(found)
        for matrix in reversed(self._interpolations):
            found = matrix @ found
        with warnings.catch_warnings(action="ignore"):  # it warns where the steps have ended first
            options = {"largest": False, "maxiter": LOWEST_STEPS, "tol": _CONVERGED}
            near = lobpcg(self.matrices[0], found[:, None], B=inertia, M=self._inverse, **options)[1]
        return np.asarray(near[:, 0])

    @property
    def _inverse(self) -> LinearOperator:
        return LinearOperator(self.matrices[0].shape, matvec=lambda right: self._cycle(right.ravel()), dtype=np.float64)

    def _cycle(self, right: Floats, level: int = 0) -> Floats:
        """About the inverse of the matrix of a grid times a vector."""
        if level == len(self._interpolations):
            return np.asarray(self._coarsest.solve(right))
        matrix, finer = self.matrices[level], self._interpolations[level]
        step = DAMPING / matrix.diagonal()
        found = step * right
        for _ in range(SWEEPS - 1):
            found += step * (right - matrix @ found)
        found += finer @ self._cycle(finer.T @ (right - matrix @ found), level + 1)
        for _ in range(SWEEPS):
            found += step * (right - matrix @ found)
        return found


def interpolation(matrix: sp.csr_array) -> sp.csr_array:
    """From the vertices of a system that stay on the next grid to all of them, shape [2 n, 2 m]."""
    count, entries = matrix.shape[0] // 2, matrix.tocoo()
    one, other = entries.row % count, entries.col % count
    apart = one != other
    links = sp.csr_array((entries.data[apart] ** 2, (one[apart], other[apart])), shape=(count, count))
    links.data = np.sqrt(0.5 * links.data)  # of a rotation times a weight, that weight
    firm = strong(links)
    stays = independent(firm)
    place, left = np.cumsum(stays) - 1, int(stays.sum())
    weight = firm @ stays.astype(np.float64)
    kept = np.flatnonzero(apart & ~stays[one] & stays[other])
    kept = kept[np.asarray(firm[one[kept], other[kept]]).ravel() > 0.0]
    there = np.flatnonzero(stays)
    rows = np.concatenate([entries.row[kept], there, there + count])
    columns = np.concatenate([place[other[kept]] + left * (entries.col[kept] // count), place[there], place[there] + left])
    values = np.concatenate([-entries.data[kept] / weight[one[kept]], np.ones(2 * left)])
    return sp.csr_array((values, (rows, columns)), shape=(2 * count, 2 * left))


def strong(links: sp.csr_array) -> sp.csr_array:
    """The links [n, n] that matter: where some hold far less than others, a wave bends freely across these."""
    strongest, pairs = links.max(axis=1).toarray().ravel(), links.tocoo()
    kept = pairs.data >= STRONG * np.minimum(strongest[pairs.row], strongest[pairs.col])
    return sp.csr_array((pairs.data[kept], (pairs.row[kept], pairs.col[kept])), shape=links.shape)


def independent(links: sp.csr_array) -> Bools:
    """Vertices no two of which are linked, and one of which every other is linked to, shape [n] (Luby 1986, with fixed ranks)."""
    count, (one, other) = links.shape[0], links.nonzero()
    rank: NDArray[np.int64] = np.empty(count, np.int64)
    rank[np.argsort(np.arange(count) * _SCATTER % 2**32, kind="stable")] = np.arange(count)
    stays, open_ = np.zeros(count, bool), np.ones(count, bool)
    while open_.any():
        first = np.full(count, count)
        near = open_[one] & open_[other]
        np.minimum.at(first, one[near], rank[other[near]])
        chosen = open_ & (rank < first)
        stays |= chosen
        open_ &= ~chosen
        open_[one[chosen[other]]] = False
    return stays
