"""Equations of a body: a preconditioner in two levels, K x = f by conjugate gradients, and the lowest elastic period, K x = ω² M x.

K of a held body is solved precisely for few right sides, that of a free one nearly for many.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, eigvalsh
from scipy.sparse import bsr_array, coo_array, csc_array, csr_array, diags_array, eye_array, kron
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, cg, eigsh, splu

from mechstyle.errors import SimulationFailed
from mechstyle.fea.discretisation import Discretisation
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

    `connectivity` has the nodes of each tetrahedron, shape [tet_count, nodes].
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
    """An approximate inverse of a symmetric positive (semi-)definite matrix A; symmetric and positive definite itself.

    `fields` are the linear fields, shape [n, m]. A shift is added where A is solved for them, so that a singular one can be;
    SimulationFailed if that matrix cannot be factorised.
    """

    def __init__(self, matrix: bsr_array | csr_array, fields: csr_array, shift: float = 0.0) -> None:
        self._matrix, self._fields = matrix.astype(np.float32), fields.astype(np.float32)  # what is about right may be rounded
        coarse = (fields.T @ (matrix.tocsr() @ fields) + shift * (fields.T @ fields)).tocsc()
        try:
            self._solve = _factors(coarse)
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
        linear = self._fields @ self._solve((self._fields.T @ rest).astype(np.float64)).astype(np.float32)
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


FACTORISED = 6_000
"""Unknowns up to which equations are factorised, which then takes a part of a second."""
LEFT_OVER, ITERATIONS = 1e-10, 400
"""Residual over the right side at which a solution is taken, as good as by factors; 25 to 40 iterations were counted."""


class Solver:
    """Solves A x = b for a symmetric positive definite matrix, again and again.

    Conjugate gradients, with the linear fields solved for directly: of 6500 tetrahedra the factors of A take ten times the memory and five
    times the time, and both grow faster than the mesh. Small systems, and one that does not converge, are factorised.

    Args:
        matrix: A, shape [n, n].
        fields: The linear fields, shape [n, m].

    Raises:
        RuntimeError, MemoryError: If A cannot be factorised.
    """

    def __init__(self, matrix: csr_array, fields: csr_array) -> None:
        self._matrix, self._two_level = matrix, None
        some = np.flatnonzero(abs(fields).sum(axis=0))  # what is left of a field where supports hold all of it is none
        if matrix.shape[0] > FACTORISED and len(some) < matrix.shape[0]:
            with suppress(SimulationFailed):  # two fields are one where supports hold what tells them apart
                self._two_level = TwoLevel(matrix, fields[:, some])
        if self._two_level is None:
            _ = self._exactly

    def nearly(self, right: Floats) -> Floats:
        """About A⁻¹ b, symmetric and positive definite, of shape [n]."""
        return self._exactly(right) if self._two_level is None else self._two_level(right[:, None])[:, 0]

    def __call__(self, right: Floats) -> Floats:
        """A⁻¹ b, of shape [n]."""
        if self._two_level is None:
            return self._exactly(right)
        inverse = LinearOperator(self._matrix.shape, matvec=lambda right: self.nearly(right.ravel()), dtype=np.float64)
        found, wrong = cg(self._matrix, right, rtol=LEFT_OVER, atol=0.0, M=inverse, maxiter=ITERATIONS)
        return self._exactly(right) if wrong else np.asarray(found)

    @cached_property
    def _exactly(self) -> Callable[[Floats], Floats]:
        return _factors(self._matrix.tocsc())


def _factors(matrix: csc_array) -> Callable[[Floats], Floats]:
    """What solves A x = b by the factors of a symmetric positive definite matrix."""
    return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve


ENOUGH = 1e-5
"""Error in the norm of energy over that of the solution, as the preconditioner has it, at which a free body is solved."""


class FreeBody:
    """Solves K x = f of a body that nothing holds, for loads in equilibrium; prepared once.

    Each load is solved for by itself: what it leaves is the same to the bit, whatever is asked for with it. Together is no quicker.
    """

    def __init__(self, body: Discretisation) -> None:
        self._matrix, self._body = body.stiffness.matrix(), body
        self._shift = _far_below_a_bar(body)
        self._root, self._rigid = np.repeat(np.sqrt(body.masses), 3)[:, None], _rigid_motions(body)
        self._nearly = TwoLevel(self._matrix, linear_fields(body.connectivity, len(body.masses)), self._shift * float(body.masses.mean()))

    def displacement(self, loads: Floats) -> Floats:
        """Displacements without motion as a whole [mm] under loads [N], both of shape [loads, 3 node_count].

        Raises:
            SimulationFailed: If the equations cannot be solved.
        """
        if not np.isfinite(loads).all():
            raise SimulationFailed("what a load leaves could not be found: it is not a finite number")
        return np.stack([self._solved(load[:, None])[:, 0] for load in loads])

    def _solved(self, load: Floats) -> Floats:
        found = _by_conjugate_gradients(self._matrix, self._nearly, load)
        if found is None:  # flat tetrahedra, see MOST_ROUNDS
            found = _by_conjugate_gradients(self._matrix, self._factors, load)
        if found is None:
            raise SimulationFailed("what a load leaves could not be found: its equations were not solved")
        return np.asarray(found - self._rigid @ (self._rigid.T @ (self._root * found)) / self._root)

    @cached_property
    def _factors(self) -> Callable[[Floats], Floats]:
        """As good as the inverse, past the motions as a whole, which a shift alone holds."""
        try:
            return _factors((self._matrix + self._shift * diags_array(self._root[:, 0] ** 2)).tocsc())
        except (RuntimeError, MemoryError) as error:
            raise SimulationFailed(f"the equations of the part could not be factorised: {error}") from error


def _by_conjugate_gradients(matrix: bsr_array, preconditioner: Callable[[Floats], Floats], right: Floats) -> Floats | None:
    """A x = b of a right side, shape [n, 1]; None if it takes too many steps, or A or the preconditioner is not positive definite."""
    found, rest = np.zeros_like(right), right.copy()
    towards = preconditioner(rest)
    way, size = towards, _dot(rest, towards)
    first = size
    for _ in range(ITERATIONS):
        if size <= ENOUGH**2 * first:
            return found
        image = matrix @ way
        energy = _dot(way, image)
        if not energy > 0.0:  # along a motion as a whole, or no number: it leads nowhere
            return None
        step = size / energy
        found, rest = found + step * way, rest - step * image
        towards, before = preconditioner(rest), size
        size = _dot(rest, towards)
        way = towards + size / before * way
    return None


def _dot(one: Floats, other: Floats) -> float:
    return float(np.einsum("nc,nc->", one, other))  # in one thread: the same sum on every machine


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
        fields = csr_array(diags_array(1.0 / root) @ linear_fields(body.connectivity, len(body.masses)))
        shift = _far_below_a_bar(body)
        lowest = _lowest_past(rigid, matrix, TwoLevel(matrix, fields, shift)) or _by_factors(rigid, matrix, shift)
    return float(2.0 * np.pi / np.sqrt(lowest))


def _far_below_a_bar(body: Discretisation) -> float:
    """An eigenvalue of K x = ω² M x far below those of a bar as long as the body [1/ms²]."""
    length = float(np.linalg.norm(np.ptp(body.positions, axis=0)))
    return (0.02 * body.stiffness.material.bar_wave_speed / length) ** 2


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
        solve = _factors(shifted)
    except (RuntimeError, MemoryError) as error:
        raise SimulationFailed(f"the lowest period of the part could not be found: {error}") from error

    def elastic(x: Floats) -> Floats:
        return np.asarray(x - rigid @ (rigid.T @ x))

    inverse = LinearOperator(matrix.shape, matvec=lambda x: elastic(solve(x)), dtype=np.float64)
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
