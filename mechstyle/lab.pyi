# The second row of public names and where they are.

from mechstyle.errors import DamagedStore as DamagedStore, MissingPiece as MissingPiece, SimulationFailed as SimulationFailed
from mechstyle.loop.bounds import Bounds as Bounds
from mechstyle.loop.engine import Engine as Engine, Stylizer as Stylizer
from mechstyle.loop.store import Store as Store
from mechstyle.pictures.panels import Picture as Picture
from mechstyle.records import (
    Checkpoint as Checkpoint,
    Doubt as Doubt,
    Landing as Landing,
    LoadResult as LoadResult,
    Row as Row,
    Simulation as Simulation,
)
from mechstyle.records.load_cases import Patch as Patch
from mechstyle.records.material import material_named as material_named
from mechstyle.records.mesh import TetMesh as TetMesh
from mechstyle.records.regions import (
    End as End,
    Holes as Holes,
    Inside as Inside,
    Outside as Outside,
    Rim as Rim,
    Segment as Segment,
    Sides as Sides,
    Vertices as Vertices,
)
from mechstyle.runs.protection import ProtectedPart as ProtectedPart
from mechstyle.runs.recipes import changed as changed, plan as plan
from mechstyle.runs.run import Draft as Draft
from mechstyle.runs.session import Session as Session
from mechstyle.simulation.part import Model as Model, Workpiece as Workpiece, prepare as prepare
from mechstyle.simulation.simulator import DropSimulator as DropSimulator
from mechstyle.styling.drawn import ProceduralStylizer as ProceduralStylizer, Target as Target
