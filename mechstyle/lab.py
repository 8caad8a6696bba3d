"""The second row of public names, for studies, plug-ins and teaching: `ms.lab.plan`, `ms.lab.begin` and others."""

from typing import TYPE_CHECKING, Any

from mechstyle import _found

if TYPE_CHECKING:
    from mechstyle.errors import DamagedStore, MissingPiece, SimulationFailed
    from mechstyle.loop.bounds import Bounds
    from mechstyle.loop.engine import Engine, Stylizer
    from mechstyle.loop.store import Store
    from mechstyle.pictures.panels import Picture
    from mechstyle.records import Checkpoint, Doubt, Landing, LoadResult, Row, Simulation
    from mechstyle.records.load_cases import Patch
    from mechstyle.records.material import material_named
    from mechstyle.records.mesh import TetMesh
    from mechstyle.records.regions import End, Holes, Inside, Outside, Rim, Segment, Sides, Vertices
    from mechstyle.runs.protection import ProtectedPart
    from mechstyle.runs.recipes import changed, plan
    from mechstyle.runs.run import begin
    from mechstyle.runs.session import Session
    from mechstyle.simulation.part import Model, Workpiece, prepare
    from mechstyle.simulation.simulator import DropSimulator
    from mechstyle.simulation.strengthen import Strengthened
    from mechstyle.styling.drawn import ProceduralStylizer, Target

_WHERE = {name: module for module, names in {
    "errors": "DamagedStore MissingPiece SimulationFailed",
    "loop.bounds": "Bounds",
    "loop.engine": "Engine Stylizer",
    "loop.store": "Store",
    "pictures.panels": "Picture",
    "records": "Checkpoint Doubt Landing LoadResult Row Simulation",
    "records.load_cases": "Patch",
    "records.material": "material_named",
    "records.mesh": "TetMesh",
    "records.regions": "End Holes Inside Outside Rim Segment Sides Vertices",
    "runs.protection": "ProtectedPart",
    "runs.recipes": "changed plan",
    "runs.run": "begin",
    "runs.session": "Session",
    "simulation.part": "Model Workpiece prepare",
    "simulation.simulator": "DropSimulator",
    "simulation.strengthen": "Strengthened",
    "styling.drawn": "ProceduralStylizer Target",
}.items() for name in names.split()}  # fmt: skip

__all__ = [
    "Bounds", "Checkpoint", "DamagedStore", "Doubt", "DropSimulator", "End", "Engine", "Holes", "Inside", "Landing",
    "LoadResult", "MissingPiece", "Model", "Outside", "Patch", "Picture", "ProceduralStylizer", "ProtectedPart", "Rim", "Row", "Segment",
    "Session", "Sides", "Simulation", "SimulationFailed", "Store", "Strengthened", "Stylizer", "Target", "TetMesh", "Vertices",
    "Workpiece", "begin", "changed", "material_named", "plan", "prepare",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Load what is asked for on first use."""
    if name not in _WHERE:
        raise AttributeError(f"module 'mechstyle.lab' has no attribute {name!r}")
    return _found(globals(), _WHERE, name)


def __dir__() -> list[str]:
    """Every name of the second row, loaded or not."""
    return list(__all__)
