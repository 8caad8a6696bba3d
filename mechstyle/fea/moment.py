"""A drop as placed stopped at one moment, with the displacement of every node."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop_test import DropTest, scheme_for
from mechstyle.fea.film import UPRIGHT
from mechstyle.fea.interpolation import ElementMesh, element_named
from mechstyle.fea.on_cores import CoreBody, CoreDrop
from mechstyle.material import Material
from mechstyle.mesh import Indices, TetMesh


@dataclass(frozen=True, eq=False)
class Moment:
    """Where a body is at one moment of its drop.

    Attributes:
        mesh: The elements, without vertices that no tetrahedron uses.
        vertices: Caller's numbers of the vertices of `mesh`, shape [vertex_count].
        time: Time since first touch [ms].
        displacement: How far each node has moved since first touch, fall and all [mm], shape [node_count, 3].
    """

    mesh: ElementMesh
    vertices: Indices
    time: float
    displacement: NDArray[np.float32]


def moment(tets: TetMesh, material: Material, test: DropTest, time: float) -> Moment:
    """Drop a body as it stands, on the CPU, up to the sample of the history nearest to a time.

    Args:
        tets: The body [mm].
        material: Its material.
        test: Height, window and numerical settings.
        time: Time since first touch [ms], within the window.

    Raises:
        BadInput: Unusable tetrahedra.
    """
    discretisation = discretise(tets, material, test.added_mass, element_named(test.element))
    body = CoreBody(discretisation)
    scheme = scheme_for(body, discretisation, material, test)
    heights = discretisation.positions @ UPRIGHT
    drop = CoreDrop(body, scheme, UPRIGHT, heights - heights.min())
    interval = scheme.stride * scheme.time_step
    samples = min(round(time / interval), scheme.samples)
    drop.advance(samples)
    return Moment(discretisation.mesh, discretisation.vertices, samples * interval, drop.displacement()[discretisation.place])
