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

RIGID_MOTIONS = 6
PRECISE = 1e-4
"""Of the eigenvalues: more than a rule of thumb in periods can use."""

DENSE = 60
"""Unknowns up to which all eigenvalues are worked out."""


def lowest_period(body: Discretisation, material: Material) -> float:
    """T1 = 2π/ω_1 of K x = ω² M x, M the lumped masses, past the rigid motions [ms].

    Shift-invert Lanczos: the shift lies far below ω_1, about a fiftieth of that of a bar as long as the body.

    Raises:
        SimulationFailed: If the stiffness cannot be factorised.
    """
    mesh = body.mesh
    K, masses = stiffness_matrix(mesh, material), np.repeat(body.masses[body.place], 3)
    rigid = RIGID_MOTIONS * _pieces(mesh)
    if len(masses) <= max(DENSE, 2 * rigid):
        root = masses**-0.5
        values = eigvalsh(root[:, None] * K.toarray() * root)
    else:
        slowest = material.bar_wave_speed / float(np.linalg.norm(np.ptp(mesh.nodes, axis=0)))
        values = _near(K.tocsc(), diags_array(masses).tocsc(), (0.02 * slowest) ** 2, rigid + 1)
    return float(2.0 * np.pi / np.sqrt(np.sort(values)[rigid]))


def _near(K: coo_array, M: coo_array, shift: float, count: int) -> np.ndarray:
    """The lowest eigenvalues of K x = ω² M x [1/ms²], from a fixed start."""
    try:
        factor = splu((K + shift * M).tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except (RuntimeError, MemoryError) as error:
        raise SimulationFailed(f"the lowest period of the part could not be found: {error}") from error
    inverse = LinearOperator(K.shape, matvec=factor.solve)
    start = np.random.default_rng(0).standard_normal(K.shape[0])
    return np.asarray(eigsh(K, k=count, M=M, sigma=-shift, OPinv=inverse, v0=start, tol=PRECISE, return_eigenvectors=False))


def _pieces(mesh: ElementMesh) -> int:
    """Pieces that hang together."""
    ends = (mesh.connectivity[:, :-1].ravel(), mesh.connectivity[:, 1:].ravel())
    links = coo_array((np.ones(len(ends[0])), ends), shape=(len(mesh.nodes),) * 2)
    return int(connected_components(links, directed=False, return_labels=False))
