"""Making a part ready in a process of its own: remeshing holds the interpreter for seconds, and a kernel must answer meanwhile."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mechstyle.errors import SimulationFailed
from mechstyle.geometry.cancelling import CancelCheck
from mechstyle.geometry.thickness import local_thickness
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation.part import Relief, Shape, Stage, Workpiece, prepare, standardised
from mechstyle_widgets.jupyter.worker_process import Aside


def prepare_aside(
    mesh: SurfaceMesh, vertices: int, stage: Stage, go_on: CancelCheck, relief: Relief | None = None
) -> Workpiece:
    """As `simulation.part.prepare`, in another process.

    Args:
        mesh: A closed surface [mm].
        vertices: Vertices of the standardised surface.
        stage: Called with what is being done, in words.
        go_on: Called ten times a second; what it raises ends the work.
        relief: The finished relief it is to carry, by a function that can be pickled; None for none.

    Raises:
        MechStyleError: What the preparation itself refuses, in its own words.
    """
    for word in Aside(_prepare, mesh, vertices, relief).said(go_on):
        if isinstance(word, Workpiece):
            return word
        stage(word)
    raise SimulationFailed("making the part ready ended without an answer: it may need more memory; ask for fewer vertices")


def _prepare(say: Callable[[object], None], mesh: SurfaceMesh, vertices: int, relief: Relief | None) -> None:
    """Work of the other process: report the stages, then return the part."""
    say(prepare(mesh, vertices=vertices, stage=say, relief=relief))


def shape_aside(mesh: SurfaceMesh, vertices: int, go_on: Callable[[], None]) -> Shape:
    """A part as far as a style needs it ready, made in another process: remeshing would keep the kernel from answering.

    Args:
        mesh: A closed surface [mm].
        vertices: Vertices of the standardised surface.
        go_on: Called ten times a second; what it raises ends the work.
    """
    for shape in Aside(_shape, mesh, vertices).said(go_on):
        if isinstance(shape, Shape):
            return shape
    raise SimulationFailed("making the part ready for a preview ended without an answer: it may need more memory")


def _shape(say: Callable[[object], None], mesh: SurfaceMesh, vertices: int) -> None:
    """Work of the other process: what a style needs."""
    surface = standardised(mesh, vertices)
    shape = Shape(surface, local_thickness(surface).astype(np.float32))
    _ = shape.level_base, shape.is_container
    say(shape)
