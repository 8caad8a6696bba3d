"""The small-strain stiffness of a body by blocks of node and node, assembled as often as its tetrahedra are weighted anew."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import bsr_array, csr_array

from mechstyle.fea.elements import Element
from mechstyle.records.material import Material
from mechstyle.records.mesh import Bools, Floats, Indices


@dataclass(frozen=True, eq=False)
class Stiffness:
    """Small-strain stiffness, which both laws have.

    Attributes:
        connectivity: Nodes of each tetrahedron, shape [tet_count, nodes].
        node_count: Nodes.
        gradients: ∇L_1, ∇L_2, ∇L_3 of each [1/mm], shape [tet_count, 3, 3].
        volumes: Volumes [mm³], shape [tet_count].
        element: What interpolates.
        material: The material.
    """

    connectivity: Indices
    node_count: int
    gradients: Floats
    volumes: Floats
    element: Element
    material: Material

    def magnitudes(self, weights: Floats) -> bsr_array:
        """|Σ w_e K_e|, entry by entry, w_e ≥ 0 of shape [tet_count] [N/mm], shape [3 node_count, 3 node_count]."""
        pairs, blocks = self._pairs, self._blocks
        straight, turned = (np.asarray(pairs.sums(weights, kind) @ blocks).reshape(-1, 3, 3) for kind in (False, True))
        block = np.abs(straight + turned.transpose(0, 2, 1))
        whole = np.concatenate([block, block[pairs.apart].transpose(0, 2, 1)])[pairs.order]
        size = 3 * self.node_count
        return bsr_array((whole, pairs.columns, pairs.starts), shape=(size, size))

    @cached_property
    def _pairs(self) -> _Pairs:
        return _Pairs.of(self.connectivity, self.node_count)

    @cached_property
    def _blocks(self) -> Floats:
        """K_ab = V (λ A + μ Aᵀ + μ tr A I), A the mean of ∇N_a ⊗ ∇N_b [N/mm], shape [pairs of `_Pairs.of`, 9]."""
        mu, la, g = self.material.shear_modulus, self.material.lame_lambda, self.gradients
        products = np.einsum("n,nik,njl->ijnkl", self.volumes, g, g)
        corners = la * products + mu * products.swapaxes(3, 4)
        corners += mu * np.einsum("ijnkk->ijn", products)[..., None, None] * np.eye(3)
        blocks = _products_of_derivatives(self.element) @ corners.reshape(9, -1)
        return np.asarray(blocks.reshape(-1, 9))


@dataclass(frozen=True, eq=False)
class _Pairs:
    """Pairs of nodes that a tetrahedron joins, each pair once, and where they stand in a matrix.

    Attributes:
        of_elements: Which pair of the mesh each pair of nodes of an element is, shape [pairs of an element, tet_count].
        turned: Which of those have the node with the higher number first, of the same shape.
        count: Pairs of the mesh.
        apart: Pairs of the mesh of two different nodes, which stand in the matrix twice.
        order: Pairs of the mesh and, behind them, those apart, row by row.
        columns: Their columns in that order.
        starts: Where each row starts, shape [node_count + 1].
    """

    of_elements: Indices
    turned: Bools
    count: int
    apart: Indices
    order: Indices
    columns: Indices
    starts: Indices

    @classmethod
    def of(cls, connectivity: Indices, count: int) -> _Pairs:
        """The pairs of a mesh, those of an element in the order of `numpy.triu_indices`."""
        first, second = (connectivity.T[ends].astype(np.int64) for ends in np.triu_indices(connectivity.shape[1]))
        keys, pair = np.unique(np.minimum(first, second) * count + np.maximum(first, second), return_inverse=True)
        low, high = keys // count, keys % count
        apart = np.flatnonzero(low != high)
        rows, columns = np.concatenate([low, high[apart]]), np.concatenate([high, low[apart]])
        order = np.lexsort((columns, rows))
        starts = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=count))])
        numbers = (pair.reshape(first.shape), apart, order, columns[order], starts)
        of_elements, *rest = (np.asarray(values).astype(np.int32) for values in numbers)
        return cls(of_elements, first > second, len(keys), *rest)

    def sums(self, weights: Floats, turned: bool) -> csr_array:
        """What adds up the weighted blocks of elements that are turned or not, shape [pairs of the mesh, pairs of all elements]."""
        chosen = np.flatnonzero(self.turned.ravel() == turned)
        data = np.broadcast_to(weights, self.turned.shape).ravel()[chosen]
        return csr_array((data, (self.of_elements.ravel()[chosen], chosen)), shape=(self.count, self.turned.size))


def _products_of_derivatives(element: Element) -> Floats:
    """Mean over the Gauss points of ∂N_a/∂L_i ∂N_b/∂L_j, i and j from 1 to 3 for L_0 = 1 − L_1 − L_2 − L_3, shape [pairs, 9]."""
    derivatives = element.derivatives[..., 1:] - element.derivatives[..., :1]
    products = np.einsum("qai,qbj->abij", derivatives, derivatives) / element.points
    return np.asarray(products[np.triu_indices(element.nodes)].reshape(-1, 9))
