"""How wide the faces of a part are: what sets a limit to the size of anything drawn on them."""

from __future__ import annotations

import numpy as np

from mechstyle.records.mesh import SurfaceMesh

SAMPLES = 600
"""Vertices that are asked, evenly spread over their numbers."""
TURNED = 0.5
"""Cosine of 60°: a face ends where the surface has turned by more; what looks the other way is the back of a wall."""
QUANTILE = 0.75
"""Share of the surface that lies in faces no wider: the middle of a strip is as far from its edges as its narrow rims are not."""


def face_width(mesh: SurfaceMesh) -> float:
    """Typical width of the faces of a part [mm], at most its size: about 70 for a cup 80 wide, 4 for the rim of a pair of spectacles.

    A vertex lies in a face as wide as twice its distance from the nearest vertex whose normal is across its own.
    """
    asked = np.unique(np.linspace(0, len(mesh.vertices) - 1, SAMPLES).astype(int))
    reach = np.array([_to_an_edge(mesh, vertex) for vertex in asked])
    order = np.argsort(reach)
    share = np.cumsum(mesh.vertex_areas[asked][order])
    return min(2.0 * float(reach[order][np.searchsorted(share, QUANTILE * share[-1])]), mesh.size)


def _to_an_edge(mesh: SurfaceMesh, vertex: int) -> float:
    """Distance from a vertex to the nearest one whose normal is across its own [mm], infinite if there is none."""
    across = np.abs(mesh.vertex_normals @ mesh.vertex_normals[vertex]) < TURNED
    return float(np.linalg.norm(mesh.vertices[across] - mesh.vertices[vertex], axis=1).min(initial=np.inf))
