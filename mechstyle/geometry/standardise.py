"""An even triangulation with a wished number of vertices that keeps sharp edges where they are."""

from __future__ import annotations

import math
import warnings
from typing import Any

import manifold3d
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from mechstyle.errors import BadInput
from mechstyle.mesh import SurfaceMesh

FEWEST, MOST = 500, 400_000
SHARP = math.cos(math.radians(30.0))  # of the angle between the normals of two faces, below which their edge is a feature
TRIALS = 9
TRIAL_ITERATIONS, ITERATIONS = 3, 8  # of the remesher: few suffice to see the count


def standardise(mesh: SurfaceMesh, vertices: int = 25_000, tolerance: float = 0.05) -> SurfaceMesh:
    """The surface in nearly equilateral triangles of one size.

    Needless vertices go (Manifold), long edges are cut, and isotropic remeshing by splits, collapses, flips and tangential
    smoothing with projection (Botsch and Kobbelt 2004) evens the rest out, with the vertices of edges sharper than 30° fixed.
    The edge length is corrected until the count fits.

    Args:
        mesh: A closed surface, any triangulation.
        vertices: Vertices wanted, 500 to 400 000.
        tolerance: Accepted deviation from that count, over the count.

    Returns:
        A closed surface with the same number of handles and shells; the same input gives the same bytes. Colours are dropped.

    Raises:
        BadInput: If the count is out of range or cannot be reached, or the surface is not closed.
    """
    if not FEWEST <= vertices <= MOST:
        raise BadInput(f"cannot standardise to {vertices} vertices: ask for {FEWEST} to {MOST}")
    body = manifold_of(mesh)
    if body.status() != manifold3d.Error.NoError or body.is_empty():
        raise BadInput("cannot standardise a surface that is not closed; load it with mechstyle, which repairs it or says why not")
    edge = even_edge(mesh, 2 * vertices)  # a closed surface has about two faces per vertex (Euler)
    short, long = 0.0, math.inf
    for trial in range(TRIALS):
        found = remeshed(body, edge, tolerance=0.01 * edge, iterations=TRIAL_ITERATIONS if trial == 0 else ITERATIONS)
        if trial > 0 and abs(len(found.vertices) / vertices - 1.0) <= tolerance and _shape(found) == _shape(mesh):
            return found
        edge, short, long = _corrected(edge, len(found.vertices) / vertices, short, long)
    raise BadInput(f"this part could not be brought to {vertices} even vertices (the nearest was {len(found.vertices)}); "
                   f"ask for {'more' if len(found.vertices) > vertices else 'another number'}")


def _corrected(edge: float, excess: float, short: float, long: float) -> tuple[float, float, float]:
    """The next edge length to try [mm], and the longest known to give too many vertices and the shortest known to give too few.

    The count goes with the inverse square of the edge length, roughly: it jumps where the first cut of a coarse input changes, and
    then halving the bracket finds what the square root steps over.
    """
    short, long = (max(short, edge), long) if excess > 1.0 else (short, min(long, edge))
    wanted = edge * math.sqrt(excess)
    return (wanted if short < wanted < long else math.sqrt(short * long)), short, long


def manifold_of(mesh: SurfaceMesh) -> Any:
    """The surface as a Manifold, in double precision; look at its status before use."""
    return manifold3d.Manifold(manifold3d.Mesh64(mesh.vertices.copy(), mesh.faces.astype(np.uint64)))


def surface_of(body: Any) -> SurfaceMesh:
    """The surface of a Manifold."""
    mesh = body.to_mesh64()
    return SurfaceMesh(mesh.vert_properties[:, :3], mesh.tri_verts)


def remeshed(body: Any, edge: float, *, tolerance: float, iterations: int = ITERATIONS) -> SurfaceMesh:
    """A Manifold in even triangles.

    Args:
        body: The Manifold.
        edge: Edge length [mm].
        tolerance: Most by which removing needless vertices beforehand may move the surface [mm].
        iterations: Rounds of splits, collapses, flips and smoothing.
    """
    fine = surface_of(body.simplify(tolerance).refine_to_length(edge))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the remesher warns if every vertex is fixed; the count then says so
        from gpytoolbox import remesh_botsch  # noqa: PLC0415 (importing it warns of its own use of SciPy)

        vertices, faces = remesh_botsch(
            fine.vertices.copy(), fine.faces.copy(), i=iterations, h=edge, project=True, feature=_sharp_vertices(fine)
        )
    return SurfaceMesh(vertices, faces)


def even_edge(mesh: SurfaceMesh, faces: float) -> float:
    """Edge length [mm] of equilateral triangles, so many that `faces` of them have the area of the mesh."""
    return math.sqrt(4.0 / math.sqrt(3.0) * float(mesh.face_areas.sum()) / faces)


def _sharp_vertices(mesh: SurfaceMesh) -> NDArray[np.int32]:
    """Vertices of edges where the surface turns by more than 30°, ascending."""
    directed = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    face = np.repeat(np.arange(len(mesh.faces)), 3)
    order = np.lexsort(np.sort(directed, axis=1).T)  # a closed surface has each edge twice, now side by side
    one, other = face[order].reshape(-1, 2).T
    turn = np.einsum("ij,ij->i", mesh.face_normals[one], mesh.face_normals[other])
    return np.unique(directed[order].reshape(-1, 4)[turn < SHARP]).astype(np.int32)


def _shape(mesh: SurfaceMesh) -> tuple[bool, int, int]:
    """Whether it is closed, its Euler characteristic, and its number of shells."""
    used = np.unique(mesh.faces)
    euler = len(used) - len(mesh.edges) + len(mesh.faces)
    return mesh.is_closed, euler, shell_count(mesh)


def shell_count(mesh: SurfaceMesh) -> int:
    """Number of connected shells, bodies and cavities alike."""
    count = len(mesh.vertices)
    graph = sp.coo_array((np.ones(len(mesh.edges)), mesh.edges.T), shape=(count, count))
    labels = connected_components(graph, directed=False)[1]
    return len(np.unique(labels[mesh.faces[:, 0]]))
