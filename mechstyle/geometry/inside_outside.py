"""Inside and outside of a hollow part: how much of the sky each place sees, and where one ends and the other begins."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from mechstyle._warp import wp
from mechstyle.geometry.kernels import count_escapes
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.records.mesh import Floats, SurfaceMesh

RAYS = 128
HIDDEN, OPEN = 0.51, 0.97
"""Sky seen by what is surely inside and surely outside: the wall of a cup sees half of it even at the rim, and less below."""
CONVEXITY = 8.0
"""How much more loosely two vertices hang together for each radian by which the surface bends away between them."""
LEAST_SHARE = 0.005
"""Smaller pieces, of the area, belong to what surrounds them."""
CONTAINED = 0.3
"""Least share of the area that is inside in a container: half of it where walls are thin."""
UPRIGHT, OPENING = 0.9, 0.1
"""Least cosine of the angle between the way out of a container and straight up, and least opening over the box around it."""


KEPT = 4
"""Surfaces whose answer is kept: a run asks for each picture, and first while it prepares the part, which it then reads from disk."""
_known: dict[str, NDArray[np.bool_]] = {}


def is_inside(mesh: SurfaceMesh, *, device: str = "cpu") -> NDArray[np.bool_]:
    """Whether each vertex lies in a hollow that opens to the outside, shape [vertex_count].

    What sees less than half of the sky is inside, what sees nearly all of it outside. In between, by the random walker (Grady 2006),
    each vertex goes where a walk along the surface ends more probably; walks rarely cross convex edges, so that the border runs along
    the rim, and the open floor of a flat tray goes with the walls around it.

    Args:
        mesh: A closed surface; one of the same vertices and faces as a few before is not asked again.
        device: Warp device.
    """
    inside = _known.get(mesh.digest)
    if inside is None:
        inside = _told_apart(mesh, openness(mesh, device=device))
        while len(_known) >= KEPT:
            _known.pop(next(iter(_known)), None)
        _known[mesh.digest] = inside
    return inside


def _told_apart(mesh: SurfaceMesh, sky: Floats) -> NDArray[np.bool_]:
    """Whether each vertex is inside, given the share of the sky that it sees, shape [vertex_count]; write-protected."""
    inside, outside = sky < HIDDEN, sky > OPEN
    if inside.any() and outside.any():
        inside = _without_specks(mesh, _walked(mesh, inside, outside) > 0.5)
    inside.setflags(write=False)
    return inside


def is_container(mesh: SurfaceMesh) -> bool:
    """Whether a part, as it stands, holds things: its inside is large and opens upwards only, as that of a cup, a tray or a case.

    By the divergence theorem the normals of an inside add up to its openings. Those of a tube open at both ends cancel out.
    """
    inside = is_inside(mesh)
    areas = mesh.vertex_areas
    opening = areas[inside] @ mesh.vertex_normals[inside]
    hollow = areas[inside].sum() >= CONTAINED * areas.sum()
    return bool(hollow and opening[2] > UPRIGHT * np.linalg.norm(opening) and opening[2] > OPENING * mesh.extents[:2].prod())


def openness(mesh: SurfaceMesh, *, device: str = "cpu") -> Floats:
    """Share of the sky each vertex sees past the part itself, as a diffuse light would shine on it, in [0, 1], shape [vertex_count]."""
    return escaping(TriangleTree(mesh.vertices, mesh.faces, device), mesh.vertices, mesh.vertex_normals, mesh.size)


def escaping(tree: TriangleTree, points: Floats, normals: Floats, size: float) -> Floats:
    """Share of a diffuse light at points, shape [n, 3], that gets past a surface, in [0, 1], shape [n].

    Args:
        tree: The surface.
        points: Positions on it [mm], shape [n, 3].
        normals: Unit vectors to the side that is lit, shape [n, 3].
        size: Of the surface [mm].
    """
    towards: Any = wp.array(normals.astype(np.float32), dtype=wp.vec3, device=tree.device)
    rays: Any = wp.array(_cosine_directions(RAYS), dtype=wp.vec3, device=tree.device)
    escaped: Any = wp.empty(len(points), dtype=wp.int32, device=tree.device)
    inputs = [tree.id, tree.points(points), towards, rays, 1e-4 * size, 2.0 * size, escaped]
    wp.launch(count_escapes, dim=len(points), inputs=inputs, device=tree.device)
    return np.asarray(escaped.numpy() / RAYS, dtype=np.float64)


def _cosine_directions(count: int) -> NDArray[np.float32]:
    """Unit vectors about z as dense as the cosine of their angle to it: a Fibonacci spiral on the disc, lifted to the hemisphere."""
    k = np.arange(count) + 0.5
    radius, angle = np.sqrt(k / count), np.pi * (3.0 - np.sqrt(5.0)) * k
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1.0 - radius**2)]).astype(np.float32)


def _walked(mesh: SurfaceMesh, ones: NDArray[np.bool_], zeros: NDArray[np.bool_]) -> Floats:
    """Probability that a random walk from each vertex meets `ones` before `zeros`: the Laplace equation on the graph of edges."""
    a, b = mesh.edges.T
    way = mesh.vertices[b] - mesh.vertices[a]
    bend = np.einsum("ij,ij->i", mesh.vertex_normals[b] - mesh.vertex_normals[a], way) / np.linalg.norm(way, axis=1)
    weight, count = np.exp(-CONVEXITY * np.maximum(bend, 0.0)), len(mesh.vertices)
    links = sp.coo_array((np.tile(weight, 2), (np.concatenate([a, b]), np.concatenate([b, a]))), shape=(count, count)).tocsr()
    laplacian = (sp.diags_array(links.sum(axis=1)) - links).tocsr()
    free, known = ~(ones | zeros), ones.astype(np.float64)
    if free.any():
        inner = laplacian[free][:, free].tocsc()
        known[free] = splu(inner, permc_spec="MMD_AT_PLUS_A").solve(-(laplacian[free] @ known))
    return known


def _without_specks(mesh: SurfaceMesh, inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The same with pieces of less than `LEAST_SHARE` of the area given to the other side."""
    same = inside[mesh.edges[:, 0]] == inside[mesh.edges[:, 1]]
    count = len(mesh.vertices)
    graph = sp.coo_array((np.ones(int(same.sum())), mesh.edges[same].T), shape=(count, count))
    piece = connected_components(graph, directed=False)[1]
    areas = np.bincount(piece, mesh.vertex_areas)
    return np.asarray(inside ^ (areas < LEAST_SHARE * areas.sum())[piece])
