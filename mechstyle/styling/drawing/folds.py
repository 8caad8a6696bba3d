"""Relief that would fold over itself, and how it is lowered until it does not."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import Floats, SurfaceMesh
from mechstyle.styling.drawing.operators import Operators

_STEEPEST = 0.17  # cosine of 80°, the most a face may turn
_ROUNDS = 60


def unfolded(operators: Operators, displacement: Floats) -> Floats:
    """The displacement [mm], shape [n], lowered around every face that would turn by more than 80°.

    Normals converge in an inner corner and diverge little across a steep edge, so that moved vertices can overtake each other. There
    the relief is drawn towards that of its neighbours and a little towards zero, in rounds, which ends at the undisplaced surface at
    the latest. It never grows, so that limits kept before are still kept.
    """
    mesh = operators.mesh
    lowered, with_area = displacement.copy(), mesh.face_areas > 0.0
    nearby = np.flatnonzero(with_area)
    for _ in range(_ROUNDS):
        styled = SurfaceMesh(mesh.displaced(lowered).vertices, mesh.faces[nearby])
        turned = nearby[np.einsum("ij,ij->i", styled.face_normals, mesh.face_normals[nearby]) < _STEEPEST]
        if not len(turned):
            break
        around = np.unique(mesh.faces[turned])
        calm = 0.5 * lowered[around] + 0.4 * (operators.ring_mean[around] @ lowered)
        low, high = np.minimum(0.0, 0.95 * lowered[around]), np.maximum(0.0, 0.95 * lowered[around])
        lowered[around] = np.clip(calm, low, high)
        moved = np.zeros(len(lowered), bool)
        moved[around] = True
        nearby = np.flatnonzero(moved[mesh.faces].any(axis=1) & with_area)  # no other face has turned since
    return lowered
