"""Elasticity of tetrahedra in float64 numpy: laws and their constants, gradients, masses, stiffness and frequencies.

Units: mm, g, ms → N, MPa = N/mm² = g/(mm ms²), mJ. The kinematic variable everywhere is the displacement gradient
H = F − I, never F: strains of 1e-3 are differences of nearly equal numbers in F, but not in H. Every formula below is
arranged so that no two large terms cancel, which is what lets the float32 kernels use the same expressions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

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


@dataclass(frozen=True)
class ElasticLaw:
    """Constants μ and λ of an elastic law [MPa]; `backends.laws` has its energy and its stress P = ∂Ψ/∂H."""

    mu: float
    la: float


class StVenantKirchhoff(ElasticLaw):
    """Ψ = λ/2 (tr E)² + μ E:E with Green's strain E = (H + Hᵀ + HᵀH)/2 and the Lamé parameters of the material."""


class StableNeoHookean(ElasticLaw):
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


def energy_density(law: ElasticLaw, H: Floats, A: Floats, shares: Floats) -> Floats:
    """Ψ of a neo-Hookean body after plastic flow [MPa = mJ/mm³], shape [...], of A = C_p⁻¹ − I as xx yy zz xy yz zx, shape [..., 6].

    As `StableNeoHookean`, with b_e = F C_p⁻¹ Fᵀ in place of F Fᵀ: with G = F A, q is more by F:G, and so is the first bracket; `softened`
    by the `shares`. A point that flowed may have been turned and sheared a lot: what is left elastic is small beside H, which double
    precision can bear.
    """
    full = A[..., [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
    G = full + H @ full
    change = np.linalg.det(np.eye(3) + H) - 1.0
    square = np.einsum("...ij,...ij->...", H, H + G) + trace(G)
    x = 0.25 * (2.0 * trace(H) + square)
    shape = 0.375 * law.mu * (square - 2.0 * (change - trace(H)))
    return softened(A, shares) * np.asarray(shape + 0.5 * law.mu * (x - np.log1p(x)) + 0.5 * law.la * change**2)


def softened(A: Floats, shares: Floats) -> Floats:
    """Factor 1 / max(1, s (1 + ‖A‖)) on the elastic constants of a point; A as xx yy zz xy yz zx, [..., 6], s and result of shape [...].

    1 + ‖A‖ bounds the largest eigenvalue of C_p⁻¹. By its root an element that was pressed flat would vibrate faster, and need a smaller
    step: half of it where it is crushed to half its height. With s what it uses up of the step (`explicit.step_shares`), the step of the
    undeformed body stays stable. The price is paid by the stiffest elements where their plastic strain exceeds some 4 %: an elastic strain
    of more than σ_y/E, and 2 % more dissipation there than plastic work. A knob of 5.5k tetrahedra that lands on an edge and is crushed by
    half there does 2 % less plastic work than with 0.4 of the step; where nothing is crushed there is no difference.
    """
    size = np.sqrt((A[..., :3] ** 2).sum(axis=-1) + 2.0 * (A[..., 3:] ** 2).sum(axis=-1))
    return np.asarray(1.0 / np.maximum(1.0, shares * (1.0 + size)))


def von_mises(stress: Floats) -> Floats:
    """Equivalent stress sqrt(3/2 s:s), s the deviator of `stress` [MPa], shape [...]."""
    deviator = stress - trace(stress)[..., None, None] / 3.0 * np.eye(3)
    return np.asarray(np.sqrt(1.5 * np.einsum("...ij,...ij->...", deviator, deviator)))


def equivalent_stress(stress: Floats, across: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """What is compared with the yield strength: von Mises stress, or where it is larger what pulls or shears printed layers apart.

    Layers with normal n have the share r of the strength: with t = σn the demand is the largest of σ_vM / σ_y, max(0, n·t) / (r σ_y) and
    |t − (n·t) n| / (r σ_y / √3). Pressure on layers does no harm.

    Of Cauchy stress [MPa], shape [..., 3, 3], and `across` = n / r, shape [3], zero for a material without layers; shape [...].
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
    nodal = displacement[mesh.connectivity]
    at_points = np.einsum("nai,qak->nqik", nodal - nodal[:, :1], mesh.element.derivatives, optimize=True)
    return np.asarray(at_points @ barycentric_gradients(mesh.tets)[:, None])


def lumped_masses(mesh: ElementMesh, masses: Floats) -> Floats:
    """The mass of every tetrahedron, [tet_count], shared out to its nodes [g], shape [node_count]."""
    shares = np.outer(masses, mesh.element.mass_shares)
    return np.asarray(np.bincount(mesh.connectivity.ravel(), shares.ravel(), len(mesh.nodes)), dtype=np.float64)


def stiffness_matrix(mesh: ElementMesh, material: Material, factors: Floats | float = 1.0) -> sparse.csr_array:
    """Small-strain stiffness K = Σ V Bᵀ C B [N/mm], shape [3 node_count, 3 node_count], x, y, z of a node adjacent.

    `factors` are on the stiffness at the Gauss points, shape [tet_count, points].
    """
    gradients, volumes = shape_gradients(mesh), factors * point_volumes(mesh)
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
