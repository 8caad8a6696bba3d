"""A style drawn again on a subdivided surface: the same rows, places and pieces as before, with finer edges and finer grain."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from mechstyle.records.mesh import Floats, Indices, SurfaceMesh
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.charts import BoxChart, Chart


class FineCanvas(Canvas):
    """A canvas on a subdivided surface that takes over every decision of the canvas of the coarse surface.

    How large features are, where they lie and which piece gets which tone was decided on the coarse surface, which is the one that
    was restrained and judged; drawn afresh, the pattern would be another one.
    """

    def __init__(self, mesh: SurfaceMesh, interpolation: sp.csr_array, coarse: Canvas) -> None:
        """Prepare to draw.

        Args:
            mesh: The subdivided surface; the coarse vertices come first.
            interpolation: Takes values at the coarse vertices to its own, shape [vertex_count, coarse_count].
            coarse: The canvas of the coarse surface.
        """
        super().__init__(mesh, coarse.seed, colour=coarse.colour, shade=coarse.shade)
        self.scale, self.picture = coarse.scale, coarse.picture
        self._coarse, self._interpolation = coarse, interpolation

    @cached_property
    def chart(self) -> Chart:
        """Chart of rows and columns: that of the coarse surface."""
        chart = self._coarse.chart
        return BoxChart(self.mesh) if isinstance(chart, BoxChart) else FineChart(self.mesh, self._interpolation, chart)

    def unit(self, what: str, finest: float, edges: float = 2.0) -> float:
        """Millimetres per nominal millimetre, as on the coarse surface."""
        return self._coarse.unit(what, finest, edges)

    def scattered(self, spacing: float, salt: str = "", room: float = 0.0) -> Indices:
        """The points scattered on the coarse surface."""
        return self._coarse.scattered(spacing, salt, room)

    def smoothed(self, values: Floats, length: float) -> Floats:
        """Values diffused over `length` [mm], without factors of so large a surface."""
        self.go_on()
        return self.operators.diffused_in_steps(values, length)

    def pieces(self, inside: NDArray[np.bool_], label: NDArray[np.generic] | None = None) -> Indices:
        """Identity of the connected piece each vertex is in: that of the coarse piece it shares most vertices with, or a new one."""
        count, asked = len(self._coarse.points), len(self.found_pieces)
        fine = super().pieces(inside, label)
        # Where it was drawn before, its edges lay a little otherwise: pieces looked for anew would bear other numbers, and get other tones.
        known = self._coarse.found_pieces[asked : asked + 1]
        coarse = known[0] if known else self._coarse.pieces(inside[:count], None if label is None else label[:count])
        identity = np.arange(int(fine.max()) + 1) + int(coarse.max()) + 1
        shared, times = np.unique(np.stack([fine[:count], coarse], axis=1), axis=0, return_counts=True)
        rising = np.argsort(times, kind="stable")  # so that of several coarse pieces the one with most vertices is written last
        identity[shared[rising, 0]] = shared[rising, 1]
        return np.asarray(identity[fine], dtype=np.int32)


class FineChart:
    """Rows and columns of a coarse chart between its vertices.

    Attributes:
        along: Unit tangent along the rows, shape [vertex_count, 3].
        up: Unit tangent across the rows, upwards, shape [vertex_count, 3].
    """

    def __init__(self, mesh: SurfaceMesh, interpolation: sp.csr_array, coarse: Chart) -> None:
        self._coarse, matrix = coarse, interpolation
        first, of, row = matrix.indices[matrix.indptr[:-1]], matrix.indices, np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
        # The arrows of neighbours may point against each other, and their phases are then of opposite sign.
        against = np.einsum("ij,ij->i", coarse.along[first][row], coarse.along[of]) < 0.0
        self._sign, self._of, self._row, self._weight = np.where(against, -1.0, 1.0), of, row, matrix.data
        signed = sp.csr_array((matrix.data * self._sign, matrix.indices, matrix.indptr), shape=matrix.shape)
        mean = signed @ coarse.along
        tangent = mean - np.einsum("ij,ij->i", mean, mesh.vertex_normals)[:, None] * mesh.vertex_normals
        length = np.linalg.norm(tangent, axis=1, keepdims=True)
        self.along: Floats = np.where(length > 1e-9, tangent / np.maximum(length, 1e-9), coarse.along[first])
        self.up: Floats = np.cross(mesh.vertex_normals, self.along)

    def columns(self, length: float, margin: float, grip: float) -> Floats:
        """Phase along the horizontal; see `Chart`."""
        return self._between(self._coarse.columns(length, margin, grip), 1.0)

    def rows(self, height: float, margin: float) -> Floats:
        """Phase upwards; see `Chart`."""
        return self._between(self._coarse.rows(height, margin), 2.0)

    def _between(self, phase: Floats, period: float) -> Floats:
        """The phase between those of the coarse vertices around, the shorter way round."""
        angle, count = 2.0 * np.pi / period * phase, len(self.along)
        turned = self._sign * angle[self._of]
        real, imaginary = (np.bincount(self._row, self._weight * part, count) for part in (np.cos(turned), np.sin(turned)))
        return np.asarray(period / (2.0 * np.pi) * np.arctan2(imaginary, real))
