"""A Studio whose runs take no time: a part becomes a sheet, and stress is a known function of the relief."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from mechstyle.geometry.files import save
from mechstyle.loop.bounds import Bounds
from mechstyle.loop.engine import Engine
from mechstyle.records.mesh import SurfaceMesh, TetMesh
from mechstyle.runs.folders import PartRecord
from mechstyle.runs.run import Run
from mechstyle.simulation.impact import Impact
from mechstyle.simulation.part import Workpiece
from mechstyle_widgets.state import controller as controller_module
from mechstyle_widgets.viewer import impact_player
from support.bench import BumpStylizer, LeverSimulator, grid
from support.lanes import CORNER


def sheet_of(mesh: SurfaceMesh, vertices: int) -> SurfaceMesh:
    """What a part is standardised to here: a sheet whose size tells the part and whose vertices tell the resolution."""
    return grid(int(np.sqrt(vertices)), step=float(mesh.extents[0]))


def prepared(mesh, *, vertices, stage, go_on, **_):
    stage("standardising the surface")
    surface = sheet_of(mesh, vertices)
    return Workpiece(surface, TetMesh(CORNER.vertices, CORNER.tets), np.full(len(surface.vertices), 4.0, np.float32), stands=True)


def engine_of(run: Run) -> Engine:
    surface = run.part.surface
    count = len(surface.vertices)
    thick = np.full(count, 4.0, np.float32)
    bounds = Bounds(thickness=thick, inward=0.25 * thick, outward=thick, freedom=np.ones(count, np.float32))
    return Engine(run.recipe, surface, bounds, BumpStylizer(count), LeverSimulator(count, run.recipe), run.store, run.lane)


def impact_of(_simulator, simulation, _landing, _progress) -> Impact:
    count = len(simulation.displacement)
    return Impact(np.linspace(0.0, 1.0, 3), np.zeros((3, count, 3), np.float32), np.ones((3, count), np.float32))


def exported(run: Run, path, iteration=None, **_) -> SimpleNamespace:
    save(run.surface(iteration), path)
    return SimpleNamespace(warnings=())


def without_physics(patch: pytest.MonkeyPatch) -> None:
    """Let no run of a Studio mesh, draw or drop anything; a sheet may be as coarse as it likes."""
    patch.setattr("mechstyle.records.mesh.VERTICES", (1, 400_000))
    patch.setattr(Run, "events", lambda run, _progress: engine_of(run).run())
    patch.setattr(controller_module, "prepare_in_worker", prepared)
    patch.setattr("mechstyle.runs.run.refilled", lambda part, *_: part)  # a sheet cannot be meshed
    patch.setattr(PartRecord, "droppable", staticmethod(lambda part, _file: part))  # nor does it enclose anything
    patch.setattr(impact_player, "impact_of", impact_of)
    patch.setattr(Run, "exported", exported)  # nor has it a volume
    patch.setattr("mechstyle_widgets.panels.mask_inspector._freedom", lambda run, _recipe: np.ones_like(run.part.thickness))
