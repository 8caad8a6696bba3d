"""A drop frame by frame: where every vertex is and how stressed every element is at moments through the impact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import SimulationFailed
from mechstyle.fea.discretisation import discretise
from mechstyle.fea.drop_test import DropTest, scheme_for
from mechstyle.fea.interpolation import element_named
from mechstyle.fea.on_cores import CoreBody, CoreDrop
from mechstyle.material import Material
from mechstyle.mesh import Floats, TetMesh

UPRIGHT = np.array([0.0, 0.0, 1.0])
DROP = DropTest()


@dataclass(frozen=True, eq=False)
class Film:
    """A drop as placed at moments through the window, the first at first touch.

    Attributes:
        time: Time since first touch [ms], shape [frames].
        displacement: How far each vertex has moved since first touch, fall and all [mm], shape [frames, vertex_count, 3]; zero for
            vertices that no tetrahedron uses.
        von_mises: Largest von Mises stress since the frame before at the Gauss points [MPa], shape [frames, tet_count, points].
    """

    time: Floats
    displacement: NDArray[np.float32]
    von_mises: NDArray[np.float32]


def film(
    tets: TetMesh,
    material: Material,
    test: DropTest = DROP,
    *,
    frames: int = 25,
    progress: Callable[[float], None] = lambda _: None,
) -> Film:
    """Drop a body as it stands, on the CPU, and look at it `frames` times.

    Args:
        tets: The body [mm].
        material: Its material.
        test: Height, window and numerical settings.
        frames: Moments to look at, about; at least 2.
        progress: Called with the fraction done; may raise to cancel.

    Raises:
        BadInput: Unusable tetrahedra.
        SimulationFailed: If the drop breaks down.
    """
    discretisation = discretise(tets, material, test.added_mass, element_named(test.element))
    body = CoreBody(discretisation)
    scheme = scheme_for(body, discretisation, material, test)
    heights = discretisation.positions @ UPRIGHT
    drop = CoreDrop(body, scheme, UPRIGHT, heights - heights.min())
    looks = np.unique(np.linspace(0, scheme.samples, frames).round().astype(int))
    displacement = np.zeros((len(looks), len(tets.vertices), 3), np.float32)
    von_mises = np.zeros((len(looks), *_shape(drop)), np.float32)
    places = discretisation.place[: len(discretisation.vertices)]
    for frame, look in enumerate(looks[1:], start=1):
        drop.forget_peak()
        drop.advance(int(look) - drop.done)
        displacement[frame][discretisation.vertices] = drop.displacement()[places]
        von_mises[frame][discretisation.tet_order] = drop.peak()[0]
        if not np.isfinite(displacement[frame]).all():
            raise SimulationFailed(f"the drop test broke down before {look * scheme.stride * scheme.time_step:.3f} ms: mesh the part again")
        progress(frame / (len(looks) - 1))
    return Film(looks * scheme.stride * scheme.time_step, displacement, von_mises)


def _shape(drop: CoreDrop) -> tuple[int, int]:
    return drop.body.tet_count, drop.body.points
