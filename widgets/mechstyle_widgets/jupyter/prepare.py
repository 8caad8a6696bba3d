"""Making a part ready in a process of its own: remeshing holds the interpreter for seconds, and a kernel must answer meanwhile."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mechstyle.errors import SimulationFailed
from mechstyle.geometry.cancelling import CancelCheck
from mechstyle.geometry.thickness import local_thickness
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation.part import Relief, Shape, Stage, Workpiece, prepare, standardised, standardised_before
from mechstyle_widgets.jupyter.worker_process import WorkerProcess


def prepare_in_worker(mesh: SurfaceMesh, vertices: int, stage: Stage, go_on: CancelCheck, relief: Relief | None = None) -> Workpiece:
    """As `simulation.part.prepare`, in another process; what `go_on`, called ten times a second, raises ends the work.

    `relief`, the finished relief the part is to carry, is a function that can be pickled.
    """
    for word in WorkerProcess(_prepare, mesh, vertices, relief).said(go_on):
        if isinstance(word, Workpiece):
            return word
        stage(word)
    raise SimulationFailed("making the part ready ended without an answer: it may need more memory; ask for fewer vertices")


def _prepare(say: Callable[[object], None], mesh: SurfaceMesh, vertices: int, relief: Relief | None) -> None:
    """Work of the other process: report the stages, then return the part."""
    say(prepare(mesh, vertices=vertices, stage=say, relief=relief))


def shape_in_worker(mesh: SurfaceMesh, vertices: int, go_on: Callable[[], None]) -> Shape:
    """A part as far as a style needs it ready, remeshed in another process; what `go_on` raises ends the work.

    What was remeshed before needs no process, which takes two seconds to begin.
    """
    known = standardised_before(mesh, vertices)
    if known is not None:
        go_on()
        return _shape_of(known)
    for shape in WorkerProcess(_shape, mesh, vertices).said(go_on):
        if isinstance(shape, Shape):
            return shape
    raise SimulationFailed("making the part ready for a preview ended without an answer: it may need more memory")


def _shape(say: Callable[[object], None], mesh: SurfaceMesh, vertices: int) -> None:
    """Work of the other process: what a style needs."""
    say(_shape_of(standardised(mesh, vertices)))


def _shape_of(surface: SurfaceMesh) -> Shape:
    shape = Shape(surface, local_thickness(surface).astype(np.float32))
    _ = shape.level_base, shape.inside  # are kept with it
    return shape
