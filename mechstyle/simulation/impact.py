"""The impact of a checkpoint, moment by moment, on the surface: how it deforms and where the stress runs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mechstyle.fea.explicit import Progress, no_progress
from mechstyle.fea.orientations import UP
from mechstyle.fea.snapshots import snapshots
from mechstyle.fea.stressed_volume import at_nodes
from mechstyle.geometry.morph import Morph
from mechstyle.geometry.transfer import SurfaceMean, Transfer
from mechstyle.loop.objects import Memo
from mechstyle.records import Recipe
from mechstyle.records.mesh import Floats, SurfaceMesh
from mechstyle.records.regions import Point
from mechstyle.simulation.part import Workpiece, at_rest
from mechstyle.simulation.physics import PHYSICS_VERSION, memo_key, period_of, physics, prescribed


@dataclass(frozen=True, eq=False)
class Impact:
    """One drop of a part, through all its phases, in the frame of the part as it was at first touch.

    Attributes:
        time: Time since first touch, flights included, of which there are no frames [ms], shape [frames].
        displacement: How far the surface has moved since first touch, fall and all [mm], shape [frames, vertex_count, 3].
        stress: Largest stress since the frame before [MPa], shape [frames, vertex_count], as a landing has it at the surface.
        normal: Of the floor, out of it, in that frame.
    """

    time: NDArray[np.float64]
    displacement: NDArray[np.float32]
    stress: NDArray[np.float32]
    normal: Point = UP

    @property
    def peak(self) -> int:
        """The frame with the largest stress, the moment one wants to see."""
        return int(self.stress.max(axis=1).argmax())

    def shape(self, mesh: SurfaceMesh, frame: int, exaggeration: float = 1.0) -> SurfaceMesh:
        """The part at a moment, turned so that the floor is level below it, its deformation exaggerated, its motion as a whole not.

        Args:
            mesh: The part before the drop.
            frame: The moment, counted from 0.
            exaggeration: Factor on what is left of the displacement once the rigid motion nearest to it is taken out.
        """
        return mesh.moved(self.motion(mesh.vertices, frame).moved(mesh.vertices, exaggeration))

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


def nearest_rigid(points: Floats, moved: Floats) -> Floats:
    """Points rotated and shifted as a whole to where they are nearest to others; arguments as for `rigid_motion`."""
    turn, shift = rigid_motion(points, moved)
    return np.asarray(points @ turn.T + shift)


def impact_of(
    part: Workpiece,
    recipe: Recipe,
    displacement: NDArray[np.float32],
    memo: Memo,
    progress: Progress = no_progress,
    normal: Point = UP,
) -> Impact:
    """Drop a displaced part, as it stands by default, and keep what happens on its surface; remembered by its inputs.

    Args:
        part: The prepared part.
        recipe: What decides the physics.
        displacement: Of a checkpoint [mm], shape [vertex_count].
        memo: Where the answer is remembered.
        progress: Called with the fraction done; may raise to cancel.
        normal: Of the floor, out of it, in the frame of the part, as `Landing.normal` has it.

    Raises:
        SimulationFailed: If the drop breaks down.
    """
    key = impact_key(recipe, displacement, normal)
    known = memo.recall(key, Impact)
    if known is not None:
        return known
    if part.at is not None and not np.any(displacement):
        part = replace(part, tets=at_rest(part.surface), at=None)
    morph = Morph(part.surface, part.tets, part.at)
    tets = morph.morphed(displacement).tets
    period = period_of(lambda: part.tets if part.at is None else at_rest(part.surface), recipe, memo)
    seen = snapshots(tets, recipe.test.material, prescribed(recipe), normal=normal, progress=progress, period=period)
    made_for = part.surface if part.at is None else part.surface.displaced(part.at)
    smooth = Transfer(made_for, part.tets)
    of_stress = smooth if recipe.test.transfer == smooth.method else Transfer(made_for, part.tets, recipe.test.transfer)
    moved = [np.stack([smooth.to_surface(frame[:, axis]) for axis in range(3)], axis=1) for frame in seen.displacement]
    mean = SurfaceMean(part.surface)
    stress = [mean(of_stress.to_surface(at_nodes(tets, corners))) for corners in seen.corners]
    impact = Impact(seen.time, np.array(moved, np.float32), np.array(stress, np.float32), normal)
    memo.remember(key, impact)
    return impact


def impact_key(recipe: Recipe, displacement: NDArray[np.float32], normal: Point = UP) -> str:
    """The name an impact is remembered by; arguments as for `impact_of`."""
    landing = () if normal == UP else (tuple(normal),)
    return memo_key(("impact", PHYSICS_VERSION, *physics(recipe), *landing), displacement)
