"""One drop with the displacement of every vertex: at moments through all its phases, or at one."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import SimulationFailed
from mechstyle.fea.backends.cpu import CoreBody
from mechstyle.fea.discretisation import Discretisation, discretise
from mechstyle.fea.drop import DropTest, tracks_for
from mechstyle.fea.elements import ElementMesh, element_named
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.orientations import UP
from mechstyle.fea.phases import Camera, follow
from mechstyle.records.material import Material
from mechstyle.records.mesh import Bools, Floats, Indices, TetMesh

DROP = DropTest()


@dataclass(frozen=True, eq=False)
class Snapshots:
    """A drop at moments of its phases, the first at first touch, in the frame of the body as it was then.

    Attributes:
        time: Time since first touch, flights included, of which there are no moments [ms], shape [frames].
        displacement: How far each vertex has moved since first touch, fall and all [mm], shape [frames, vertex_count, 3]; zero for
            vertices that no tetrahedron uses.
        von_mises: Largest von Mises stress since the frame before at the Gauss points [MPa], shape [frames, tet_count, points].
        contact: Whether a vertex met the floor in the whole drop, shape [vertex_count].
    """

    time: Floats
    displacement: NDArray[np.float32]
    von_mises: NDArray[np.float32]
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
    tets: TetMesh, material: Material, test: DropTest = DROP, *,
    normal: tuple[float, float, float] = UP, frames: int = 50, progress: Progress = no_progress, period: float | None = None,
) -> Snapshots:  # fmt: skip
    """Drop a body, by default as it stands, on the CPU, and keep at most so many moments, at least 4; `progress` may raise to cancel.

    There are more than half as many unless the drop has fewer looks at it. `normal` is that of the floor, out of it, in the frame of the
    body, of length one; others are as for `drop.drop`.

    Raises:
        BadInput: Unusable tetrahedra.
        SimulationFailed: If the drop breaks down, or its lowest period cannot be worked out.
    """
    discretisation = discretise(tets, material, test.added_mass, element_named(test.element))
    film = _Film(frames - 1)
    touched = _filmed(discretisation, material, test, film, progress, period, np.array([normal]))
    places, count, tet_count = discretisation.place[: len(discretisation.vertices)], len(film.times) + 1, len(tets.tets)
    displacement = np.zeros((count, len(tets.vertices), 3), np.float32)
    von_mises = np.zeros((count, tet_count, discretisation.mesh.element.points), np.float32)
    for frame, (moved, peak) in enumerate(zip(film.moved, film.peaks, strict=True), start=1):
        displacement[frame][discretisation.vertices] = moved[places]
        von_mises[frame][discretisation.tet_order] = peak
    contact = np.zeros(len(tets.vertices), dtype=bool)
    contact[discretisation.vertices] = touched[places]
    return Snapshots(np.array([0.0, *film.times]), displacement, von_mises, contact)


def snapshot(tets: TetMesh, material: Material, test: DropTest, time: float, period: float | None = None) -> Snapshot:
    """Position nearest to a time since first touch [ms] in a drop of a body as it stands, on the CPU; raises as `snapshots`."""
    discretisation = discretise(tets, material, test.added_mass, element_named(test.element))
    still = _Still(time, np.zeros_like(discretisation.positions, dtype=np.float32))
    _filmed(discretisation, material, test, still, no_progress, period, np.array([UP]))
    return Snapshot(discretisation.mesh, discretisation.vertices, still.time, still.moved[discretisation.place])


@dataclass
class _Film:
    """Moments of a drop, at most so many: every second is merged into the one after it when there are more; else as `Snapshots`."""

    most: int
    times: list[float] = field(default_factory=list)
    moved: list[NDArray[np.float32]] = field(default_factory=list)
    peaks: list[NDArray[np.float32]] = field(default_factory=list)
    _in_each: int = 1
    _taken: int = 0

    def take(self, time: float, displacement: Floats, peak: NDArray[np.float32]) -> None:
        """One more."""
        if len(self.times) == self.most and self._taken % self._in_each == 0:
            last = len(self.times) - 1
            kept = [min(index + 1, last) for index in range(0, last + 1, 2)]  # half of them are left
            self.times, self.moved = [self.times[later] for later in kept], [self.moved[later] for later in kept]
            self.peaks = [np.maximum(self.peaks[later - later % 2], self.peaks[later]) for later in kept]
            self._in_each *= 2
        moved = displacement.astype(np.float32)
        if self._taken % self._in_each:
            self.times[-1], self.moved[-1], self.peaks[-1] = time, moved, np.maximum(self.peaks[-1], peak)
        else:
            self.times.append(time)
            self.moved.append(moved)
            self.peaks.append(peak)
        self._taken += 1


@dataclass
class _Still:
    """The moment nearest to a wanted one [ms], and how far each node has moved by then [mm]."""

    wanted: float
    moved: NDArray[np.float32]
    time: float = 0.0

    def take(self, time: float, displacement: Floats, _peak: NDArray[np.float32]) -> None:
        """Keep it if it is nearer."""
        if abs(time - self.wanted) < abs(self.time - self.wanted):
            self.time, self.moved = time, displacement.astype(np.float32)


def _filmed(
    discretisation: Discretisation, material: Material, test: DropTest, camera: Camera,
    progress: Progress, period: float | None, normals: Floats,
) -> Bools:  # fmt: skip
    """Drop a body on the floor of one normal, shape [1, 3], before a camera; whether each node met the floor, shape [node_count]."""
    tracks, scheme = tracks_for(discretisation, material, normals, test, period)
    follow(CoreBody(discretisation), scheme, tracks, progress, camera)
    if tracks[0].failed:
        raise SimulationFailed(f"the drop test broke down at {tracks[0].time:.3f} ms: mesh the part again")
    touched = tracks[0].touched
    return np.zeros(len(discretisation.masses), dtype=bool) if touched is None else touched
