"""The lowest elastic period of a free body: how long the whole of it takes to swing once."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigvalsh
from scipy.sparse import coo_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from mechstyle.errors import SimulationFailed
from mechstyle.fea.discretisation import Discretisation
from mechstyle.fea.elasticity import stiffness_matrix
from mechstyle.fea.elements import ElementMesh
from mechstyle.records.material import Material
from mechstyle.records.mesh import Floats

PRECISE = 1e-4
"""Of the eigenvalues: more than a rule of thumb in periods can use."""

DENSE = 60
"""Unknowns up to which all eigenvalues are worked out."""


def lowest_period(body: Discretisation, material: Material) -> float:
    """T1 = 2π/ω_1 of K x = ω² M x, M the lumped masses, past the rigid motions [ms].

    Shift-invert Lanczos: the shift lies far below ω_1, about a fiftieth of that of a bar as long as the body. Rigid motions, known
    beforehand, are taken out of it: which copies of an eigenvalue that is there many times are found hangs on rounding.

    Raises:
        SimulationFailed: If the stiffness cannot be factorised.
    """
    mesh = body.mesh
    K, masses = stiffness_matrix(mesh, material), np.repeat(body.masses[body.place], 3)
    rigid = _rigid_motions(mesh, masses)
    if len(masses) <= max(DENSE, 2 * rigid.shape[1]):
        root = masses**-0.5
        lowest = float(np.sort(eigvalsh(root[:, None] * K.toarray() * root))[rigid.shape[1]])
    else:
        slowest = material.bar_wave_speed / float(np.linalg.norm(np.ptp(mesh.nodes, axis=0)))
        lowest = _lowest_past(rigid, K.tocsc(), masses, (0.02 * slowest) ** 2)
    return float(2.0 * np.pi / np.sqrt(lowest))


def _lowest_past(rigid: Floats, K: coo_array, masses: Floats, shift: float) -> float:
    """The lowest eigenvalue of K x = ω² M x [1/ms²] whose x is M-orthogonal to the rigid motions, from a fixed start."""
    M = diags_array(masses).tocsc()
    try:
        factor = splu((K + shift * M).tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except (RuntimeError, MemoryError) as error:
        raise SimulationFailed(f"the lowest period of the part could not be found: {error}") from error

    def elastic(x: Floats) -> Floats:
        return np.asarray(x - rigid @ (rigid.T @ (masses * x)))

    inverse = LinearOperator(K.shape, matvec=lambda x: elastic(factor.solve(x)), dtype=np.float64)
    start = elastic(np.random.default_rng(0).standard_normal(K.shape[0]))
    return float(eigsh(K, k=1, M=M, sigma=-shift, OPinv=inverse, v0=start, tol=PRECISE, return_eigenvectors=False)[0])


def _rigid_motions(mesh: ElementMesh, masses: Floats) -> Floats:
    """Translations and rotations of each piece, M-orthonormal, shape [3 · node_count, 6 · piece_count].

    Args:
        mesh: The elements.
        masses: Diagonal of M [g], shape [3 · node_count].
    """
    ends = (mesh.connectivity[:, :-1].ravel(), mesh.connectivity[:, 1:].ravel())
    links = coo_array((np.ones(len(ends[0])), ends), shape=(len(mesh.nodes),) * 2)
    pieces, piece = connected_components(links, directed=False)
    root, motions = np.sqrt(masses), []
    for number in range(pieces):
        inside = (piece == number)[:, None]
        about = mesh.nodes - mesh.nodes[inside[:, 0]].mean(axis=0)
        fields = [motion for axis in np.eye(3) for motion in (np.broadcast_to(axis, about.shape), np.cross(axis, about))]
        own = np.stack([(inside * motion).ravel() for motion in fields], axis=1)
        motions.append(np.linalg.qr(root[:, None] * own)[0] / root[:, None])
    return np.concatenate(motions, axis=1)
