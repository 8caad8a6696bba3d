"""Charts of rows and columns on a part: level on the faces of a box-like part, along smooth lines on any other.

Both charts answer the same two questions in *cells*: the phase along the horizontal and the phase upwards, integers at the cells' centres.
Only what is the same for a phase and its negative is meaningful: distance from the centre and parity counted from it.

A *line field* is a unit tangent up to sign: the horizontal direction at each point of a wall. Lines, unlike arrows, run smoothly
over a rim, on whose two sides "horizontal, with the outside to the right" points in opposite directions. Stripes across a line
field have a phase that is defined up to the same sign; here both signs are settled by one arrow a vertex, so that a phase always
grows along that vertex's arrow.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from mechstyle.records.mesh import Floats, Indices, SurfaceMesh
from mechstyle.styling.drawing.multigrid import Grids
from mechstyle.styling.drawing.operators import Complexes, Operators

KEPT = 8
"""Rows and columns of so many sizes are kept: someone who tries depths and sizes comes back to them."""
_BOX_SHARE, _BOX_COSINE = 0.80, float(np.cos(np.radians(10.0)))


class StripeChart:
    """Rows and columns along a smooth line field, with unit tangents `along` the rows and `up` across them, shape [n, 3]."""

    def __init__(self, operators: Operators) -> None:
        self._operators = operators
        self.along = horizontal_lines(operators)
        self.up = np.cross(operators.mesh.vertex_normals, self.along)
        self._known: dict[tuple[str, float, float], Floats] = {}  # a finer drawing or another depth asks again, and each takes a second

    def columns(self, length: float, margin: float, grip: float) -> Floats:  # noqa: ARG002  (stripes end nowhere)
        """Phase along the horizontal [columns], one every `length` [mm], modulo one, shape [n]; see `stripes` for the grip."""
        asked = ("columns", length, grip)
        if asked not in self._known:
            self._keep(asked, stripes(self._operators, self.along, length, grip=grip))
        return self._known[asked]

    def rows(self, height: float, margin: float) -> Floats:
        """Phase upwards [rows], one every `height` [mm], modulo two, shape [n].

        It is solved at half the frequency, so that the rows' parity is known.
        Rows are stretched a little so that a whole number fills the height from `margin` below the part to as much above it, and on the
        outside of upright walls they start there; the solution is free to slide, so that this costs nothing.
        """
        asked, mesh = ("rows", height, margin), self._operators.mesh
        if asked in self._known:
            return self._known[asked]
        low, extent = mesh.vertices[:, 2].min() - margin, mesh.extents[2] + 2.0 * margin
        period = 2.0 * extent / max(round(extent / height), 1.0)
        wished = (mesh.vertices[:, 2] - low) / period - 0.25
        outwards = mesh.vertices - mesh.vertices.mean(axis=0)
        outside = np.einsum("ij,ij->i", outwards[:, :2], mesh.vertex_normals[:, :2]) > 0.0
        upright = np.linalg.norm(mesh.vertex_normals[:, :2], axis=1) ** 4
        self._keep(asked, 2.0 * stripes(self._operators, self.up, period, start=outside * upright * np.exp(2j * np.pi * wished)))
        return self._known[asked]

    def _keep(self, asked: tuple[str, float, float], phase: Floats) -> None:
        if len(self._known) >= KEPT:
            self._known.pop(next(iter(self._known)))
        self._known[asked] = phase


class BoxChart:
    """Rows and columns by the coordinates of a box, turned about z as the part stands.

    Periods are stretched a little so that whole rows, and half columns, fill the box from `margin` before its first face to as much
    after its last. On every second pair of sides columns start half a length later, so that at a corner the long and short faces of
    bricks alternate. The tangents are those of `StripeChart`; `up` is upwards on walls.
    """

    def __init__(self, mesh: SurfaceMesh) -> None:
        self._axes = box_axes(mesh)
        self._place = mesh.vertices @ self._axes.T
        facing = mesh.vertex_normals @ self._axes.T
        self._face = np.abs(facing).argmax(axis=1)
        lying = (0, 1) if np.ptp(self._place[:, 0]) >= np.ptp(self._place[:, 1]) else (1, 0)
        # For a face across axis 0, 1 or 2: the axes that columns and rows are counted along.
        self._column_axis = np.array([1, 0, lying[0]])[self._face]
        self._row_axis = np.array([2, 2, lying[1]])[self._face]
        self.up = self._axes[self._row_axis]
        outwards = np.sign(facing[np.arange(len(facing)), self._face])[:, None] * self._axes[self._face]
        self.along = np.cross(self.up, outwards)
        self._sense = np.einsum("ij,ij->i", self.along, self._axes[self._column_axis])

    def columns(self, length: float, margin: float, grip: float) -> Floats:  # noqa: ARG002  (columns of a box are all alike)
        """Phase along the horizontal, as of `StripeChart`."""
        phase = self._fitted(self._column_axis, length, 0.5, margin)
        return self._sense * (phase + np.where(self._face == 0, 0.5, 0.0))

    def rows(self, height: float, margin: float) -> Floats:
        """Phase upwards, as of `StripeChart`."""
        return self._fitted(self._row_axis, height, 1.0, margin)

    def _fitted(self, axes: Indices, period: float, unit: float, margin: float) -> Floats:
        """Phase [cells] along each vertex's own axis, the box holding a whole number of `unit` cells."""
        low = self._place.min(axis=0) - margin
        extent = self._place.max(axis=0) + margin - low
        cells = unit * np.maximum(np.round(extent / (unit * period)), 1.0)
        chosen = np.arange(len(axes)), axes
        return np.asarray((self._place[chosen] - low[axes]) / extent[axes] * cells[axes] - 0.5)


Chart = StripeChart | BoxChart
"""Phases of rows and columns, and the directions in which they grow."""


def box_axes(mesh: SurfaceMesh) -> Floats:
    """Orthonormal axes as rows, the last up, turned about z to the walls' common direction (mean of fourfold angles); shape [3, 3]."""
    normal, areas = mesh.face_normals, mesh.face_areas
    yaw = 0.25 * np.angle(np.sum(areas * (normal[:, 0] + 1j * normal[:, 1]) ** 4)) if areas.sum() > 0 else 0.0
    cosine, sine = np.cos(yaw), np.sin(yaw)
    return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def is_prismatic(mesh: SurfaceMesh) -> bool:
    """Whether at least 80 % of the area faces one of the six directions of a box within 10°."""
    facing = np.abs(mesh.face_normals @ box_axes(mesh).T).max(axis=1) >= _BOX_COSINE
    return bool(mesh.face_areas[facing].sum() >= _BOX_SHARE * mesh.face_areas.sum())


def chart_of(operators: Operators) -> Chart:
    """The chart that suits a part: of a box for prismatic parts, of stripes for all others."""
    return BoxChart(operators.mesh) if is_prismatic(operators.mesh) else StripeChart(operators)


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
    system = turning(operators, weights, 2.0 * operators.transport) + sp.diags_array(np.tile(trust, 2))
    real, imaginary = Grids(sp.csr_array(system)).solved(np.concatenate([trust * square.real, trust * square.imag])).reshape(2, -1)
    root = np.sqrt(real + 1j * imaginary)
    root /= np.maximum(np.abs(root), 1e-12)
    lines = root.real[:, None] * x + root.imag[:, None] * y
    against = np.einsum("ij,ij->i", lines, np.where(flat[:, None], axis, wanted)) < 0.0
    return np.asarray(np.where(against[:, None], -lines, lines))


def stripes(operators: Operators, direction: Floats, period: float, *, grip: float = 1.0, start: Complexes | None = None) -> Floats:
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
    energy = turning(operators, weights, 2.0 * np.pi / period * along, sign)
    mass = np.tile(operators.mesh.vertex_areas, 2)
    psi = np.random.default_rng(0).normal(size=2 * count)
    if start is not None:
        psi = 1e-3 * psi + np.concatenate([start.real, start.imag])
    psi = Grids(sp.csr_array(energy + sp.diags_array(1e-6 * mass))).lowest(mass, psi, _INVERSE_ITERATIONS)
    return np.arctan2(psi[count:], psi[:count]) / (2.0 * np.pi)


def turning(operators: Operators, weights: Floats, angles: Floats, sign: Floats | float = 1.0) -> sp.csr_array:
    """Matrix of Σ w |ψ_head − M ψ_tail|² over the edges, M a rotation by an angle [rad], mirrored where the sign is −1.

    ψ is (real, imaginary); angles, weights and signs have shape [edge_count].
    """
    count = len(operators.mesh.vertices)
    first, second = operators.tail.astype(np.int64), operators.head.astype(np.int64)
    cosine, sine = weights * np.cos(angles), weights * np.sin(angles)
    blocks = ((0, 0, cosine), (0, 1, -sine), (1, 0, sign * sine), (1, 1, sign * cosine))
    rows = [second + a * count for a, _, _ in blocks] + [first + b * count for _, b, _ in blocks]
    columns = [first + b * count for _, b, _ in blocks] + [second + a * count for a, _, _ in blocks]
    values = [-value for _, _, value in blocks] * 2
    degree, diagonal = np.bincount(first, weights, count) + np.bincount(second, weights, count), np.arange(2 * count)
    index = (np.concatenate([*rows, diagonal]), np.concatenate([*columns, diagonal]))
    return sp.csr_array((np.concatenate([*values, degree, degree]), index), (2 * count, 2 * count))
