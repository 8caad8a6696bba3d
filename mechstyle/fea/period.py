"""The lowest elastic period of a free body: how long the whole of it takes to swing once."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh, eigvalsh
from scipy.sparse import bsr_array, coo_array, csr_array, diags_array, eye_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from mechstyle.errors import SimulationFailed
from mechstyle.fea.discretisation import Discretisation
from mechstyle.fea.stiffness import TwoLevel, linear_fields
from mechstyle.records.mesh import Floats

PRECISE = 1e-5
"""Of the eigenvalue, as the preconditioner has it, which may be ten times too good: more than a rule of thumb in periods can use."""

DENSE = 60
"""Unknowns up to which all eigenvalues are worked out."""

BLOCK = 3
"""Vectors that are sought together: a cup has its lowest eigenvalue twice, and others close by."""

MOST_ROUNDS = 20
"""Rounds of the search. Where the tetrahedra of a plate are ten times as wide as high the preconditioner, whose linear fields hardly
bend, is no good, and the equations are factorised after all."""


def lowest_period(body: Discretisation) -> float:
    """T1 = 2π/ω_1 of K x = ω² M x, M the lumped masses, past the rigid motions [ms].

    Rigid motions, known beforehand, are taken out: which copies of an eigenvalue that is there many times are found hangs on rounding.

    Raises:
        SimulationFailed: If the equations cannot be factorised, or the eigenvalue is not found.
    """
    root = np.repeat(body.masses, 3) ** -0.5
    matrix = body.stiffness.matrix()
    rows, columns = np.repeat(np.arange(len(body.masses)), np.diff(matrix.indptr)), matrix.indices
    matrix.data *= root.reshape(-1, 3)[rows][:, :, None] * root.reshape(-1, 3)[columns][:, None, :]
    rigid = _rigid_motions(body)
    if len(root) <= max(DENSE, 2 * rigid.shape[1]):
        lowest = float(np.sort(eigvalsh(matrix.toarray()))[rigid.shape[1]])
    else:
        slowest = body.stiffness.material.bar_wave_speed / float(np.linalg.norm(np.ptp(body.positions, axis=0)))
        fields = csr_array(diags_array(1.0 / root) @ linear_fields(body.connectivity, len(body.masses)))
        shift = (0.02 * slowest) ** 2  # far below that of a bar as long
        lowest = _lowest_past(rigid, matrix, TwoLevel(matrix, fields, shift)) or _by_factors(rigid, matrix, shift)
    return float(2.0 * np.pi / np.sqrt(lowest))


def _lowest_past(rigid: Floats, matrix: bsr_array, preconditioner: TwoLevel) -> float | None:
    """The lowest eigenvalue θ of A whose vector is orthogonal to the rigid motions [1/ms²], from a fixed start; None if it is not found.

    Davidson's method (1975), with some vectors at a time: of all that were found the lowest combinations are taken, and what is left over
    of them, r = A x − θ x, is added after preconditioning. Rayleigh and Ritz bound the eigenvalue from above, by about rᵀ A⁻¹ r.
    """
    start = np.random.default_rng(0).standard_normal((len(rigid), BLOCK))
    found = _beside(rigid, preconditioner(start))
    images = matrix @ found
    for _ in range(MOST_ROUNDS):
        values, mix = eigh(found.T @ images, subset_by_index=(0, BLOCK - 1))
        vectors, moved = found @ mix, images @ mix
        rest = moved - values * vectors
        towards = preconditioner(rest)
        if rest[:, 0] @ towards[:, 0] <= PRECISE * values[0]:
            return float(values[0])
        added = _beside(np.concatenate([rigid, found], axis=1), towards)
        found, images = np.concatenate([found, added], axis=1), np.concatenate([images, matrix @ added], axis=1)
    return None


def _by_factors(rigid: Floats, matrix: bsr_array, shift: float) -> float:
    """As `_lowest_past` by shift-invert Lanczos, which takes up to minutes."""
    try:
        shifted = (matrix + shift * eye_array(len(rigid), format="bsr")).tocsc()
        factor = splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except (RuntimeError, MemoryError) as error:
        raise SimulationFailed(f"the lowest period of the part could not be found: {error}") from error

    def elastic(x: Floats) -> Floats:
        return np.asarray(x - rigid @ (rigid.T @ x))

    inverse = LinearOperator(matrix.shape, matvec=lambda x: elastic(factor.solve(x)), dtype=np.float64)
    start = elastic(np.random.default_rng(0).standard_normal(len(rigid)))
    return float(eigsh(matrix, k=1, sigma=-shift, OPinv=inverse, v0=start, tol=PRECISE, return_eigenvectors=False)[0])


def _beside(known: Floats, vectors: Floats) -> Floats:
    """Vectors made orthonormal to each other and to orthonormal ones that are known; twice, because once leaves rounding."""
    for _ in range(2):
        vectors = np.linalg.qr(vectors - known @ (known.T @ vectors))[0]
    return vectors


def _rigid_motions(body: Discretisation) -> Floats:
    """Translations and rotations of each piece, times √m and then orthonormal, shape [3 · node_count, 6 · piece_count]."""
    connectivity, nodes, weights = body.connectivity, body.positions, np.repeat(np.sqrt(body.masses), 3)
    ends = (connectivity[:, :-1].ravel(), connectivity[:, 1:].ravel())
    links = coo_array((np.ones(len(ends[0])), ends), shape=(len(nodes),) * 2)
    pieces, piece = connected_components(links, directed=False)
    motions = []
    for number in range(pieces):
        inside = (piece == number)[:, None]
        about = nodes - nodes[inside[:, 0]].mean(axis=0)
        fields = [motion for axis in np.eye(3) for motion in (np.broadcast_to(axis, about.shape), np.cross(axis, about))]
        own = np.stack([(inside * motion).ravel() for motion in fields], axis=1)
        motions.append(np.linalg.qr(weights[:, None] * own)[0])
    return np.concatenate(motions, axis=1)
