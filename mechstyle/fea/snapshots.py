"""A drop as placed with the displacement of every vertex: at moments through the impact, or stopped at one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import SimulationFailed
from mechstyle.fea.backends.cpu import CoreBody, CoreDrop
from mechstyle.fea.discretisation import Discretisation, discretise
from mechstyle.fea.drop import DropTest, scheme_for
from mechstyle.fea.elements import ElementMesh, element_named
from mechstyle.fea.explicit import Progress, Scheme, no_progress
from mechstyle.records.material import Material
from mechstyle.records.mesh import Floats, Indices, TetMesh

UPRIGHT = np.array([0.0, 0.0, 1.0])
DROP = DropTest()


@dataclass(frozen=True, eq=False)
class Snapshots:
    """A drop as placed at moments through the window, the first at first touch.

    Attributes:
        time: Time since first touch [ms], shape [frames].
        displacement: How far each vertex has moved since first touch, fall and all [mm], shape [frames, vertex_count, 3]; zero for
            vertices that no tetrahedron uses.
        von_mises: Largest von Mises stress since the frame before at the Gauss points [MPa], shape [frames, tet_count, points].
        corners: The same at the corners of the tetrahedra [MPa], shape [frames, tet_count, 4].
        contact: Whether a vertex met the floor in the whole drop, shape [vertex_count].
    """

    time: Floats
    displacement: NDArray[np.float32]
    von_mises: NDArray[np.float32]
    corners: NDArray[np.float32]
    contact: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Position of a body at one moment of its drop.

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


def snapshots(
    tets: TetMesh,
    material: Material,
    test: DropTest = DROP,
    *,
    frames: int = 25,
    progress: Progress = no_progress,
) -> Snapshots:
    """Drop a body as it stands, on the CPU, and record it `frames` times.

    Args:
        tets: The body [mm].
        material: Its material.
        test: Height, window and numerical settings.
        frames: Number of moments, about; at least 2.
        progress: Called with the fraction done; may raise to cancel.

    Raises:
        BadInput: Unusable tetrahedra.
        SimulationFailed: If the drop breaks down.
    """
    discretisation, scheme, drop = _at_first_touch(tets, material, test)
    samples = np.unique(np.linspace(0, scheme.samples, frames).round().astype(int))
    displacement = np.zeros((len(samples), len(tets.vertices), 3), np.float32)
    von_mises, corners = (np.zeros((len(samples), drop.body.tet_count, places), np.float32) for places in (drop.body.points, 4))
    places = discretisation.place[: len(discretisation.vertices)]
    for frame, sample in enumerate(samples[1:], start=1):
        drop.forget_peak()
        drop.advance(int(sample) - drop.done)
        displacement[frame][discretisation.vertices] = drop.displacement()[places]
        von_mises[frame][discretisation.tet_order] = drop.peak()[0]
        corners[frame][discretisation.tet_order] = drop.corners()[0]
        if not np.isfinite(displacement[frame]).all():
            broken = sample * scheme.stride * scheme.time_step
            raise SimulationFailed(f"the drop test broke down before {broken:.3f} ms: mesh the part again")
        progress(frame / (len(samples) - 1))
    contact = np.zeros(len(tets.vertices), dtype=bool)
    contact[discretisation.vertices] = drop.touched()[0][places]
    return Snapshots(samples * scheme.stride * scheme.time_step, displacement, von_mises, corners, contact)


def snapshot(tets: TetMesh, material: Material, test: DropTest, time: float) -> Snapshot:
    """Drop a body as it stands, on the CPU, up to the sample of the history nearest to a time.

    Args:
        tets: The body [mm].
        material: Its material.
        test: Height, window and numerical settings.
        time: Time since first touch [ms], within the window.

    Raises:
        BadInput: Unusable tetrahedra.
    """
    discretisation, scheme, drop = _at_first_touch(tets, material, test)
    interval = scheme.stride * scheme.time_step
    samples = min(round(time / interval), scheme.samples)
    drop.advance(samples)
    return Snapshot(discretisation.mesh, discretisation.vertices, samples * interval, drop.displacement()[discretisation.place])


def _at_first_touch(tets: TetMesh, material: Material, test: DropTest) -> tuple[Discretisation, Scheme, CoreDrop]:
    """The body on the CPU, as it stands, touching the floor at its lowest node."""
    discretisation = discretise(tets, material, test.added_mass, element_named(test.element))
    body = CoreBody(discretisation)
    scheme = scheme_for(discretisation, material, test)
    heights = discretisation.positions @ UPRIGHT
    return discretisation, scheme, CoreDrop(body, scheme, UPRIGHT, heights - heights.min())
