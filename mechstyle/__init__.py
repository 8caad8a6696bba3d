"""MechStyle: stylize a 3D-printable model from a prompt while a drop test watches its strength.

    import mechstyle as ms
    run = ms.stylize(ms.load("part.stl"), "brick", material="PLA")
    run.verdict
    run.show()

Units everywhere: mm, g, ms, N, MPa. Importing this package loads nothing; everything comes when asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mechstyle.errors import BadInput, DamagedStore, MechStyleError, MissingPiece, SimulationFailed
    from mechstyle.gallery import load
    from mechstyle.gallery.style_swatches import styles
    from mechstyle.geometry.files import save
    from mechstyle.loop.bounds import Bounds
    from mechstyle.loop.engine import Engine, Stylizer
    from mechstyle.loop.store import Store
    from mechstyle.pictures.panels import Picture
    from mechstyle.records import Checkpoint, Doubt, Landing, LoadResult, Recipe, Row, Simulation, Verdict
    from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
    from mechstyle.records.material import LIBRARY, Material, material_named
    from mechstyle.records.mesh import SurfaceMesh, TetMesh
    from mechstyle.records.regions import Box, End, HalfSpace, Holes, Inside, Outside, Rim, Segment, Sides, Sphere, Vertices
    from mechstyle.runs.deepest import Depth, deepest
    from mechstyle.runs.plugins import register_stylizer
    from mechstyle.runs.printing import Printing
    from mechstyle.runs.protection import ProtectedPart, protect
    from mechstyle.runs.recipes import changed, plan
    from mechstyle.runs.run import Run, begin, stylize
    from mechstyle.runs.session import Session
    from mechstyle.simulation.part import Model, Workpiece, prepare
    from mechstyle.simulation.part_test import PartTest, simulate
    from mechstyle.simulation.simulator import DropSimulator
    from mechstyle.simulation.strengthen import Strengthened, strengthen
    from mechstyle.styling.drawn import ProceduralStylizer, Target

__version__ = "0.1.0"

_WHERE = {
    "BadInput": "errors",
    "Bounds": "loop.bounds",
    "Box": "records.regions",
    "Checkpoint": "records",
    "DamagedStore": "errors",
    "Depth": "runs.deepest",
    "Doubt": "records",
    "DropSimulator": "simulation.simulator",
    "End": "records.regions",
    "Engine": "loop.engine",
    "HalfSpace": "records.regions",
    "Holes": "records.regions",
    "Inside": "records.regions",
    "LIBRARY": "records.material",
    "Landing": "records",
    "Load": "records.load_cases",
    "LoadCase": "records.load_cases",
    "LoadResult": "records",
    "Material": "records.material",
    "MechStyleError": "errors",
    "MissingPiece": "errors",
    "Model": "simulation.part",
    "Outside": "records.regions",
    "PartTest": "simulation.part_test",
    "Patch": "records.load_cases",
    "Picture": "pictures.panels",
    "Printing": "runs.printing",
    "ProceduralStylizer": "styling.drawn",
    "ProtectedPart": "runs.protection",
    "Recipe": "records",
    "Rim": "records.regions",
    "Row": "records",
    "Run": "runs.run",
    "Segment": "records.regions",
    "Session": "runs.session",
    "Sides": "records.regions",
    "Simulation": "records",
    "SimulationFailed": "errors",
    "Sphere": "records.regions",
    "Store": "loop.store",
    "Strengthened": "simulation.strengthen",
    "Stylizer": "loop.engine",
    "Support": "records.load_cases",
    "SurfaceMesh": "records.mesh",
    "Target": "styling.drawn",
    "TetMesh": "records.mesh",
    "Verdict": "records",
    "Vertices": "records.regions",
    "Workpiece": "simulation.part",
    "begin": "runs.run",
    "changed": "runs.recipes",
    "deepest": "runs.deepest",
    "load": "gallery",
    "material_named": "records.material",
    "plan": "runs.recipes",
    "prepare": "simulation.part",
    "protect": "runs.protection",
    "register_stylizer": "runs.plugins",
    "save": "geometry.files",
    "simulate": "simulation.part_test",
    "strengthen": "simulation.strengthen",
    "styles": "gallery.style_swatches",
    "stylize": "runs.run",
}

__all__ = [
    "LIBRARY",
    "BadInput",
    "Bounds",
    "Box",
    "Checkpoint",
    "DamagedStore",
    "Depth",
    "Doubt",
    "DropSimulator",
    "End",
    "Engine",
    "HalfSpace",
    "Holes",
    "Inside",
    "Landing",
    "Load",
    "LoadCase",
    "LoadResult",
    "Material",
    "MechStyleError",
    "MissingPiece",
    "Model",
    "Outside",
    "PartTest",
    "Patch",
    "Picture",
    "Printing",
    "ProceduralStylizer",
    "ProtectedPart",
    "Recipe",
    "Rim",
    "Row",
    "Run",
    "Segment",
    "Session",
    "Sides",
    "Simulation",
    "SimulationFailed",
    "Sphere",
    "Store",
    "Strengthened",
    "Stylizer",
    "Support",
    "SurfaceMesh",
    "Target",
    "TetMesh",
    "Verdict",
    "Vertices",
    "Workpiece",
    "begin",
    "changed",
    "deepest",
    "load",
    "material_named",
    "plan",
    "prepare",
    "protect",
    "register_stylizer",
    "save",
    "simulate",
    "strengthen",
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
