"""Hyperelasticity on tetrahedra in readable float64 numpy: the reference that the fast kernels are tested against."""

import numpy as np

from mechstyle.fea.elasticity import StableNeoHookean, displacement_gradients, point_volumes, shape_gradients, trace


def energy_density(law, H):
    """Ψ(H) [MPa = mJ/mm³], zero for H = 0, shape [...]; H has shape [..., 3, 3]."""
    if not isinstance(law, StableNeoHookean):
        E = green_strain(H)
        return 0.5 * law.la * trace(E) ** 2 + law.mu * np.einsum("...ij,...ij->...", E, E)
    q, volume_change = invariants(H)
    square = np.einsum("...ij,...ij->...", H, H)
    shape = square - 2.0 * (volume_change - trace(H))
    return 0.375 * law.mu * shape + 0.5 * law.mu * (0.25 * q - np.log1p(0.25 * q)) + 0.5 * law.la * volume_change**2


def first_piola(law, H):
    """First Piola–Kirchhoff stress P = ∂Ψ/∂H [MPa], shape [..., 3, 3]."""
    if not isinstance(law, StableNeoHookean):
        E = green_strain(H)
        S = law.la * trace(E)[..., None, None] * np.eye(3) + 2.0 * law.mu * E
        return S + H @ S
    q, volume_change = (value[..., None, None] for value in invariants(H))
    cof, spherical = cofactor(H), trace(H)[..., None, None] * np.eye(3)
    transposed = np.swapaxes(H, -1, -2)
    cof_F = np.eye(3) + spherical - transposed + cof
    shape = H + transposed - spherical - cof
    return 0.75 * law.mu * shape + law.mu * q / (4.0 * (4.0 + q)) * (np.eye(3) + H) + law.la * volume_change * cof_F


def invariants(H):
    """Both of q = I_C − 3 and J − 1, each of shape [...]."""
    return 2.0 * trace(H) + np.einsum("...ij,...ij->...", H, H), trace(H) + trace(cofactor(H)) + np.linalg.det(H)


def cofactor(A):
    """The cofactors cof A = det(A) A⁻ᵀ, defined for singular A too, shape [..., 3, 3]."""
    a, b, c = A[..., 0, :], A[..., 1, :], A[..., 2, :]
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-2)


def green_strain(H):
    """E = (H + Hᵀ + HᵀH)/2, shape [..., 3, 3]."""
    transposed = np.swapaxes(H, -1, -2)
    return 0.5 * (H + transposed + transposed @ H)


def cauchy_stress(H, P):
    """Cauchy stress σ = P Fᵀ / J [MPa], shape [..., 3, 3]."""
    J = 1.0 + trace(H) + trace(cofactor(H)) + np.linalg.det(H)
    return (P + P @ np.swapaxes(H, -1, -2)) / J[..., None, None]


def strain_energy(mesh, law, displacement):
    """U = Σ V Ψ(H) [mJ]."""
    return float((point_volumes(mesh) * energy_density(law, displacement_gradients(mesh, displacement))).sum())


def internal_forces(mesh, law, displacement):
    """Forces the deformed body exerts on its nodes, f_a = −Σ V P ∇N_a = −∂U/∂u_a [N], shape [node_count, 3]."""
    return forces_of(mesh, law, displacement_gradients(mesh, displacement))


def forces_of(mesh, law, gradients):
    """As `internal_forces`, of displacement gradients H at the Gauss points, shape [tet_count, points, 3, 3]."""
    P = first_piola(law, gradients)
    shares = -np.einsum("nq,nqij,nqaj->nai", point_volumes(mesh), P, shape_gradients(mesh))
    forces = np.zeros_like(mesh.nodes)
    np.add.at(forces, mesh.connectivity, shares)
    return forces
