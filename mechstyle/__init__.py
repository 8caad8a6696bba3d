"""MechStyle: stylize a 3D-printable model from a prompt while a drop test watches its strength.

    import mechstyle as ms
    run = ms.stylize(ms.load("part.stl"), "brick", material="PLA")
    run.verdict
    run.show()

Units everywhere: mm, g, ms, N, MPa. Importing this package loads numpy and msgspec only; the rest comes when asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from mechstyle.errors import BadInput, DamagedStore, MechStyleError, MissingPiece, SimulationFailed
from mechstyle.material import LIBRARY, Material, material_named
from mechstyle.mesh import SurfaceMesh, TetMesh
from mechstyle.records import Checkpoint, Judgement, Measures, Recipe, Simulation, Verdict
from mechstyle.regions import Box, HalfSpace, Inside, Outside, Segment, Sphere, Vertices

if TYPE_CHECKING:
    from mechstyle.dropped import simulate
    from mechstyle.engine import Engine
    from mechstyle.geometry.files import load, save
    from mechstyle.planning import changed, plan
    from mechstyle.plugins import register_stylizer
    from mechstyle.protected import protect
    from mechstyle.run import Run, begin, stylize
    from mechstyle.session import Session
    from mechstyle.simulator import DropSimulator
    from mechstyle.store import Store
    from mechstyle.swatches import styles
    from mechstyle.workpiece import Workpiece, prepare

__version__ = "0.1.0"

_WHERE = {
    "DropSimulator": "simulator",
    "Engine": "engine",
    "Run": "run",
    "Session": "session",
    "Store": "store",
    "Workpiece": "workpiece",
    "begin": "run",
    "changed": "planning",
    "load": "geometry.files",
    "plan": "planning",
    "prepare": "workpiece",
    "protect": "protected",
    "register_stylizer": "plugins",
    "save": "geometry.files",
    "simulate": "dropped",
    "styles": "swatches",
    "stylize": "run",
}

__all__ = [
    "LIBRARY",
    "BadInput",
    "Box",
    "Checkpoint",
    "DamagedStore",
    "DropSimulator",
    "Engine",
    "HalfSpace",
    "Inside",
    "Judgement",
    "Material",
    "Measures",
    "MechStyleError",
    "MissingPiece",
    "Outside",
    "Recipe",
    "Run",
    "Segment",
    "Session",
    "Simulation",
    "SimulationFailed",
    "Sphere",
    "Store",
    "SurfaceMesh",
    "TetMesh",
    "Verdict",
    "Vertices",
    "Workpiece",
    "begin",
    "changed",
    "load",
    "material_named",
    "plan",
    "prepare",
    "protect",
    "register_stylizer",
    "save",
    "simulate",
    "styles",
    "stylize",
]


def __getattr__(name: str) -> Any:
    """Load what is asked for on first use."""
    if name not in _WHERE:
        raise AttributeError(f"module 'mechstyle' has no attribute {name!r}")
    value = getattr(import_module(f"mechstyle.{_WHERE[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Every public name, loaded or not."""
    return [*__all__, "__version__"]
