"""A styled part read as its original with a relief, and how well tetrahedra follow a part as it was given."""

from __future__ import annotations

import msgspec
import numpy as np

from mechstyle.errors import BadInput
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.records.mesh import Field, SurfaceMesh, TetMesh
from mechstyle.simulation.body import SEEN

ROUNDS = 20
"""Times a vertex is moved along its normal towards the styled surface; on a slope of 45° each halves what is missing."""
ALIKE = 0.05
"""Distance of the styled surface from what the relief gives at which they are the same [mm]: less than a printer shows …"""
STRAYS = 0.02
"""… but for this share of the area, as a relief folds over itself here and there …"""
FAR = 1.0
"""… by this at most [mm]: 0.35 mm of a part in free bricks. A narrow slot lies further, and would be judged as none."""


class Fit(msgspec.Struct, frozen=True, kw_only=True):
    """How the boundary of tetrahedra lies to a part.

    Attributes:
        mean: Distance from the part, averaged over its vertices [mm].
        most: The largest [mm].
        volume: Volume of the tetrahedra over that of the part, less 1.
    """

    mean: float
    most: float
    volume: float

    @property
    def words(self) -> str:
        """Its figures in words."""
        return f"{self.mean:.2f} mm from the part on average, {self.most:.2f} mm at most, volume {self.volume:+.1%}"


def fit_of(tets: TetMesh, part: SurfaceMesh) -> Fit:
    """How tetrahedra follow a part as it was given, before it was standardised."""
    distance = TriangleTree(tets.vertices, tets.boundary_faces).nearest(part.vertices).distance
    return Fit(mean=float(distance.mean()), most=float(distance.max()), volume=float(tets.volumes.sum()) / part.volume - 1.0)


def relief_over(original: SurfaceMesh, styled: SurfaceMesh, given: SurfaceMesh | None = None) -> Field:
    """The relief that makes a styled part of its original [mm], shape [vertex_count].

    Each vertex of the original is moved along its normal to where it meets the styled surface.

    Args:
        original: The standardised original.
        styled: The part as it was given, in the same place.
        given: The original as it was given, from which standardising it may have gone; None for no further than ALIKE.

    Raises:
        BadInput: If the part is not its original with a relief.
    """
    if given is not None and styled.digest == given.digest:
        return np.zeros(len(original.vertices), np.float32)
    tree, normals = TriangleTree(styled.vertices, styled.faces), original.vertex_normals
    relief, limit = np.zeros(len(original.vertices)), 0.25 * original.size
    for _ in range(ROUNDS):
        there = original.vertices + relief[:, None] * normals
        relief = np.clip(relief + np.einsum("ij,ij->i", tree.nearest(there).point - there, normals), -limit, limit)
    made = original.displaced(relief.astype(np.float32))
    back = TriangleTree(made.vertices, made.faces).nearest(styled.vertices).distance
    areas = styled.vertex_areas
    own = ALIKE if given is None else 1.5 * float(TriangleTree(original.vertices, original.faces).nearest(given.vertices).distance.max())
    astray = float(areas[back > max(own, ALIKE)].sum() / areas.sum())
    if astray > STRAYS or back.max() > max(own, FAR):
        sizes = [" × ".join(f"{side:.3g}" for side in mesh.extents) for mesh in (styled, original)]
        raise BadInput(
            f"the part ({sizes[0]} mm) is not its original ({sizes[1]} mm) with a relief: {astray:.0%} of its surface is elsewhere"
            f" and one place lies {back.max():.1f} mm away;"
            " give the file it was styled from, in the same place and with as many --vertices, or leave the original out"
        )
    return np.where(np.abs(relief) < SEEN, 0.0, relief).astype(np.float32)
