"""A preconditioner for stiffness matrices of quadratic tetrahedra, whose factors take minutes where this takes a second.

The linear fields among the quadratic ones have a seventh of the unknowns, and for them the equations are solved directly; what they cannot
show varies from node to node, and some steps of a Chebyshev iteration take it away (Rønquist and Patera 1987; Adams et al. 2003). For
linear tetrahedra it is a direct solver.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, coo_array, csr_array, eye_array, kron
from scipy.sparse.linalg import splu

from mechstyle.errors import SimulationFailed
from mechstyle.fea.elements import EDGES
from mechstyle.records.mesh import Floats, Indices

Singles = NDArray[np.float32]

SMOOTHING = 3
"""Chebyshev steps before the linear fields are solved for, and after …"""
UPPER_PART = 8.0
"""… which take away what lies in the spectrum of D⁻¹A between its upper end and this part of it; D is the diagonal."""
PRODUCTS, MARGIN = 15, 1.1
"""Products with D⁻¹A to find that end, and by how much it is taken to be higher."""


def linear_fields(connectivity: Indices, node_count: int) -> csr_array:
    """Nodal values of the fields that are linear in each tetrahedron, from those at its corners, shape [3 node_count, 3 corner_count].

    Args:
        connectivity: Nodes of each tetrahedron, shape [tet_count, nodes].
        node_count: Nodes.
    """
    corners, number = np.unique(connectivity[:, :4], return_inverse=True)
    rows, columns, values = [corners], [np.arange(len(corners))], [np.ones(len(corners))]
    middles, first = np.unique(connectivity[:, 4:], return_index=True)
    if len(middles):
        tet, edge = np.divmod(first, len(EDGES))
        ends = number.reshape(-1, 4)[tet[:, None], np.array(EDGES)[edge]]
        rows, columns = [corners, np.repeat(middles, 2)], [np.arange(len(corners)), ends.ravel()]
        values.append(np.full(2 * len(middles), 0.5))
    shape = (node_count, len(corners))
    interpolation = coo_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape)
    return csr_array(kron(interpolation, eye_array(3), format="csr"))


class TwoLevel:
    """An approximate inverse of a symmetric positive (semi-)definite matrix; symmetric and positive definite itself.

    Args:
        matrix: A, shape [n, n].
        fields: The linear fields, shape [n, m].
        shift: Added to A where it is solved for the linear fields, so that a singular one can be.

    Raises:
        SimulationFailed: If that matrix cannot be factorised.
    """

    def __init__(self, matrix: bsr_array, fields: csr_array, shift: float = 0.0) -> None:
        self._matrix, self._fields = matrix.astype(np.float32), fields.astype(np.float32)  # what is about right may be rounded
        coarse = (fields.T @ (matrix.tocsr() @ fields) + shift * (fields.T @ fields)).tocsc()
        try:
            self._factor = splu(coarse, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except (RuntimeError, MemoryError) as error:
            raise SimulationFailed(f"the equations of the part could not be factorised: {error}") from error
        self._inverse_diagonal = (1.0 / matrix.diagonal()[:, None]).astype(np.float32)
        self._upper = MARGIN * self._upper_end()

    def __call__(self, right: Floats) -> Floats:
        """About A⁻¹ times each column, shape [n, columns]."""
        size = np.linalg.norm(right, axis=0)
        rest = (right / np.where(size > 0.0, size, 1.0)).astype(np.float32)
        found, rest = self._smoothed(np.zeros_like(rest), rest)
        linear = self._fields @ self._factor.solve((self._fields.T @ rest).astype(np.float64)).astype(np.float32)
        found, _ = self._smoothed(found + linear, rest - self._matrix @ linear)
        return np.asarray(found * size, np.float64)

    def _smoothed(self, found: Singles, rest: Singles) -> tuple[Singles, Singles]:
        """A solution and what it leaves over, after some Chebyshev steps (Saad 2003, algorithm 12.1)."""
        centre, half = np.float32(0.5 * self._upper * (1.0 + 1.0 / UPPER_PART)), np.float32(0.5 * self._upper * (1.0 - 1.0 / UPPER_PART))
        ratio, step = half / centre, self._inverse_diagonal * rest / centre
        for left in reversed(range(SMOOTHING)):
            found, rest = found + step, rest - self._matrix @ step
            if left:
                later = np.float32(1.0) / (np.float32(2.0) * centre / half - ratio)
                step, ratio = later * ratio * step + np.float32(2.0) * later / half * (self._inverse_diagonal * rest), later
        return found, rest

    def _upper_end(self) -> float:
        """The largest eigenvalue of D⁻¹A, nearly, by power iteration from a fixed start."""
        x = np.random.default_rng(0).standard_normal((self._matrix.shape[0], 1)).astype(np.float32)
        for _ in range(PRODUCTS):
            x = self._inverse_diagonal * (self._matrix @ (x / np.linalg.norm(x)))
        return float(np.linalg.norm(x))

