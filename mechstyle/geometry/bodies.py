"""A styled part as two bodies that fill it together: a shell that carries the style, and the rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import BadInput
from mechstyle.records.mesh import Bools, Floats, SurfaceMesh

DEPTH = 0.84
"""Thickness of the shell below the unstylized surface [mm]: two lines of plastic."""
SHARE = 0.4
"""Share of the wall that it may take at most, so that shells of two sides do not meet."""


def shell_and_rest(
    original: SurfaceMesh, styled: SurfaceMesh, free: Bools, thickness: NDArray[np.floating]
) -> tuple[SurfaceMesh, SurfaceMesh]:
    """Cut a styled part along a surface inside it; both bodies are closed, touch there and have the part's volume together.

    The cut lies below the unstylized surface, which is smoother than the styled one, and runs out into it where the style ends.

    Args:
        original: The unstylized surface.
        styled: The same faces on displaced vertices.
        free: Which vertices the style may move, shape [vertex_count].
        thickness: Local wall thickness [mm], shape [vertex_count].

    Raises:
        BadInput: If the style may go nowhere.
    """
    faces, of_shell = styled.faces, np.asarray(free[styled.faces].all(axis=1))
    # Without faces at an edge that joins two places of the border: both sides of the shell would share that edge.
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edge = np.unique(sides, axis=0, return_inverse=True)[1].reshape(-1, 3)
    while True:
        border = _touched(faces[~of_shell], len(free))
        twice = np.bincount(edge[of_shell].ravel(), minlength=int(edge.max()) + 1) == 2
        chords = of_shell & (border[sides].all(axis=1).reshape(-1, 3) & twice[edge]).any(axis=1)
        if not chords.any():
            break
        of_shell = of_shell & ~chords
    if not of_shell.any():
        raise BadInput("nothing of the part is styled, so it cannot be written as a styled shell and the rest: leave --bodies out")
    within = free & ~_touched(faces[~of_shell], len(free))
    moved = np.einsum("ij,ij->i", styled.vertices - original.vertices, original.vertex_normals)
    depth = np.maximum(np.minimum(moved, 0.0) - DEPTH, -SHARE * np.asarray(thickness, np.float64))
    cut = original.vertices + original.vertex_normals * np.minimum(depth, moved)[:, None]
    inner = np.where(within, len(free) + np.cumsum(within) - 1, np.arange(len(free)))
    vertices = np.concatenate([styled.vertices, cut[within]])
    outside, inside = faces[of_shell], inner[faces[of_shell]]
    shell, rest = np.concatenate([outside, inside[:, ::-1]]), np.concatenate([faces[~of_shell], inside])
    return without_unused(vertices, shell), without_unused(vertices, rest)


def _touched(faces: NDArray[np.integer], count: int) -> Bools:
    """Which of `count` vertices these faces use."""
    touched = np.zeros(count, dtype=bool)
    touched[faces.ravel()] = True
    return touched


def without_unused(vertices: Floats, faces: NDArray[np.integer]) -> SurfaceMesh:
    """A mesh of faces, shape [m, 3], and of those of the vertices [mm], shape [n, 3], that they use."""
    used, renumbered = np.unique(faces, return_inverse=True)
    return SurfaceMesh(vertices[used], renumbered.reshape(-1, 3))
