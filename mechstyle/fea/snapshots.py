"""One drop with the displacement of every vertex, at moments through all its phases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import SimulationFailed
from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.discretisation import Relative, discretise
from mechstyle.fea.drop import DropTest, tracks_for
from mechstyle.fea.elements import element_named
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.orientations import UP
from mechstyle.fea.phases import Film, follow
from mechstyle.records.material import Material
from mechstyle.records.mesh import Floats, TetMesh

DROP = DropTest()


@dataclass(frozen=True, eq=False)
class Snapshots:
    """A drop at moments of its phases, the first at first touch, in the frame of the body as it was then.

    Attributes:
        time: Time since first touch, flights included, of which there are no moments [ms], shape [frames].
        displacement: How far each vertex has moved since first touch, fall and all [mm], shape [frames, vertex_count, 3]; zero for
            vertices that no tetrahedron uses.
        von_mises: Largest von Mises stress since the frame before at the Gauss points [MPa], shape [frames, tet_count, points].
    """

    time: Floats
    displacement: NDArray[np.float32]
    von_mises: NDArray[np.float32]


def snapshots(
    tets: TetMesh, material: Material, test: DropTest = DROP, *,
    normal: tuple[float, float, float] = UP, frames: int = 50, progress: Progress = no_progress, period: float | None = None,
    relative: Relative | None = None,
) -> Snapshots:  # fmt: skip
    """Drop a body, by default as it stands, on the CPU, and keep at most so many moments, at least 4; `progress` may raise to cancel.

    There are more than half as many unless the drop has fewer looks at it. `normal` is that of the floor, out of it, in the frame of the
    body, of length one; others are as for `drop.drop`.

    Raises:
        BadInput: Unusable tetrahedra.
        SimulationFailed: If the drop breaks down, or its lowest period cannot be worked out.
    """
    discretisation = discretise(tets, material, test.added_mass, element_named(test.element), relative)
    film = Film(frames - 1)
    tracks, scheme = tracks_for(discretisation, material, np.array([normal]), test, period)
    follow(CoreBody(discretisation), scheme, tracks, progress, film)
    if tracks[0].failed:
        raise SimulationFailed(f"the drop test broke down at {tracks[0].time:.3f} ms: mesh the part again")
    places, count, tet_count = discretisation.place[: len(discretisation.vertices)], len(film.times) + 1, len(tets.tets)
    displacement = np.zeros((count, len(tets.vertices), 3), np.float32)
    von_mises = np.zeros((count, tet_count, discretisation.mesh.element.points), np.float32)
    for frame, (moved, peak) in enumerate(zip(film.moved, film.peaks, strict=True), start=1):
        displacement[frame][discretisation.vertices] = moved[places]
        von_mises[frame][discretisation.tet_order] = peak
    return Snapshots(np.array([0.0, *film.times]), displacement, von_mises)
