"""A body prepared for time integration: numbering, gradients, stiffness, masses. Shared by all orientations.

The step follows from a bound of the highest frequency from above. With N_ij the spectral norm of the block A_ij of nodes i and j, every
eigenvector of M⁻¹A has |λ| ‖x_i‖ ≤ Σ_j N_ij ‖x_j‖ / m_i. So for every positive vector x, max_i (N x)_i / (m_i x_i) is at least the spectral
radius of M⁻¹N (Collatz 1942, Wielandt 1950), and that at least the one of M⁻¹A. Products with M⁻¹N never raise the bound; some make it 3 %
high in meshes of parts, 20 % in regular ones.

The same gives the mass that slivers need: masses m_i ≥ (N x)_i / (λ x_i) keep the bound at λ. Only the nodes that set it become heavier.
Scaling whole tetrahedra by frequencies of their own takes three to ten times the mass for the same step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.sparse import bsr_array, csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from mechstyle.errors import BadInput
from mechstyle.fea.elasticity import barycentric_gradients, element_frequencies, lumped_masses
from mechstyle.fea.elements import LINEAR, Element, ElementMesh, element_named, with_nodes
from mechstyle.records.material import Material
from mechstyle.records.mesh import Bools, Floats, Indices, TetMesh


@dataclass(frozen=True, eq=False)
class Relative:
    """What a cellular body has of the properties of the solid it is made of, its holes smeared out (Gibson and Ashby 1997).

    Attributes:
        density: Its density over the solid's at the Gauss points, shape [tet_count, points], as the others.
        stiffness: Its stiffness over the solid's.
        strength: Its yield strength over the solid's.
    """

    density: Floats
    stiffness: Floats
    strength: Floats

    @property
    def bears(self) -> Floats:
        """Stress that the solid would have at the strain at which the body yields, over the solid's strength, [tet_count, points]."""
        return self.strength / self.stiffness

    def subset(self, which: Indices) -> Relative:
        """That of some tetrahedra."""
        return Relative(self.density[which], self.stiffness[which], self.strength[which])


@dataclass(frozen=True, eq=False)
class Discretisation:
    """A body in the order in which it is computed.

    Nodes are numbered along a reverse Cuthill–McKee ordering and tetrahedra by their first node, so that what is used together
    lies together in memory. Vertices that no tetrahedron uses are left out.

    Attributes:
        mesh: The tetrahedra and nodes in the caller's numbering, without unused vertices.
        vertices: Caller's numbers of the vertices of `mesh`, shape [vertex_count].
        place: Where each node of `mesh` is computed, shape [node_count].
        tet_order: Tetrahedron of `mesh` that is computed in each place, shape [tet_count].
        connectivity: Nodes of each tetrahedron in the order of computation, shape [tet_count, nodes].
        gradients: ∇L_1, ∇L_2, ∇L_3 [1/mm] as rows, shape [tet_count, 3, 3]; ∇L_0 is minus their sum.
        volumes: Volumes [mm³], shape [tet_count].
        frequencies: Largest eigenfrequency of each tetrahedron on its own, or what the masses bound that of the body by if it is less
            [rad/ms], shape [tet_count].
        masses: Lumped masses, some heavier than they are [g], shape [node_count].
        added_mass: Mass added so over the mass of the body.
        highest: Positive vector with which the masses bound the highest frequency, shape [node_count]: see `bound`.
        slots: Where an element's share of a force on a node goes before the shares are added up, shape [tet_count, nodes]: the slots
            of a node follow each other in the order of the tetrahedra.
        first_slot: Where each node's slots start, shape [node_count + 1].
        stiffness: Its stiffness in the order of computation.
        relative: What it has of the solid's properties, in the order of computation; None for a solid body.
    """

    mesh: ElementMesh
    vertices: Indices
    place: Indices
    tet_order: Indices
    connectivity: Indices
    gradients: Floats
    volumes: Floats
    frequencies: Floats
    masses: Floats
    added_mass: float
    highest: Floats
    slots: Indices
    first_slot: Indices
    stiffness: Stiffness
    relative: Relative | None = None

    @property
    def point_volumes(self) -> Floats:
        """Volume of solid as stiff as each Gauss point's share of its tetrahedron [mm³], shape [tet_count, points]."""
        return self.stiffness.point_volumes

    @property
    def positions(self) -> Floats:
        """Nodes in the order of computation [mm], shape [node_count, 3]."""
        positions = np.empty_like(self.mesh.nodes)
        positions[self.place] = self.mesh.nodes
        return positions

    @property
    def centre(self) -> Floats:
        """Centre of mass [mm], shape [3]."""
        return np.asarray(self.masses @ self.positions / self.masses.sum())

    @property
    def arms(self) -> Floats:
        """Nodes seen from the centre of mass, in the order of computation [mm], shape [node_count, 3]."""
        return self.positions - self.centre


def discretise(
    tets: TetMesh, material: Material, added_mass: float, element: Element = LINEAR, relative: Relative | None = None
) -> Discretisation:
    """Number a body and lump its masses, made heavier by the share `added_mass` of the solid where that lengthens the stable step most.

    `relative` is what it has of the solid's properties, tetrahedra in the caller's numbering; None for a solid body. Slivers lie at the
    surface, where a print is solid: with what the solid may add they get as heavy, and the step as long, as in the solid.

    BadInput if there is no tetrahedron, a vertex is not finite or a tetrahedron is flat or inverted.
    """
    if len(tets.tets) == 0:
        raise BadInput("there are no tetrahedra to drop: the part must be meshed inside first")
    if not np.isfinite(tets.vertices).all():
        raise BadInput(f"{int((~np.isfinite(tets.vertices)).any(axis=1).sum())} vertices of the tetrahedra are not finite numbers")
    flat = np.flatnonzero(tets.volumes <= 0.0)
    if len(flat):
        x, y, z = tets.vertices[tets.tets[flat[0]]].mean(axis=0)
        raise BadInput(f"{len(flat)} tetrahedra have no positive volume, the first at ({x:.1f}, {y:.1f}, {z:.1f}) mm; mesh the part again")
    numbering = _numbering(tets.tets.tobytes(), element.name)
    mesh = ElementMesh(TetMesh(tets.vertices[numbering.vertices], numbering.tets), element, numbering.connectivity)
    place, tet_order, connectivity = numbering.place, numbering.tet_order, numbering.connectivity[numbering.tet_order]
    gradients, volumes = barycentric_gradients(mesh.tets)[tet_order, 1:], mesh.tets.volumes[tet_order]
    lumped = np.empty(len(mesh.nodes))
    density = 1.0 if relative is None else relative.density.mean(axis=1)
    lumped[place] = lumped_masses(mesh, material.density * density * mesh.tets.volumes)
    of_solid = 1.0 if relative is None else float(material.density * mesh.tets.volumes.sum() / lumped.sum())
    ordered = None if relative is None else relative.subset(tet_order)
    factors = None if ordered is None else ordered.stiffness
    stiffness = Stiffness(numbering.pairs, gradients, volumes, element, material, factors)
    slower = 1.0 if ordered is None else np.sqrt(ordered.stiffness.max(axis=1) / ordered.density.mean(axis=1))
    masses, highest, limit = lengthened(stiffness.norms, lumped, added_mass * of_solid)
    return Discretisation(
        mesh=mesh, vertices=numbering.vertices, place=place, tet_order=tet_order, connectivity=place[connectivity], gradients=gradients,
        volumes=volumes, masses=masses, added_mass=float(masses.sum() / lumped.sum() - 1.0), highest=highest,
        frequencies=np.minimum(element.stiffer * element_frequencies(mesh.tets, material)[tet_order] * slower, np.sqrt(limit)),
        slots=numbering.slots, first_slot=numbering.first_slot, stiffness=stiffness, relative=ordered,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Numbering:
    """What of a discretisation follows from which vertices the tetrahedra join; `connectivity` is in the numbering of the mesh."""

    vertices: Indices
    tets: Indices
    connectivity: Indices
    place: Indices
    tet_order: Indices
    slots: Indices
    first_slot: Indices
    pairs: Pairs


@lru_cache(maxsize=4)  # a run drops one mesh again and again, morphed, and its original's
def _numbering(joined: bytes, element: str) -> _Numbering:
    """The numbering of tetrahedra, given as the bytes of what they join, int32 of shape [tet_count, 4]."""
    vertices, number = np.unique(np.frombuffer(joined, np.int32), return_inverse=True)
    tets = number.reshape(-1, 4).astype(np.int32)
    connectivity = with_nodes(TetMesh(np.zeros((len(vertices), 3)), tets), element_named(element)).connectivity
    start = np.repeat(np.arange(len(connectivity)), connectivity.shape[1])
    ones, shape = np.ones(len(start), dtype=np.int32), (int(connectivity.max()) + 1, len(connectivity))
    inside = csr_array((ones, (connectivity.ravel(), start)), shape=shape)
    order = reverse_cuthill_mckee((inside @ inside.T).tocsr(), symmetric_mode=True)  # along what the elements join
    place = np.argsort(order.astype(np.int32)).astype(np.int32)
    numbered = place[connectivity]
    tet_order = np.argsort(numbered.min(axis=1), kind="stable").astype(np.int32)
    slot_nodes = numbered[tet_order].ravel()
    return _Numbering(
        vertices=vertices.astype(np.int32), tets=tets, connectivity=connectivity, place=place, tet_order=tet_order,
        slots=np.argsort(np.argsort(slot_nodes, kind="stable")).astype(np.int32).reshape(connectivity.shape),
        first_slot=np.concatenate([[0], np.cumsum(np.bincount(slot_nodes, minlength=len(place)))]).astype(np.int32),
        pairs=Pairs.of(numbered[tet_order], len(place)),
    )  # fmt: skip


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
    """Small-strain stiffness, which both laws have; gradients and volumes as in `Discretisation`, `factors` on it as in `Relative`."""

    pairs: Pairs
    gradients: Floats
    volumes: Floats
    element: Element
    material: Material
    factors: Floats | None = None

    @property
    def point_volumes(self) -> Floats:
        """As in `Discretisation`."""
        points = np.repeat(self.volumes[:, None] / self.element.points, self.element.points, axis=1)
        return points if self.factors is None else points * self.factors

    def matrix(self) -> bsr_array:
        """K = Σ K_e [N/mm], shape [3 node_count, 3 node_count]."""
        pairs, size = self.pairs, 3 * self.pairs.node_count
        block = np.asarray(pairs.sums(np.ones(len(self.volumes))) @ self._blocks).reshape(-1, 3, 3)
        whole = np.concatenate([block, block[pairs.apart].transpose(0, 2, 1)])[pairs.order]
        return bsr_array((whole, pairs.columns, pairs.starts), shape=(size, size))

    @cached_property
    def norms(self) -> csr_array:
        """Spectral norms of the blocks K_ij of K [N/mm], shape [node_count, node_count]."""
        return self.weighted_norms(np.ones(len(self.volumes)))

    def weighted_norms(self, weights: Floats) -> csr_array:
        """The same of Σ w_e K_e, w_e ≥ 0 of shape [tet_count]."""
        pairs, norms = self.pairs, spectral_norms(self.pairs.sums(weights) @ self._blocks)
        whole = np.concatenate([norms, norms[pairs.apart]])[pairs.order]
        return csr_array((whole, pairs.columns, pairs.starts), shape=(pairs.node_count, pairs.node_count))

    @cached_property
    def _blocks(self) -> Floats:
        """K_ab = V (λ A + μ Aᵀ + μ tr A I), A the mean of ∇N_a ⊗ ∇N_b [N/mm], K_ba where that is turned, shape [pairs of elements, 9]."""
        mu, la, g = self.material.shear_modulus, self.material.lame_lambda, self.gradients
        products = np.einsum("n,nik,njl->ijnkl", self.volumes, g, g)
        corners = la * products + mu * products.swapaxes(3, 4)
        corners += mu * np.einsum("ijnkk->ijn", products)[..., None, None] * np.eye(3)
        derivatives = self.element.derivatives[..., 1:] - self.element.derivatives[..., :1]  # by L_1, L_2, L_3, of which L_0 is the rest
        pairs = np.triu_indices(self.element.nodes)
        if self.factors is None:
            means = np.einsum("qai,qbj->abij", derivatives, derivatives) / self.element.points
            blocks = means[pairs].reshape(-1, 9) @ corners.reshape(9, -1)
        else:
            means = np.einsum("qai,qbj->abqij", derivatives, derivatives)[pairs].reshape(len(pairs[0]), -1, 9) / self.element.points
            scaled = (means[:, q] @ (corners * self.factors[:, q, None, None]).reshape(9, -1) for q in range(self.element.points))
            blocks = np.asarray(sum(scaled))
        blocks = blocks.reshape(-1, 3, 3)
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


PRODUCTS = 12
"""Products before a bound is read: of a hook of 5.8k tetrahedra it is then 1.015 times the largest frequency, 1.009 from the vector that
comes with the masses."""
ROUNDS = 30
"""The same where masses change with every product."""
LEAST = 1e-12
"""Of the largest entry of x, so that none underflows to zero."""


def bound(norms: csr_array, masses: Floats, start: Floats) -> float:
    """At least the largest eigenvalue of M⁻¹A [1/ms²]; the nearer `start` > 0 is to the eigenvector, the lower.

    `norms` are of the blocks of A [N/mm], shape [node_count, node_count], `masses` of the nodes [g], shape [node_count].
    """
    x, ratio = start, np.ones(len(start))
    for _ in range(PRODUCTS):
        image = norms @ x / masses
        ratio, x = image / x, np.maximum(image / image.max(), LEAST)
    return float(ratio.max())


def lengthened(norms: csr_array, masses: Floats, share: float) -> tuple[Floats, Floats, float]:
    """Masses that are `share` of the whole more and allow the longest step [g], shape [node_count], what proves it, and what it proves.

    `norms` and `masses` are those of `bound`. The proof is a positive vector x, shape [node_count], and the bound λ [1/ms²].
    """
    x, allowance = np.ones(len(masses)), share * masses.sum()
    for _ in range(ROUNDS):
        image = norms @ x
        needed = image / x
        order = np.argsort(-needed / masses)  # Σ max(0, needed/λ − m) ≤ allowance is linear in 1/λ between the sorted needed/m
        highest = float((np.cumsum(needed[order]) / (allowance + np.cumsum(masses[order]))).max())
        heavier = np.maximum(masses, needed / highest)
        proof, x = x, image / heavier
        x = np.maximum(x / x.max(), LEAST)
    return heavier, proof, highest
