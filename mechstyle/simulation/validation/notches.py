"""Flat bars in tension with a notch whose stress concentration is in handbooks, of structured tetrahedra."""

import numpy as np

from mechstyle.records.mesh import TetMesh
from mechstyle.simulation.validation.meshes import lattice

WIDTH, THICKNESS = 20.0, 4.0
"""Of both bars [mm]."""


def bar_with_hole(radius: float, around: int, out: int, layers: int, reach: float = 40.0) -> TetMesh:
    """A bar along x with a round hole at the origin, from −reach to reach [mm].

    Args:
        radius: Of the hole [mm].
        around: Cells around the hole, a multiple of 8.
        out: Cells from the hole to the edge of the bar; smaller at the hole.
        layers: Cells through the thickness.
        reach: Half the length [mm].
    """
    half = WIDTH / 2.0
    angles = np.linspace(-np.pi / 4, 2 * np.pi - np.pi / 4, around + 1)
    graded = np.linspace(0.0, 1.0, out + 1) ** 1.6
    z = np.linspace(0.0, THICKNESS, layers + 1)
    ring = lattice(graded, angles, z)
    share, angle, height = ring.vertices.T
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    square = half * way / np.abs(way).max(axis=1, keepdims=True)
    flat = (1.0 - share[:, None]) * radius * way + share[:, None] * square
    ring = ring.moved(np.column_stack([flat, height]))
    side = np.linspace(-np.pi / 4, np.pi / 4, around // 4 + 1)
    beyond = lattice(np.linspace(half, reach, round((reach - half) / 4.0) + 1), half * np.tan(side), z)
    return _joined(ring, beyond, beyond.moved(beyond.vertices * [-1.0, -1.0, 1.0]))


def bar_with_fillets(radius: float, steps: int, across: int, layers: int, reach: float = 40.0) -> TetMesh:
    """A bar along x that grows by quarter circles from WIDTH − 2 radius, x < 0, to WIDTH, x > radius [mm].

    Args:
        radius: Of the fillets [mm].
        steps: Cells along a fillet.
        across: Cells over the width, smaller at both edges.
        layers: Cells through the thickness.
        reach: Length on both sides [mm].
    """
    arc = np.linspace(0.0, np.pi / 2, steps + 1)
    fine = radius * np.pi / 2 / steps
    graded = reach * np.linspace(0.0, 1.0, 13)[1:] ** 2.0
    far = graded[graded > fine]
    x = np.concatenate([-far[::-1], radius * np.sin(arc), radius + far])
    half = np.concatenate([np.full(len(far), WIDTH / 2 - radius), WIDTH / 2 - radius * np.cos(arc), np.full(len(far), WIDTH / 2)])
    across_share = np.sin(np.linspace(-np.pi / 2, np.pi / 2, across + 1))
    bar = lattice(x, across_share, np.linspace(0.0, THICKNESS, layers + 1))
    vertices = bar.vertices.copy()
    vertices[:, 1] *= np.interp(vertices[:, 0], x, half)
    return bar.moved(vertices)


def _joined(*parts: TetMesh) -> TetMesh:
    """Meshes as one, vertices in one place made one."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    points = np.concatenate([part.vertices for part in parts])
    _, first, number = np.unique(np.round(points, 6), axis=0, return_index=True, return_inverse=True)
    return TetMesh(points[first], number.ravel()[np.concatenate([part.tets + start for part, start in zip(parts, starts, strict=True)])])
