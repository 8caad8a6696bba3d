"""σ_V of structured bodies under loads and in landings, weighed by the walls that their own surface has."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop import DropTest, drop
from mechstyle.fea.elements import QUADRATIC
from mechstyle.fea.linear_solvers import lowest_period
from mechstyle.fea.statics import StaticTest
from mechstyle.fea.stressed_volume import DROPPED, LOADED, Walls, at_nodes, exceeded
from mechstyle.geometry.morph import Morph
from mechstyle.geometry.thickness import local_thickness
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.material import LIBRARY, Material
from mechstyle.records.mesh import SurfaceMesh, TetMesh
from mechstyle.simulation.part import Workpiece
from mechstyle.styling.dimensions import Dimensions
from mechstyle.styling.drawn import target
from mechstyle.styling.prompt import Wish
from validation.meshes import square_cup

PLA = LIBRARY["PLA"]
UPRIGHT = ((0.0, 0.0, 1.0),)


class Reading(NamedTuple):
    """What a test reads of a body.

    Attributes:
        stress: σ_V [MPa].
        maximum: Largest stress at a corner of a tetrahedron [MPa].
    """

    stress: float
    maximum: float


class Body:
    """A body and its walls, which are worked out once.

    Attributes:
        tets: Its tetrahedra.
    """

    def __init__(self, tets: TetMesh) -> None:
        self.tets = tets

    @cached_property
    def walls(self) -> Walls:
        """Its walls, unless those of another surface are set."""
        surface = self.tets.boundary
        return Walls(surface.vertices, local_thickness(surface))

    def read(self, corners: ArrayLike, edge: float) -> Reading:
        """Reading of stress at the corners of the tetrahedra [MPa], shape [tet_count, 4]; `edge` is that of the cube V0 [mm]."""
        weights = self.walls.weights(self.tets)
        return Reading(exceeded(self.tets, at_nodes(self.tets, corners), weights, edge**3).stress, float(np.max(corners)))

    def loaded(self, force: tuple[float, float, float], material: Material = PLA) -> Reading:
        """Held at its low end along x, a force [N] at the other."""
        low, high = self.tets.vertices[:, 0].min(), self.tets.vertices[:, 0].max()
        case = LoadCase(
            name="load",
            supports=(Support(at=Patch(plane=(low, 0.0, 0.0, -1.0, 0.0, 0.0))),),
            loads=(Load(at=Patch(plane=(high, 0.0, 0.0, 1.0, 0.0, 0.0)), force=force),),
        )
        return self.read(StaticTest(self.tets, (case,)).run(self.tets, material)["load"].corners, LOADED)

    def dropped(self, test: DropTest, normals: ArrayLike = UPRIGHT, period: float | None = None) -> list[Reading]:
        """Readings of drops with given floor normals, shape [landings, 3]."""
        result = drop(self.tets, PLA, normals, test, device="cpu", period=period)
        if result.failure:
            raise ValueError(result.failure)
        return [self.read(corners, DROPPED) for corners in result.corners]


def period_of_body(tets: TetMesh) -> float:
    """Lowest period of free vibration [ms]."""
    return lowest_period(discretise(tets, PLA, DropTest().added_mass, QUADRATIC))


class Styled(NamedTuple):
    """A part before and after.

    Attributes:
        smooth: The surface before.
        unstyled: Its tetrahedra.
        surface: The surface in brick, the resting face left smooth.
        morphed: The tetrahedra, moved along.
    """

    smooth: SurfaceMesh
    unstyled: TetMesh
    surface: SurfaceMesh
    morphed: TetMesh


def styled_cup() -> Styled:
    """A square cup, 24 mm high, in brick: even tetrahedra make long steps, so that eight times as many can be afforded."""
    tets = square_cup(24.0, 24.0, 2.0)
    smooth = tets.boundary
    part = Workpiece(smooth, tets, local_thickness(smooth).astype(np.float32), stands=True)
    bounds = part.shape.bounds("plain", 0.0)
    size = Dimensions(amplitude=0.15, side="both", nozzle=0.0)
    aim = target(smooth, Wish("brick"), size, seed=0, thickness=part.thickness, inward=bounds.inward, outward=bounds.outward)
    relief = (aim.displacement * bounds.freedom).astype(np.float32)
    return Styled(smooth, tets, smooth.displaced(relief), Morph(smooth, tets).morphed(relief).tets)
