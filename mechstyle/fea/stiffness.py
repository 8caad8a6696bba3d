"""The small-strain stiffness of a body by blocks of node and node, assembled as often as its tetrahedra are weighted anew."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_array, coo_array, csr_array, eye_array, kron
from scipy.sparse.linalg import splu

from mechstyle.errors import SimulationFailed
from mechstyle.fea.elements import EDGES, Element
from mechstyle.records.material import Material
from mechstyle.records.mesh import Bools, Floats, Indices


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs of nodes that a tetrahedron joins, each pair once, and where they stand in a matrix.

    Attributes:
        node_count: Nodes.
        turned: Whether a pair of nodes of an element has the node with the higher number first, shape [pairs of an element, tet_count].
        members: Pairs of elements, pair of the mesh by pair of the mesh, numbered as the entries of `turned`.
        first: Where those of each pair of the mesh start, shape [pairs of the mesh + 1].
        apart: Pairs of the mesh of two different nodes, which stand in the matrix twice.
        order: Pairs of the mesh and, behind them, those apart, row by row.
        columns: Their columns in that order.
        starts: Where each row starts, shape [node_count + 1].
    """

    node_count: int
    turned: Bools
    members: Indices
    first: Indices
    apart: Indices
    order: Indices
    columns: Indices
    starts: Indices

    @classmethod
    def of(cls, connectivity: Indices, count: int) -> Pairs:
        """The pairs of a mesh of `count` nodes, those of an element in the order of `numpy.triu_indices`."""
        one, other = (connectivity.T[ends].astype(np.int64) for ends in np.triu_indices(connectivity.shape[1]))
        keys, pair, often = np.unique(np.minimum(one, other) * count + np.maximum(one, other), return_inverse=True, return_counts=True)
        members, first = np.argsort(pair.ravel(), kind="stable"), np.concatenate([[0], np.cumsum(often)])
        low, high = keys // count, keys % count
        apart = np.flatnonzero(low != high)
        rows, columns = np.concatenate([low, high[apart]]), np.concatenate([high, low[apart]])
        order = np.lexsort((columns, rows))
        starts = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=count))])
        numbers = (members, first, apart, order, columns[order], starts)
        return cls(count, one > other, *(np.asarray(values).astype(np.int32) for values in numbers))

    def sums(self, weights: Floats) -> csr_array:
        """What adds up the weighted blocks of elements, in ascending order, shape [pairs of the mesh, pairs of all elements]."""
        data = weights[self.members % self.turned.shape[1]]
        return csr_array((data, self.members, self.first), shape=(len(self.first) - 1, self.turned.size))


@dataclass(frozen=True, eq=False)
class Stiffness:
    """Small-strain stiffness, which both laws have.

    Attributes:
        pairs: Which nodes the tetrahedra join.
        gradients: ∇L_1, ∇L_2, ∇L_3 of each [1/mm], shape [tet_count, 3, 3].
        volumes: Volumes [mm³], shape [tet_count].
        element: What interpolates.
        material: The material.
    """

    pairs: Pairs
    gradients: Floats
    volumes: Floats
    element: Element
    material: Material

    def matrix(self) -> bsr_array:
        """K = Σ K_e [N/mm], shape [3 node_count, 3 node_count]."""
        pairs, size = self.pairs, 3 * self.pairs.node_count
        block = self._assembled(np.ones(len(self.volumes))).reshape(-1, 3, 3)
        whole = np.concatenate([block, block[pairs.apart].transpose(0, 2, 1)])[pairs.order]
        return bsr_array((whole, pairs.columns, pairs.starts), shape=(size, size))

    @cached_property
    def norms(self) -> csr_array:
        """Spectral norms of the blocks K_ij of K [N/mm], shape [node_count, node_count]."""
        return self.weighted_norms(np.ones(len(self.volumes)))

    def weighted_norms(self, weights: Floats) -> csr_array:
        """The same of Σ w_e K_e, w_e ≥ 0 of shape [tet_count]."""
        pairs, norms = self.pairs, spectral_norms(self._assembled(weights))
        whole = np.concatenate([norms, norms[pairs.apart]])[pairs.order]
        return csr_array((whole, pairs.columns, pairs.starts), shape=(pairs.node_count, pairs.node_count))

    def _assembled(self, weights: Floats) -> Floats:
        """Σ w_e K_e by blocks, shape [pairs of the mesh, 9]."""
        return np.asarray(self.pairs.sums(weights) @ self._blocks)

    @cached_property
    def _blocks(self) -> Floats:
        """K_ab = V (λ A + μ Aᵀ + μ tr A I), A the mean of ∇N_a ⊗ ∇N_b [N/mm], K_ba where that is turned, shape [pairs of elements, 9]."""
        mu, la, g = self.material.shear_modulus, self.material.lame_lambda, self.gradients
        products = np.einsum("n,nik,njl->ijnkl", self.volumes, g, g)
        corners = la * products + mu * products.swapaxes(3, 4)
        corners += mu * np.einsum("ijnkk->ijn", products)[..., None, None] * np.eye(3)
        derivatives = self.element.derivatives[..., 1:] - self.element.derivatives[..., :1]  # by L_1, L_2, L_3, of which L_0 is the rest
        means = np.einsum("qai,qbj->abij", derivatives, derivatives) / self.element.points
        means = means[np.triu_indices(self.element.nodes)].reshape(-1, 9)
        blocks = (means @ corners.reshape(9, -1)).reshape(-1, 3, 3)
        turned = self.pairs.turned.ravel()
        blocks[turned] = blocks[turned].transpose(0, 2, 1)
        return np.asarray(blocks.reshape(-1, 9))


def spectral_norms(blocks: Floats) -> Floats:
    """Largest singular values of matrices of 3 × 3, at least what they are and by 1e-7 of it more, from shape [count, 9]; shape [count].

    The largest eigenvalue of AᵀA in closed form: O. K. Smith, Eigenvalues of a symmetric 3 × 3 matrix, Comm. ACM 4 (1961) 168.
    """
    rows = np.ascontiguousarray(blocks.T).reshape(3, 3, -1)
    square = {(i, j): np.einsum("kn,kn->n", rows[:, i], rows[:, j]) for i in range(3) for j in range(i, 3)}
    mean = (square[0, 0] + square[1, 1] + square[2, 2]) / 3.0
    a, b, c = (square[i, i] - mean for i in range(3))
    f, e, d = (square[ends] for ends in ((0, 1), (0, 2), (1, 2)))
    spread = np.sqrt((a * a + b * b + c * c + 2.0 * (d * d + e * e + f * f)) / 6.0)
    determinant = a * (b * c - d * d) - f * (f * c - d * e) + e * (f * d - b * e)
    cubed = 2.0 * spread**3
    cosine = np.divide(determinant, cubed, out=np.ones_like(cubed), where=cubed > 0.0)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0)) / 3.0
    return np.asarray(np.sqrt(mean + 2.0 * spread * np.cos(angle)) * (1.0 + 1e-7))


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

    def __init__(self, matrix: bsr_array | csr_array, fields: csr_array, shift: float = 0.0) -> None:
        self._matrix, self._fields = matrix.astype(np.float32), fields.astype(np.float32)  # what is about right may be rounded
        coarse = (fields.T @ (matrix.tocsr() @ fields) + shift * (fields.T @ fields)).tocsc()
        try:
            self._factor = splu(coarse, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except (RuntimeError, MemoryError) as error:
            raise SimulationFailed(f"the equations of the part could not be factorised: {error}") from error
        self._inverse_diagonal = (1.0 / matrix.diagonal()[:, None]).astype(np.float32)
        x = np.random.default_rng(0).standard_normal((self._matrix.shape[0], 1)).astype(np.float32)
        for _ in range(PRODUCTS):  # by power iteration, nearly the largest eigenvalue of D⁻¹A
            x = self._inverse_diagonal * (self._matrix @ (x / np.linalg.norm(x)))
        self._upper = MARGIN * float(np.linalg.norm(x))

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
