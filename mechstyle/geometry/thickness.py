"""How thick the walls of a part are, by the shrinking ball, and how wide its faces."""

from __future__ import annotations

import math
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra

from mechstyle._warp import wp
from mechstyle.geometry.kernels import shrink_balls
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.records.mesh import Floats, SurfaceMesh

# A ball counts as empty if nothing reaches deeper into it than a tenth of its radius. In the centre of a sphere every
# triangle is equally near and the search visits all of them: 0.97 takes 11 times longer there, for exactness nobody needs.
SLACK = 0.9
FACING = 120.0
"""Least angle between the contacts of a ball in a wall, seen from its centre [degrees]; 180 between parallel sides."""


def local_thickness(mesh: SurfaceMesh, *, separation: float = 100.0, slope: float = 1.0) -> NDArray[np.float64]:
    """Diameter of the largest ball inside the part that touches it at each vertex [mm], shape [vertex_count], at most 10 % too large.

    The shrinking ball of Ma, Bae and Choi (2012) as used for wall thickness by Inui, Umezu and Shimane (2016), on the
    triangles themselves. It starts from half the way of a ray to the opposite wall and so never exceeds that way.

    Args:
        mesh: A closed surface.
        separation: Least angle between the two contacts, seen from the centre of the ball [degrees]. 0 gives the pure
            ball, which vanishes at convex edges; 100 measures the wall there instead.
        slope: Most that thickness may grow per way along the surface. The narrow side of a plate looks across the whole
            plate; this ties it to the plate's thickness. Infinity leaves the balls as they are.
    """
    balls, _ = _inner_balls(mesh, separation, TriangleTree(mesh.vertices, mesh.faces))
    return balls if math.isinf(slope) else limited_slope(balls, mesh, slope)


def wall_thickness(mesh: SurfaceMesh, tree: TriangleTree | None = None) -> Floats:
    """Thickness between two sides that face each other [mm], shape [vertex_count]; the size of the part where there is no other side.

    Beside an edge the ball that touches both of its faces shrinks with the distance from the edge. That is no wall, and the finer the
    mesh the closer its vertices come. So both contacts must lie `FACING` apart: a wedge of more than 60 degrees has no wall.
    """
    balls, cosine = _inner_balls(mesh, FACING, tree or TriangleTree(mesh.vertices, mesh.faces))
    return np.where(cosine < math.cos(math.radians(FACING)), balls, mesh.size)


def _inner_balls(mesh: SurfaceMesh, separation: float, tree: TriangleTree) -> tuple[Floats, Floats]:
    """Diameter of the ball at each vertex [mm] and the cosine of the angle between its contacts, shape [vertex_count] each."""
    count, device = len(mesh.vertices), tree.device
    diameter, cosine = (wp.empty(count, dtype=wp.float32, device=device) for _ in range(2))
    normals: Any = wp.array(mesh.vertex_normals.astype(np.float32), dtype=wp.vec3, device=device)
    skin = 1e-4 * mesh.size
    limits = [mesh.size, skin, math.cos(math.radians(separation)), SLACK]
    wp.launch(shrink_balls, dim=count, inputs=[tree.id, tree.points(mesh.vertices), normals, *limits, diameter, cosine], device=device)
    return np.asarray(diameter.numpy(), dtype=np.float64), np.asarray(cosine.numpy(), dtype=np.float64)


def limited_slope(values: Floats, mesh: SurfaceMesh, slope: float) -> Floats:
    """The largest field below values that grows by at most a slope along the edges (Persson 2006), shape [vertex_count].

    It is the minimum over u of values(u) + slope · way(u, v), a lower envelope of cones.

    One shortest-path search from an extra node, joined to every vertex by an edge as long as its value.
    """
    count = len(values)
    a, b = mesh.edges.T
    ways = slope * np.linalg.norm(mesh.vertices[a] - mesh.vertices[b], axis=1)
    start = np.full(count, count)
    rows, columns = np.concatenate([a, b, start]), np.concatenate([b, a, np.arange(count)])
    # A stored zero means "no edge" to the search, so lengths stay above zero.
    lengths = np.maximum(np.concatenate([ways, ways, values]), 1e-12)
    graph = sp.csr_array((lengths, (rows, columns)), shape=(count + 1, count + 1))
    return np.asarray(dijkstra(graph, indices=count)[:count], dtype=np.float64)


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
    if mesh not in _widths:  # every style on a part asks for it, and it is as much work as drawing one
        asked = np.unique(np.linspace(0, len(mesh.vertices) - 1, SAMPLES).astype(int))
        reach = np.empty(len(asked))
        for number, vertex in enumerate(asked):
            across = np.abs(mesh.vertex_normals @ mesh.vertex_normals[vertex]) < TURNED
            reach[number] = np.linalg.norm(mesh.vertices[across] - mesh.vertices[vertex], axis=1).min(initial=np.inf)
        order = np.argsort(reach)
        share = np.cumsum(mesh.vertex_areas[asked][order])
        _widths[mesh] = min(2.0 * float(reach[order][np.searchsorted(share, QUANTILE * share[-1])]), mesh.size)
    return _widths[mesh]


_widths: WeakKeyDictionary[SurfaceMesh, float] = WeakKeyDictionary()
"""Those of the parts there are."""
