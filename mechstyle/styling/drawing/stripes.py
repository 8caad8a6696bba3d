"""Directions and stripes on a curved surface without unwrapping it.

A *line field* is a unit tangent up to sign: the horizontal direction at each point of a wall. Lines, unlike arrows, run smoothly
over a rim, on whose two sides "horizontal, with the outside to the right" points in opposite directions. Stripes across a line
field have a phase that is defined up to the same sign; here both signs are settled by one arrow a vertex, so that a phase always
grows along that vertex's arrow.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawing.dissection import Factors
from mechstyle.styling.drawing.operators import Complexes, Operators

UP = np.array([0.0, 0.0, 1.0])

_FLAT = 0.2  # sine of the slope below which a patch counts as horizontal
_ALIGNMENT_LENGTH = 2.0  # how far smoothness outweighs alignment at a slope of 45° [edge lengths]
_INVERSE_ITERATIONS = 10


def horizontal_lines(operators: Operators) -> Floats:
    """Unit tangents along the horizontal, up × n on walls, a world axis on horizontal patches, smooth between; shape [n, 3].

    The smoothest line field near the wanted one: its square in complex frame coordinates solves a linear system with the
    connection Laplacian (Knöppel, Crane, Pinkall and Schröder 2013). The arrow of each line is the one with n × t upwards.
    """
    normal, areas = operators.mesh.vertex_normals, operators.mesh.vertex_areas
    wanted = np.cross(UP, normal)
    slope = np.linalg.norm(wanted, axis=1)
    flat = slope < _FLAT
    axis = np.eye(3)[0 if operators.mesh.extents[0] >= operators.mesh.extents[1] else 1]
    wanted[flat] = axis - (normal[flat] @ axis)[:, None] * normal[flat]
    # The square of the tangent of the slope: a wall knows where the horizontal is, a gentle dome hardly.
    steepness = np.where(flat, 1.0, slope**2 / (1.02 - slope**2))
    trust = steepness * areas / (_ALIGNMENT_LENGTH * operators.mesh.edge_length) ** 2

    x, y = operators.frames
    square = (np.einsum("ij,ij->i", wanted, x) + 1j * np.einsum("ij,ij->i", wanted, y)) ** 2
    square /= np.maximum(np.abs(square), 1e-12)
    bend = np.einsum("ij,ij->i", normal[operators.tail], normal[operators.head])
    weights = operators.weights * np.maximum(bend, 0.1) ** 4  # a floor should not turn the lines of the wall it meets
    system = operators.connection(2.0 * operators.transport, weights) + sp.diags_array(trust)
    root = np.sqrt(Factors(system, operators.order).solve(trust * square))
    root /= np.maximum(np.abs(root), 1e-12)
    lines = root.real[:, None] * x + root.imag[:, None] * y
    against = np.einsum("ij,ij->i", lines, np.where(flat[:, None], axis, wanted)) < 0.0
    return np.asarray(np.where(against[:, None], -lines, lines))


def stripes(
    operators: Operators, direction: Floats, period: float, *, grip: float = 1.0, start: Complexes | None = None
) -> Floats:
    """Phase of stripes [cycles] that grows by one every `period` [mm] along `direction`, a line field with arrows; shape [n], in [-½, ½].

    The smallest eigenvector of the energy of Knöppel et al. (2015), by inverse iteration from a fixed start. Where the arrows of an
    edge's ends point against each other the phases are compared mirrored. Edges across which the lines themselves disagree (a floor
    meeting a wall) hold little, so that the stripes break there rather than bend everywhere.

    Args:
        operators: Of the surface.
        direction: Unit tangents, shape [n, 3].
        period: Width of one stripe [mm].
        grip: How firmly a stripe holds on to itself along its own length, in (0, 1]. Below 1 stripes rather end than get narrower
            where the surface does; neighbouring rows of bricks may differ in number, ribs may not.
        start: Wished waves e^{2πi phase} times how much they matter, shape [n]; of all equally smooth solutions the one most like them
            is found. Without it, any.
    """
    count, tail, head = len(operators.mesh.vertices), operators.tail, operators.head
    agreement = np.einsum("ij,ij->i", operators.carried(direction[tail]), direction[head])
    sign = np.where(agreement < 0.0, -1.0, 1.0)
    along = np.einsum("ij,ij->i", operators.edge_vectors, 0.5 * (direction[tail] + sign[:, None] * direction[head]))
    across = along**2 / np.maximum((operators.edge_vectors**2).sum(axis=1), 1e-24)  # an edge may have no length
    weights = operators.weights * np.maximum(agreement**2, 0.01) ** 4 * (grip + (1.0 - grip) * across)
    energy = _stripe_energy(count, operators, 2.0 * np.pi / period * along, sign, weights)

    mass = np.tile(operators.mesh.vertex_areas, 2)
    both = np.stack([operators.order, operators.order + count], axis=1).ravel()
    solver = Factors(energy + sp.diags_array(1e-6 * mass), both)
    psi = np.random.default_rng(0).normal(size=2 * count)
    if start is not None:
        psi = 1e-3 * psi + np.concatenate([start.real, start.imag])
    for _ in range(_INVERSE_ITERATIONS):
        psi = solver.solve(mass * psi)
        psi /= np.sqrt(mass @ psi**2)
    return np.arctan2(psi[count:], psi[:count]) / (2.0 * np.pi)


def _stripe_energy(count: int, operators: Operators, turn: Floats, sign: Floats, weights: Floats) -> sp.csr_array:
    """Symmetric matrix of Σ w |ψ_head − M ψ_tail|², M a rotation by `turn`, mirrored where `sign` is −1; ψ as (real, imaginary)."""
    tail, head = operators.tail.astype(np.int64), operators.head.astype(np.int64)
    cosine, sine = weights * np.cos(turn), weights * np.sin(turn)
    blocks: tuple[tuple[int, int, NDArray[np.float64]], ...] = (
        (0, 0, cosine), (0, 1, -sine), (1, 0, sign * sine), (1, 1, sign * cosine),
    )
    rows = [head + a * count for a, _, _ in blocks] + [tail + b * count for _, b, _ in blocks]
    columns = [tail + b * count for _, b, _ in blocks] + [head + a * count for a, _, _ in blocks]
    values = [-value for _, _, value in blocks] * 2
    degree = np.bincount(tail, weights, count) + np.bincount(head, weights, count)
    diagonal = np.arange(2 * count)
    index = (np.concatenate([*rows, diagonal]), np.concatenate([*columns, diagonal]))
    return sp.csr_array((np.concatenate([*values, degree, degree]), index), (2 * count, 2 * count))
