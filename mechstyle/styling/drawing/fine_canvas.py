"""A style drawn again on a quartered surface: the same rows, places and pieces as before, with finer edges and finer grain."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mechstyle.records.mesh import Floats, Indices, SurfaceMesh
from mechstyle.styling.drawing.canvas import Canvas
from mechstyle.styling.drawing.charts import BoxChart, Chart


class FineCanvas(Canvas):
    """A canvas on a quartered surface that takes over every decision of the canvas of the coarse surface.

    How large features are, where they lie and which piece gets which tone was decided on the coarse surface, which is the one that
    was restrained and judged; drawn afresh, the pattern would be another one.
    """

    def __init__(self, mesh: SurfaceMesh, parents: Indices, coarse: Canvas) -> None:
        """Prepare to draw.

        Args:
            mesh: The quartered surface; the coarse vertices come first.
            parents: The two coarse vertices each of its vertices lies between, shape [vertex_count, 2].
            coarse: The canvas of the coarse surface.
        """
        super().__init__(mesh, coarse.seed, colour=coarse.colour, shade=coarse.shade)
        self.scale, self.picture = coarse.scale, coarse.picture
        self._coarse, self._parents = coarse, parents

    @cached_property
    def chart(self) -> Chart:
        """Chart of rows and columns: that of the coarse surface."""
        chart = self._coarse.chart
        return BoxChart(self.mesh) if isinstance(chart, BoxChart) else FineChart(self.mesh, self._parents, chart)

    def unit(self, what: str, finest: float, edges: float = 2.0) -> float:
        """Millimetres per nominal millimetre, as on the coarse surface."""
        return self._coarse.unit(what, finest, edges)

    def scattered(self, spacing: float, salt: str = "", room: float = 0.0) -> Indices:
        """The points scattered on the coarse surface."""
        return self._coarse.scattered(spacing, salt, room)

    def pieces(self, inside: NDArray[np.bool_], label: NDArray[np.generic] | None = None) -> Indices:
        """Identity of the connected piece each vertex is in: that of the coarse piece it shares most vertices with, or a new one."""
        count = len(self._coarse.points)
        fine = super().pieces(inside, label)
        coarse = self._coarse.pieces(inside[:count], None if label is None else label[:count])
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

    def __init__(self, mesh: SurfaceMesh, parents: Indices, coarse: Chart) -> None:
        self._coarse, self._parents = coarse, parents
        one, other = coarse.along[parents[:, 0]], coarse.along[parents[:, 1]]
        # The arrows of neighbours may point against each other, and their phases are then of opposite sign.
        self._sign = np.where(np.einsum("ij,ij->i", one, other) < 0.0, -1.0, 1.0)
        mean = one + self._sign[:, None] * other
        tangent = mean - np.einsum("ij,ij->i", mean, mesh.vertex_normals)[:, None] * mesh.vertex_normals
        length = np.linalg.norm(tangent, axis=1, keepdims=True)
        self.along: Floats = np.where(length > 1e-9, tangent / np.maximum(length, 1e-9), one)
        self.up: Floats = np.cross(mesh.vertex_normals, self.along)

    def columns(self, length: float, margin: float, grip: float) -> Floats:
        """Phase along the horizontal; see `Chart`."""
        return self._between(self._coarse.columns(length, margin, grip), 1.0)

    def rows(self, height: float, margin: float) -> Floats:
        """Phase upwards; see `Chart`."""
        return self._between(self._coarse.rows(height, margin), 2.0)

    def _between(self, phase: Floats, period: float) -> Floats:
        """The phase half way between those of the parents, the shorter way round."""
        angle = 2.0 * np.pi / period * phase
        waves = np.exp(1j * angle[self._parents[:, 0]]) + np.exp(1j * self._sign * angle[self._parents[:, 1]])
        return np.asarray(period / (2.0 * np.pi) * np.angle(waves))
