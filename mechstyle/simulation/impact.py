"""The impact of a test, moment by moment, on the surface: how it deforms, where the stress runs, and the shape that it keeps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mechstyle.errors import SimulationFailed
from mechstyle.fea.elements import at_vertices
from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.orientations import FLAT, UP
from mechstyle.fea.snapshots import snapshots
from mechstyle.records import Recipe, Simulation
from mechstyle.records.mesh import Floats, SurfaceMesh
from mechstyle.records.regions import Point
from mechstyle.simulation.physics import PHYSICS_VERSION, memo_key, physics, prescribed
from mechstyle.simulation.printed import printed_body
from mechstyle.simulation.simulator import DropSimulator

FALLING, AIR = 7, 0.22
"""Frames of a film before first touch, and the height of the part in the first of them, over its size: of a fall only the end is drawn."""


def heights(size: float, fall: float) -> NDArray[np.float64]:
    """Height above the floor in each frame before first touch [mm], shape [FALLING], of a part so large that falls so far [mm]."""
    return np.asarray(min(AIR * size, fall) * (1.0 - np.arange(FALLING) / FALLING))


@dataclass(frozen=True, eq=False)
class Impact:
    """One drop of a part, through all its phases, in the frame of the part as it was at first touch; last, the shape that it keeps.

    Attributes:
        time: Time since first touch, flights included, of which there are no frames [ms], shape [frames].
        displacement: How far the surface has moved since first touch, fall and all [mm], shape [frames, vertex_count, 3].
        stress: Largest stress since the frame before [MPa], shape [frames, vertex_count], as a landing has it at the surface; with the
            shape that it keeps, that of the whole drop.
        normal: Of the floor, out of it, in that frame.
    """

    time: NDArray[np.float64]
    displacement: NDArray[np.float32]
    stress: NDArray[np.float32]
    normal: Point = UP

    @property
    def peak(self) -> int:
        """The frame with the largest stress, the moment one wants to see."""
        return int(self.stress[:-1].max(axis=1).argmax())

    @property
    def end(self) -> int:
        """The frame of the shape that stays."""
        return len(self.time) - 1

    def shape(self, mesh: SurfaceMesh, frame: int, exaggeration: float = 1.0) -> SurfaceMesh:
        """The part at a moment, turned so that the floor is level below it, its deformation exaggerated, its motion as a whole not.

        Args:
            mesh: The part before the drop.
            frame: The moment, counted from 0.
            exaggeration: Factor on what is left of the displacement once the rigid motion nearest to it is taken out.
        """
        return mesh.moved(self.motion(mesh.vertices, frame).moved(mesh.vertices, exaggeration))

    def falling(self, mesh: SurfaceMesh, above: float) -> SurfaceMesh:
        """The part before first touch, turned as it lands, at a height above the floor [mm]."""
        return mesh.moved(self.shape(mesh, 0).vertices + np.array([0.0, 0.0, above]))

    def motion(self, before: Floats, frame: int) -> Motion:
        """How points [mm], shape [n, 3], have moved since first touch, in a frame in which the floor is level and as high as they stood."""
        moved = before + self.displacement[frame]
        turn, shift = rigid_motion(before, moved)
        deformation = moved - (before @ turn.T + shift)
        if self.normal == UP:
            return Motion(turn, shift, deformation)
        levelled = Rotation.align_vectors([UP], [self.normal])[0].as_matrix()
        middle = 0.5 * (before.min(axis=0) + before.max(axis=0))
        lowest = ((before - middle) @ levelled.T)[:, 2].min()
        stands = np.array([middle[0], middle[1], before[:, 2].min() - lowest])
        return Motion(levelled @ turn, levelled @ (shift - middle) + stands, deformation @ levelled.T)


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion as a whole and what is left of it.

    Attributes:
        turn: Rotation, shape [3, 3].
        shift: Translation after it [mm], shape [3].
        deformation: What is left [mm], shape [n, 3].
    """

    turn: Floats
    shift: Floats
    deformation: Floats

    def moved(self, points: Floats, exaggeration: float = 1.0) -> Floats:
        """Points [mm], shape [n, 3], moved, their deformation exaggerated."""
        return np.asarray(points @ self.turn.T + self.shift + exaggeration * self.deformation)


def rigid_motion(points: Floats, moved: Floats) -> tuple[Floats, Floats]:
    """Rotation [3, 3] and translation after it [mm] that bring points nearest to others, in the sense of least squares (Kabsch 1976).

    Args:
        points: Where they were [mm], shape [n, 3].
        moved: Where they are [mm], shape [n, 3].
    """
    centre, middle = points.mean(axis=0), moved.mean(axis=0)
    left, _, right = np.linalg.svd((points - centre).T @ (moved - middle))
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turn = (left @ flip @ right).T
    return turn, middle - turn @ centre


def impact_of(simulator: DropSimulator, simulation: Simulation, landing: str = FLAT, progress: Progress = no_progress) -> Impact:
    """Drop a part as it was tested once more, on the same tetrahedra, and keep what happens on its surface; remembered by its inputs.

    Args:
        simulator: Of the part, and what decides the physics.
        simulation: The test.
        landing: Name of one of its landings.
        progress: Called with the fraction done; may raise to cancel.

    Raises:
        SimulationFailed: If there is no such landing, or the drop breaks down.
    """
    landed = simulation.landing(landing)
    if landed is None:
        raise SimulationFailed(simulation.failure or f"there was no landing {landing!r}: choose one of those that were tested")
    key = impact_key(simulator.recipe, simulation, landed.normal)
    known = simulator.memo.recall(key, Impact)
    if known is not None:
        return known
    (body, morphed), recipe = simulator.morphed(simulation), simulator.recipe
    seen = snapshots(
        morphed.tets, recipe.test.material, prescribed(recipe), normal=landed.normal, progress=progress, period=simulator.period,
        relative=printed_body(morphed.tets, recipe),
    )  # fmt: skip
    moved = [body.displacement_at_surface(frame) for frame in seen.displacement]
    stress = np.stack([body.field_at_surface(at_vertices(morphed.tets, points)) for points in seen.von_mises])
    whole = simulation.stress_of(landing=landing)
    before = simulator.part.surface.displaced(simulation.displacement).vertices
    turn, shift = rigid_motion(before, before + moved[-1])
    stays = (before + simulation.set_of(landing=landing)) @ turn.T + shift - before
    impact = Impact(
        time=np.append(seen.time, 2.0 * seen.time[-1] - seen.time[-2]), displacement=np.array([*moved, stays], np.float32),
        stress=np.array([*np.minimum(stress, whole), whole], np.float32), normal=landed.normal,
    )  # fmt: skip
    simulator.memo.remember(key, impact)
    return impact


def impact_key(recipe: Recipe, simulation: Simulation, normal: Point) -> str:
    """The name an impact is remembered by: of a test, on the floor of this normal."""
    return memo_key(("impact", PHYSICS_VERSION, *physics(recipe), simulation.mesh, tuple(normal)), simulation.displacement)
