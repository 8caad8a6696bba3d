"""Hyperelasticity on tetrahedra, in readable float64 numpy: the reference the fast kernels are tested against.

Units: mm, g, ms → N, MPa = N/mm² = g/(mm ms²), mJ. The kinematic variable everywhere is the displacement gradient
H = F − I, never F: strains of 1e-3 are differences of nearly equal numbers in F, but not in H. Every formula below is
arranged so that no two large terms cancel, which is what lets the float32 kernels use the same expressions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from mechstyle.errors import unknown
from mechstyle.fea.elements import ElementMesh
from mechstyle.records.material import Material
from mechstyle.records.mesh import Floats, TetMesh

LAWS = ("st_venant_kirchhoff", "stable_neo_hookean")
"""Elastic laws by name; the kernels know each by its place in this tuple."""

BATCH = 4096
"""Tetrahedra whose stiffness is assembled at a time: all of 24 000 at once took 1.4 GB."""


class ElasticLaw(Protocol):
    """A stored energy and the stress that derives from it."""

    @property
    def mu(self) -> float:
        """First constant of the law [MPa]."""

    @property
    def la(self) -> float:
        """Second constant of the law [MPa]."""

    def energy_density(self, H: Floats) -> Floats:
        """Ψ(H) [MPa = mJ/mm³], zero for H = 0, shape [...]; H has shape [..., 3, 3]."""

    def first_piola(self, H: Floats) -> Floats:
        """First Piola–Kirchhoff stress P = ∂Ψ/∂H [MPa], shape [..., 3, 3]."""


@dataclass(frozen=True)
class StVenantKirchhoff:
    """Ψ = λ/2 (tr E)² + μ E:E with Green's strain E = (H + Hᵀ + HᵀH)/2 and the Lamé parameters of the material."""

    mu: float
    la: float

    def energy_density(self, H: Floats) -> Floats:
        """Ψ(H) [MPa], shape [...]."""
        E = green_strain(H)
        return 0.5 * self.la * trace(E) ** 2 + self.mu * np.einsum("...ij,...ij->...", E, E)

    def first_piola(self, H: Floats) -> Floats:
        """P = F S = S + H S with S = λ tr(E) I + 2μ E [MPa], shape [..., 3, 3]."""
        E = green_strain(H)
        S = self.la * trace(E)[..., None, None] * np.eye(3) + 2.0 * self.mu * E
        return S + H @ S


@dataclass(frozen=True)
class StableNeoHookean:
    """Ψ = μ/2 (I_C − 3) − μ/2 ln(I_C + 1) + λ/2 (J − α)², α = 1 + 3μ/(4λ), less its rest value (Smith et al. 2018, eq. 13).

    With q = I_C − 3 = 2 tr H + H:H and J − 1 = tr H + tr cof H + det H the constants drop out and the terms of first
    order cancel on paper instead of in the machine:

        Ψ = 3μ/8 (H:H − 2 tr cof H − 2 det H) + μ/2 (q/4 − ln(1 + q/4)) + λ/2 (J − 1)²
        P = 3μ/4 (H + Hᵀ − tr(H) I − cof H) + μ q / (4 (4 + q)) F + λ (J − 1) cof F
        cof F = (1 + tr H) I − Hᵀ + cof H

    For small strain ε this is P = 3/2 μ ε + (λ − 3/4 μ + 1/8 μ) tr(ε) I, which is Hooke's law 2 μ_L ε + λ_L tr(ε) I
    if and only if μ = 4/3 μ_L and λ = λ_L + 5/8 μ = λ_L + 5/6 μ_L. With the Lamé parameters put in directly, PLA would
    be a quarter too soft (E = 2.6 instead of 3.5 GPa). `law_named` does the conversion.
    """

    mu: float
    la: float

    def energy_density(self, H: Floats) -> Floats:
        """Ψ(H) [MPa], shape [...]."""
        q, volume_change = self._invariants(H)
        square = np.einsum("...ij,...ij->...", H, H)
        shape = square - 2.0 * (volume_change - trace(H))
        return 0.375 * self.mu * shape + 0.5 * self.mu * (0.25 * q - np.log1p(0.25 * q)) + 0.5 * self.la * volume_change**2

    def first_piola(self, H: Floats) -> Floats:
        """P = ∂Ψ/∂H [MPa], shape [..., 3, 3]."""
        q, volume_change = (value[..., None, None] for value in self._invariants(H))
        cof, spherical = cofactor(H), trace(H)[..., None, None] * np.eye(3)
        transposed = np.swapaxes(H, -1, -2)
        cof_F = np.eye(3) + spherical - transposed + cof
        shape = H + transposed - spherical - cof
        return 0.75 * self.mu * shape + self.mu * q / (4.0 * (4.0 + q)) * (np.eye(3) + H) + self.la * volume_change * cof_F

    @staticmethod
    def _invariants(H: Floats) -> tuple[Floats, Floats]:
        """Both of q = I_C − 3 and J − 1, each of shape [...]."""
        return 2.0 * trace(H) + np.einsum("...ij,...ij->...", H, H), trace(H) + trace(cofactor(H)) + np.linalg.det(H)


def law_named(name: str, material: Material) -> ElasticLaw:
    """The elastic law `name`, one of LAWS, with the constants that give it the material's E and ν at small strain."""
    mu, la = material.shear_modulus, material.lame_lambda
    if name == "st_venant_kirchhoff":
        return StVenantKirchhoff(mu, la)
    if name == "stable_neo_hookean":
        return StableNeoHookean(4.0 / 3.0 * mu, la + 5.0 / 6.0 * mu)
    raise unknown("elastic law", name, LAWS)


def trace(A: Floats) -> Floats:
    """Σ A_ii, shape [...]."""
    return np.einsum("...ii->...", A)


def cofactor(A: Floats) -> Floats:
    """The cofactors cof A = det(A) A⁻ᵀ, defined for singular A too, shape [..., 3, 3]."""
    a, b, c = A[..., 0, :], A[..., 1, :], A[..., 2, :]
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-2)


def green_strain(H: Floats) -> Floats:
    """E = (H + Hᵀ + HᵀH)/2, shape [..., 3, 3]."""
    transposed = np.swapaxes(H, -1, -2)
    return 0.5 * (H + transposed + transposed @ H)


def cauchy_stress(H: Floats, P: Floats) -> Floats:
    """Cauchy stress σ = P Fᵀ / J [MPa], shape [..., 3, 3]."""
    J = 1.0 + trace(H) + trace(cofactor(H)) + np.linalg.det(H)
    return (P + P @ np.swapaxes(H, -1, -2)) / J[..., None, None]


def von_mises(stress: Floats) -> Floats:
    """Equivalent stress sqrt(3/2 s:s), s the deviator of `stress` [MPa], shape [...]."""
    deviator = stress - trace(stress)[..., None, None] / 3.0 * np.eye(3)
    return np.asarray(np.sqrt(1.5 * np.einsum("...ij,...ij->...", deviator, deviator)))


def equivalent_stress(stress: Floats, across: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """What is compared with the yield strength: von Mises stress, or where it is larger what pulls or shears printed layers apart.

    Layers with normal n have the share r of the strength: with t = σn the demand is the largest of σ_vM / σ_y, max(0, n·t) / (r σ_y) and
    |t − (n·t) n| / (r σ_y / √3). Pressure on layers does no harm.

    Args:
        stress: Cauchy stress [MPa], shape [..., 3, 3].
        across: n / r, shape [3]; zero for a material without layers.

    Returns:
        Equivalent stress [MPa], shape [...].
    """
    of_solid, weak = von_mises(stress), np.asarray(across, dtype=np.float64)
    steep = float(weak @ weak)
    if steep == 0.0:
        return of_solid
    traction = stress @ weak
    pull = traction @ weak / math.sqrt(steep)
    shear = np.sqrt(np.maximum(np.einsum("...i,...i->...", traction, traction) - pull**2, 0.0))
    return np.asarray(np.maximum(of_solid, np.maximum(pull, math.sqrt(3.0) * shear)))


def barycentric_gradients(tets: TetMesh) -> Floats:
    """∇L_0 to ∇L_3 [1/mm], shape [tet_count, 4, 3]; they sum to zero."""
    corners = tets.vertices[tets.tets]
    inverse = np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))
    return np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)


def shape_gradients(mesh: ElementMesh) -> Floats:
    """∇N_a at the Gauss points [1/mm], shape [tet_count, points, nodes, 3]; they sum to zero over the nodes."""
    return np.einsum("qai,nij->nqaj", mesh.element.derivatives, barycentric_gradients(mesh.tets))


def point_volumes(mesh: ElementMesh) -> Floats:
    """Volume that each Gauss point stands for [mm³], shape [tet_count, points]."""
    points = mesh.element.points
    return np.repeat(mesh.tets.volumes[:, None] / points, points, axis=1)


def displacement_gradients(mesh: ElementMesh, displacement: Floats) -> Floats:
    """H = Σ_a u_a ⊗ ∇N_a at the Gauss points, shape [tet_count, points, 3, 3]; `displacement` [mm] is [node_count, 3]."""
    return _gradients_at(mesh.element.derivatives, mesh, displacement)


def corner_gradients(mesh: ElementMesh, displacement: Floats) -> Floats:
    """H at the corners of every tetrahedron, shape [tet_count, 4, 3, 3]; `displacement` [mm] is [node_count, 3].

    The gradient of a quadratic element is linear in it, so this is what is extrapolated from the Gauss points.
    """
    return _gradients_at(mesh.element.corner_derivatives, mesh, displacement)


def _gradients_at(derivatives: Floats, mesh: ElementMesh, displacement: Floats) -> Floats:
    """H where the shape functions have the given ∂N_a/∂L_i, [n, nodes, 4], shape [tet_count, n, 3, 3]."""
    nodal = displacement[mesh.connectivity]
    at_points = np.einsum("nai,qak->nqik", nodal - nodal[:, :1], derivatives, optimize=True)
    return np.asarray(at_points @ barycentric_gradients(mesh.tets)[:, None])


def strain_energy(mesh: ElementMesh, law: ElasticLaw, displacement: Floats) -> float:
    """U = Σ V Ψ(H) [mJ]."""
    return float((point_volumes(mesh) * law.energy_density(displacement_gradients(mesh, displacement))).sum())


def internal_forces(mesh: ElementMesh, law: ElasticLaw, displacement: Floats) -> Floats:
    """Forces the deformed body exerts on its nodes, f_a = −Σ V P ∇N_a = −∂U/∂u_a [N], shape [node_count, 3]."""
    return forces_of(mesh, law, displacement_gradients(mesh, displacement))


def forces_of(mesh: ElementMesh, law: ElasticLaw, gradients: Floats) -> Floats:
    """As `internal_forces`, of displacement gradients H at the Gauss points, shape [tet_count, points, 3, 3]."""
    P = law.first_piola(gradients)
    shares = -np.einsum("nq,nqij,nqaj->nai", point_volumes(mesh), P, shape_gradients(mesh))
    forces = np.zeros_like(mesh.nodes)
    np.add.at(forces, mesh.connectivity, shares)
    return forces


def lumped_masses(mesh: ElementMesh, masses: Floats) -> Floats:
    """The mass of every tetrahedron, [tet_count], shared out to its nodes [g], shape [node_count]."""
    shares = np.outer(masses, mesh.element.mass_shares)
    return np.asarray(np.bincount(mesh.connectivity.ravel(), shares.ravel(), len(mesh.nodes)), dtype=np.float64)


def stiffness_matrix(mesh: ElementMesh, material: Material) -> sparse.csr_array:
    """Small-strain stiffness K = Σ V Bᵀ C B [N/mm], shape [3 node_count, 3 node_count], x, y, z of a node adjacent."""
    gradients, volumes = shape_gradients(mesh), point_volumes(mesh)
    mu, la = material.shear_modulus, material.lame_lambda
    size, width = 3 * len(mesh.nodes), 3 * mesh.element.nodes
    whole = sparse.csr_array((size, size))
    for first in range(0, len(volumes), BATCH):
        some = slice(first, first + BATCH)
        g = gradients[some]
        products = np.einsum("nq,nqai,nqbj->naibj", volumes[some], g, g, optimize=True)
        blocks = la * products + mu * products.transpose(0, 1, 4, 3, 2)
        blocks += mu * np.einsum("nakbk,ij->naibj", products, np.eye(3))
        unknowns = (3 * mesh.connectivity[some, :, None] + np.arange(3)).reshape(-1, width)
        rows, columns = np.repeat(unknowns, width, axis=1).ravel(), np.tile(unknowns, (1, width)).ravel()
        whole = whole + sparse.coo_array((blocks.ravel(), (rows, columns)), shape=(size, size)).tocsr()
    return whole


def element_frequencies(tets: TetMesh, material: Material) -> Floats:
    """Largest eigenfrequency of each linear tetrahedron on its own, with lumped masses [rad/ms], shape [tet_count].

    With equal masses ρV/4 at the corners, M⁻¹K acts on displacement gradients as H ↦ 4/ρ (C : H) A, A = Σ_a ∇N_a ⊗ ∇N_a.
    In the principal axes of A (principal values a_i) shear and normal parts decouple; the largest eigenvalue belongs to
    the normal part, that is to 4/ρ √a (λ 11ᵀ + 2μ I) √a, because it is at least (λ + 2μ) a_max and shear gives μ (a_i + a_j).
    """
    g = barycentric_gradients(tets)
    root = np.sqrt(np.linalg.eigvalsh(np.einsum("nai,naj->nij", g, g)))
    normal = material.lame_lambda * np.ones((3, 3)) + 2.0 * material.shear_modulus * np.eye(3)
    largest = np.linalg.eigvalsh(root[:, :, None] * normal * root[:, None, :])[:, -1]
    return np.sqrt(4.0 / material.density * largest)
