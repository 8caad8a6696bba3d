"""Conjugate gradients (Hestenes and Stiefel 1952) for a matrix that is nearly diagonal, where factors would take longer."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from mechstyle.records.mesh import Floats

TOLERANCE = 1e-8
"""Residual that is left, over the right-hand side, both in the norm of the inverse diagonal."""
MOST_STEPS = 10_000
"""Diffusion over fifteen edges takes 270."""


def solved(matrix: sp.csr_array, right: Floats, start: Floats) -> Floats | None:
    """The solution for one right-hand side, shape [n], preconditioned by the diagonal; None if most steps do not lead to it.

    Sums are einsum's, not BLAS', so that they come out the same on any number of cores.

    Args:
        matrix: Symmetric and positive definite, shape [n, n].
        right: Shape [n].
        start: A guess, shape [n].
    """
    inverse, solution = 1.0 / matrix.diagonal(), start.copy()
    rest = right - matrix @ solution
    goal = TOLERANCE**2 * float(np.einsum("i,i,i", right, inverse, right))
    downhill = inverse * rest
    size = float(np.einsum("i,i", rest, downhill))
    for _ in range(MOST_STEPS):
        if size <= goal:
            return solution
        pushed = matrix @ downhill
        step = size / float(np.einsum("i,i", downhill, pushed))
        solution += step * downhill
        rest -= step * pushed
        before, scaled = size, inverse * rest
        size = float(np.einsum("i,i", rest, scaled))
        downhill = scaled + (size / before) * downhill
    return None
