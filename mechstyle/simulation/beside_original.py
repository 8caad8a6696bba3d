"""How well tetrahedra follow a part as it was given, and how much they carry of the relief it has over its original."""

from __future__ import annotations

import msgspec
import numpy as np

from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.resting_face import resting_face
from mechstyle.records.mesh import Floats, SurfaceMesh, TetMesh
from mechstyle.simulation.carrying import slope

SEEN = 0.01
"""Relief below which a place has none [mm]: no printer shows it, and other triangles of a flat face make nearly as much."""

TIMES, BEYOND = 2.0, 10.0
"""A part is another one than its original if a side differs by more than so many times and by more mm than reliefs make of a thin plate."""
TOGETHER = 0.5
"""Share of the smaller box that a part and its original have in common at least where they stand."""


class Relief(msgspec.Struct, frozen=True, kw_only=True):
    """A relief of a part over its original.

    Attributes:
        lowest: How far the part lies outside its original where it does so least [mm]; negative inside.
        highest: The same where it does so most [mm].
        carried: Share of it that the boundary of the tetrahedra follows, by least squares over the area; 1 without any.
        carried_base: The same on the flat faces that the original stands on, None where there is no relief on any.
    """

    lowest: float
    highest: float
    carried: float
    carried_base: float | None


class Fit(msgspec.Struct, frozen=True, kw_only=True):
    """How the boundary of tetrahedra lies beside a part.

    Attributes:
        mean: Distance from the part, averaged over its vertices [mm].
        most: The largest [mm].
        volume: Volume of the tetrahedra over that of the part, less 1.
        relief: What the part has over its original, None if that is not known.
    """

    mean: float
    most: float
    volume: float
    relief: Relief | None = None

    @property
    def words(self) -> str:
        """Its figures, as they are told."""
        return f"{self.mean:.2f} mm beside the part on average, {self.most:.2f} mm at most, volume {self.volume:+.1%}"


def fit_of(tets: TetMesh, part: SurfaceMesh, original: SurfaceMesh | None = None) -> Fit:
    """How tetrahedra follow a part.

    Args:
        tets: The tetrahedra.
        part: The part as it was given, before it was standardised.
        original: What it was styled from, as it was given, in the same place; None if that is not known.
    """
    there = TriangleTree(tets.vertices, tets.boundary_faces).nearest(part.vertices)
    return Fit(
        mean=float(there.distance.mean()), most=float(there.distance.max()), volume=float(tets.volumes.sum()) / part.volume - 1.0,
        relief=None if original is None else _relief(part, original, there.point),
    )  # fmt: skip


def other_part(part: SurfaceMesh, original: SurfaceMesh) -> str:
    """A sentence if a part can hardly have been styled from an original, whose strength it is held to; "" if it can."""
    (low, high), (low_before, high_before) = ((mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)) for mesh in (part, original))
    short, long = np.sort([high - low, high_before - low_before], axis=0)
    remedy = "and the limit is that of the original: give the file that the part was styled from"
    if ((long > TIMES * short) & (long - short > BEYOND)).any():
        before, now = (" x ".join(f"{side:.3g}" for side in mesh.extents) for mesh in (original, part))
        return f"The original is {before} mm and the part {now} mm: they seem to be different parts, {remedy}."
    common = np.clip(np.minimum(high, high_before) - np.maximum(low, low_before), 0.0, None)
    if common.prod() < TOGETHER * min((high - low).prod(), (high_before - low_before).prod()):
        return f"The original and the part do not stand in the same place: they seem to be different parts, {remedy}."
    return ""


def _relief(part: SurfaceMesh, original: SurfaceMesh, followed: Floats) -> Relief:
    """The relief of a part, and how much of it is carried by points that follow its vertices [mm], shape [vertex_count, 3]."""
    near = TriangleTree(original.vertices, original.faces).nearest(part.vertices)
    normals, gone = original.face_normals[near.face], part.vertices - near.point
    side = np.where(np.einsum("ij,ij->i", gone, normals) < 0.0, -1.0, 1.0)
    outwards = np.divide(gone, side[:, None] * near.distance[:, None], out=normals.copy(), where=near.distance[:, None] > SEEN)
    heights = side * np.where(near.distance > SEEN, near.distance, 0.0), np.einsum("ij,ij->i", followed - near.point, outwards)
    base = resting_face(original)
    resting = np.zeros(len(part.vertices)) if base is None else np.isin(near.face, base.faces).astype(np.float64)
    under = part.vertex_areas * resting
    wanted, found = (_without_shift(height, resting, under) for height in heights)
    whole, low = slope(wanted, found, part.vertex_areas), slope(wanted, found, under)
    lowest, highest = float(heights[0].min()), float(heights[0].max())
    return Relief(lowest=lowest, highest=highest, carried=1.0 if whole is None else whole, carried_base=low)


def _without_shift(heights: Floats, resting: Floats, areas: Floats) -> Floats:
    """Heights over an original [mm], shape [vertex_count], less their mean under the part: any tetrahedra carry a shift as a whole."""
    return heights - resting * np.average(heights, weights=areas) if areas.any() else heights
