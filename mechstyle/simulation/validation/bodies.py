"""A small part before and after its style, in even tetrahedra."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mechstyle.geometry.morph import Morph
from mechstyle.geometry.thickness import local_thickness
from mechstyle.records.mesh import SurfaceMesh, TetMesh
from mechstyle.simulation.part import Workpiece
from mechstyle.simulation.validation.meshes import square_cup
from mechstyle.styling.dimensions import Dimensions
from mechstyle.styling.drawn import target
from mechstyle.styling.prompt import Wish


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
    used, numbers = np.unique(tets.boundary_faces, return_inverse=True)
    smooth = SurfaceMesh(tets.vertices[used], numbers.reshape(-1, 3).astype(np.int32))
    part = Workpiece(smooth, tets, local_thickness(smooth).astype(np.float32), stands=True)
    bounds = part.shape.bounds("protected", 0.0)
    size = Dimensions(amplitude=0.15, side="both", nozzle=0.0)
    aim = target(smooth, Wish("brick"), size, seed=0, thickness=part.thickness, inward=bounds.inward, outward=bounds.outward)
    relief = (aim.displacement * bounds.freedom).astype(np.float32)
    return Styled(smooth, tets, smooth.displaced(relief), Morph(smooth, tets).morphed(relief).tets)
