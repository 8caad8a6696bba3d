"""A print in its tetrahedra: where walls and solid layers lie, and what of the solid's density, stiffness and strength is there.

A slicer lays its walls along the outline of every layer, and fills what lies less than so many layers below what looks up, or above what
looks down: a point is in the shell if the surface is nearer than the walls are wide in its own layer, or nearer than the solid layers
upwards or downwards. Shell counts as solid, the rest as infill, and an element that holds both by the rule of mixtures, as they lie side
by side in it.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.spatial.transform import Rotation

from mechstyle.fea.discretisation import Relative
from mechstyle.fea.elements import element_named
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.records import Recipe
from mechstyle.records.infill import PATTERNS
from mechstyle.records.mesh import Floats, TetMesh
from mechstyle.records.recipe import Printed

POINTS = 64
"""Points in which a tetrahedron is looked at."""
STRETCHED = 20.0
"""Factor on one direction by which the nearest point of a surface is found in the others: within one layer, or straight above and below."""


@lru_cache(maxsize=4)  # one body is dropped, loaded and measured
def printed_body(tets: TetMesh, recipe: Recipe) -> Relative | None:
    """What the body of a recipe has of the properties of its plastic; None if it is solid."""
    printed, test = recipe.printed, recipe.test
    if printed.solid:
        return None
    shell = shell_shares(tets, printed, test.build_direction or (0.0, 0.0, 1.0))
    if element_named(test.element).points == 1:
        shell = shell.mean(axis=1, keepdims=True)
    density, stiffness, strength = (shell + (1.0 - shell) * of for of in PATTERNS[printed.infill_pattern].relative(printed.infill))
    return Relative(density, stiffness, strength)


def plastic_share(tets: TetMesh, recipe: Recipe) -> float:
    """Share of a body's volume that is plastic, 1 if it is solid."""
    relative = printed_body(tets, recipe)
    return 1.0 if relative is None else float(tets.volumes @ relative.density.mean(axis=1) / tets.volumes.sum())


def shell_shares(tets: TetMesh, printed: Printed, up: tuple[float, float, float]) -> Floats:
    """Share of walls and solid layers in the four corners of each tetrahedron, shape [tet_count, 4]: what is nearest to each Gauss point.

    `up` is the direction in which it is printed, of any length.
    """
    turn = Rotation.align_vectors([[0.0, 0.0, 1.0]], [up])[0].as_matrix()
    corners, near = tets.vertices @ turn.T, _points()
    points = np.einsum("pc,tcx->tpx", near, corners[tets.tets]).reshape(-1, 3)
    apart = np.repeat(0.5 * np.cbrt(tets.volumes / len(near)), len(near))  # from which a point counts in part, so that shares grow evenly
    a, b, c = (corners[tets.boundary_faces[:, corner]] for corner in range(3))
    looks = np.cross(b - a, c - a)[:, 2]
    inside = np.zeros(len(points))
    for stretch, faces, deep in (
        ([1.0, 1.0, STRETCHED], np.isfinite(looks), printed.walls * printed.line_width),
        ([STRETCHED, STRETCHED, 1.0], looks > 0.0, printed.top * printed.layer_height),
        ([STRETCHED, STRETCHED, 1.0], looks < 0.0, printed.bottom * printed.layer_height),
    ):
        if deep > 0.0:
            left = np.flatnonzero(inside < 1.0)  # of which it is not known yet that they are wholly in the shell
            even = np.minimum(apart[left], 2.0 * deep)
            tree = TriangleTree(corners * stretch, tets.boundary_faces[faces])
            found = tree.nearest(points[left] * stretch, 1.001 * (deep + 0.5 * float(even.max(initial=0.0))))
            share = 0.5 + (deep - found.distance) / even
            inside[left] = np.maximum(inside[left], np.clip(share, 0.0, 1.0))
    corner = near == near.max(axis=1, keepdims=True)  # the one that each point is nearest to
    return np.asarray(inside.reshape(-1, len(near)) @ np.asarray(corner / corner.sum(axis=0)))


@lru_cache(maxsize=1)
def _points() -> Floats:
    """Barycentric coordinates of points spread evenly over a tetrahedron, shape [POINTS, 4].

    They are the gaps between three numbers in order, of a sequence that fills a cube evenly (Roberts 2018), so that no plane holds many.
    """
    ratio = 1.2207440846057596  # the root of x⁴ = x + 1
    numbers = np.sort((0.5 + np.arange(1, POINTS + 1)[:, None] / ratio ** np.arange(1, 4)) % 1.0, axis=1)
    return np.diff(numbers, axis=1, prepend=0.0, append=1.0)
