"""An even triangulation with a wished number of vertices that keeps sharp edges where they are."""

from __future__ import annotations

import heapq
import math
from typing import Any

import manifold3d
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from mechstyle.errors import BadInput
from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.cleaning import heights, mended, without_degenerate
from mechstyle.geometry.remeshing.decimation import decimated
from mechstyle.geometry.remeshing.isotropic import isotropic
from mechstyle.geometry.remeshing.tolerances import TOL
from mechstyle.geometry.remeshing.topology import EdgePairs, edge_pairs, edges_of
from mechstyle.records.mesh import FEWEST_VERTICES, MOST_VERTICES, STANDARD_VERTICES, Floats, SurfaceMesh


def check_vertices(vertices: int) -> None:
    """Refuse a number of vertices to which no surface is standardised."""
    if not FEWEST_VERTICES <= vertices <= MOST_VERTICES:
        raise BadInput(f"cannot standardise to {vertices} vertices: ask for {FEWEST_VERTICES} to {MOST_VERTICES}")


def even(mesh: SurfaceMesh, vertices: int = STANDARD_VERTICES, go_on: CancelCheck = never_cancel) -> SurfaceMesh:
    """The surface in nearly equilateral triangles of one size.

    Needless vertices go (Manifold), long edges are cut, and isotropic remeshing by splits, collapses, flips and tangential
    smoothing with projection (Botsch and Kobbelt 2004) evens the rest out, with the vertices of edges sharper than 30° fixed.
    Rounds narrower than a triangle would come out ragged; they are sampled by fixed vertices as close as they are narrow, in rows.
    The edge length is corrected until the count fits.

    A relief that is finer than the triangles, as a delivered surface has it, may have more vertices on its creases than are wished for.
    Such a surface is decimated instead (Garland and Heckbert 1997): its triangles are less even, but it keeps its shape.

    The result is closed and has as many handles and shells, its vertices on the part (next to it where it was decimated) and none of its
    triangles without area; the same input gives the same bytes. Colours are dropped.

    Raises:
        BadInput: If the count is not 500 to 400 000 or cannot be reached, or the surface is not closed.
    """
    check_vertices(vertices)
    body = manifold_of(mesh)
    if body.status() != manifold3d.Error.NoError or body.is_empty():
        raise BadInput("cannot standardise a surface that is not closed; load it with mechstyle, which repairs it or says why not")
    shape, edge = _shape(mesh), even_edge(mesh, 2 * vertices)  # a closed surface has about two faces per vertex (Euler)
    fine = _refined(body, edge, TOL.simplified * edge, go_on)
    if _too_many_creases(fine, vertices):
        fewer = decimated(fine, len(fine.faces) - 2 * (len(fine.vertices) - vertices), go_on, longest=TOL.flat_reach * edge)
        found = without_degenerate(fewer, TOL.lowest * edge, go_on)
        met = abs(len(found.vertices) / vertices - 1.0) <= TOL.missed
        if met and _shape(found) == _shape(surface_of(body)) and _has_area(found, edge):
            return found
    short, long, nearly = 0.0, math.inf, None
    for trial in range(TOL.trials):
        iterations = TOL.trial_iterations if trial == 0 else TOL.iterations
        found = remeshed(body, edge, tolerance=TOL.simplified * edge, iterations=iterations, go_on=go_on)
        missed = abs(len(found.vertices) / vertices - 1.0)
        if trial > 0 and missed <= 2.0 * TOL.missed and _shape(found) == shape and _has_area(found, edge):
            if missed <= TOL.missed:
                return found
            nearly = nearly or found
        # The count goes with the inverse square of the edge length, roughly: it jumps where the first cut of a coarse input changes, and
        # then halving the bracket finds what the square root steps over.
        excess = len(found.vertices) / vertices
        short, long = (max(short, edge), long) if excess > 1.0 else (short, min(long, edge))
        wanted = edge * math.sqrt(excess)
        edge = wanted if short < wanted < long else math.sqrt(short * long)
    if nearly is not None:
        return nearly
    left = "" if _has_area(found, edge) else ", with triangles without area"
    raise BadInput(
        f"this part could not be brought to {vertices} even vertices (the nearest was {len(found.vertices)}{left}); "
        f"ask for {'more' if len(found.vertices) > vertices else 'another number'}"
    )


def crowded(body: Any, edge: float, vertices: float, go_on: CancelCheck = never_cancel) -> bool:
    """Whether the creases of a Manifold have too many vertices for even triangles of so many vertices to keep them.

    Those count that are left where straight creases are simplified and cut into edges of this length [mm].
    """
    return _too_many_creases(_refined(body, edge, TOL.simplified * edge, go_on), vertices)


def _too_many_creases(mesh: SurfaceMesh, vertices: float) -> bool:
    edges, turns, _ = _bends(mesh)
    return len(np.unique(edges[turns > TOL.crease])) >= TOL.crowded * vertices


def _has_area(mesh: SurfaceMesh, edge: float) -> bool:
    """Whether every triangle of a mesh of this edge length [mm] has an area."""
    return bool(heights(mesh.corners).min() >= TOL.no_area * edge)


def manifold_of(mesh: SurfaceMesh) -> Any:
    """The surface as a Manifold, in double precision; look at its status before use."""
    return manifold3d.Manifold(manifold3d.Mesh64(mesh.vertices.copy(), mesh.faces.astype(np.uint64)))


def surface_of(body: Any) -> SurfaceMesh:
    """The surface of a Manifold."""
    mesh = body.to_mesh64()
    return SurfaceMesh(mesh.vert_properties[:, :3], mesh.tri_verts)


def remeshed(
    body: Any, edge: float, *, tolerance: float, iterations: int = TOL.iterations, go_on: CancelCheck = never_cancel
) -> SurfaceMesh:
    """A Manifold in even triangles of an edge length [mm], after `iterations` of splits, collapses, flips and smoothing.

    Removing needless vertices beforehand moves the surface by `tolerance` at most [mm]; BadInput if nothing is left of it.
    """
    original, fine = surface_of(body), _refined(body, edge, tolerance, go_on)
    creases, rounds = _fixed(fine, edge)
    part = TriangleTree(original.vertices, original.faces)
    evened = isotropic(fine, edge, part, creases=creases, rounds=rounds, iterations=iterations, go_on=go_on)
    go_on()
    there = part.nearest(evened.vertices)
    landed = evened.moved(np.where(there.distance[:, None] > TOL.on_the_part, there.point, evened.vertices))
    return without_degenerate(mended(landed, part, len(creases), go_on), TOL.lowest * edge, go_on)


def _refined(body: Any, edge: float, tolerance: float, go_on: CancelCheck) -> SurfaceMesh:
    """A Manifold without the vertices that it needs for no more than a tolerance [mm], long edges cut; BadInput if nothing is left."""
    simple = body.simplify(tolerance)
    go_on()
    if simple.is_empty():
        raise BadInput(f"this part is thinner than {2.0 * tolerance:.2g} mm everywhere: check its unit (--scale), or ask for more vertices")
    fine = surface_of(_without_false_creases(simple, tolerance).refine_to_length(edge))
    go_on()
    return fine


def _without_false_creases(body: Any, tolerance: float) -> Any:
    """The Manifold, where it has needles lower than a tolerance [mm] along two creases, without what is that low.

    Needles are what is left of rounds that were simplified. They look anywhere, so that the surface seems to turn sharply on both of their
    long sides, and the vertices fixed there came to stand side by side in either order.
    """
    mesh = surface_of(body)
    pairs = edge_pairs(mesh.faces)
    sharp = np.bincount(pairs.faces[_turns(mesh, pairs) > TOL.crease].ravel(), minlength=len(mesh.faces))
    needles = (sharp > 1) & (heights(mesh.corners) < tolerance)
    return manifold_of(without_degenerate(mesh, tolerance)) if needles.any() else body


def _fixed(mesh: SurfaceMesh, edge: float) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Vertices on creases, ascending, and others that sample the rounds narrower than a triangle of this edge length [mm].

    What a part stands on ends at a crease, too, however little the surface turns there: a landing goes through that face. Along the middle
    of each round vertices stand in a row, which the rim of a part is seen by: anywhere across it they made it ragged.
    """
    edges, turns, radii = _bends(mesh)
    sharp = np.unique(edges[turns > TOL.crease]).astype(np.int32)
    low, pairs = (mesh.corners[:, :, 2] < mesh.vertices[:, 2].min() + TOL.on_the_part).all(axis=1), edge_pairs(mesh.faces)
    ends = np.setdiff1d(pairs.edges[low[pairs.faces[:, 0]] != low[pairs.faces[:, 1]]], sharp).astype(np.int32)
    close = _spread(mesh.vertices[ends], np.full(len(ends), TOL.finest_step * edge), np.zeros(len(ends)))
    creases = np.union1d(sharp, ends[close])
    radius = np.full(len(mesh.vertices), np.inf)
    bent = (turns > TOL.bend) & (turns <= TOL.crease)
    np.minimum.at(radius, edges[bent].ravel(), np.repeat(radii[bent], 2))
    narrow = np.setdiff1d(np.flatnonzero(radius < TOL.widest_step * edge), creases).astype(np.int32)
    others = np.delete(mesh.vertices, narrow, axis=0)
    depths = np.asarray(cKDTree(others).query(mesh.vertices[narrow])[0]) if len(others) else np.zeros(len(narrow))
    steps = np.clip(radius[narrow], TOL.finest_step * edge, TOL.widest_step * edge)
    if len(creases) and len(narrow):
        clear = cKDTree(mesh.vertices[creases]).query(mesh.vertices[narrow])[0] > TOL.clearance * steps
        narrow, depths, steps = narrow[clear], depths[clear], steps[clear]
    return creases, narrow[_spread(mesh.vertices[narrow], steps, np.round(depths / (TOL.row * edge)))]


def _bends(mesh: SurfaceMesh) -> tuple[NDArray[np.int32], Floats, Floats]:
    """The edges of a closed surface, shape [k, 2], the angle by which it turns there, and the radius of the turn [mm], shape [k].

    Between two bends of a round lie strips as wide as the triangles are high over the bend, so that its radius is their mean height
    over the angle.
    """
    pairs = edge_pairs(mesh.faces)
    turns = _turns(mesh, pairs)
    start, end = mesh.vertices[pairs.edges].transpose(1, 0, 2)
    heights = mesh.face_areas[pairs.faces].sum(axis=1) / np.linalg.norm(end - start, axis=1)
    return pairs.edges, turns, heights / np.maximum(turns, 1e-9)


def _turns(mesh: SurfaceMesh, pairs: EdgePairs) -> Floats:
    """The angle by which a closed surface turns at each of its edges, shape [k]."""
    one, other = mesh.face_normals[pairs.faces].transpose(1, 0, 2)
    return np.asarray(np.arccos(np.clip(np.einsum("ij,ij->i", one, other), -1.0, 1.0)))


def _spread(points: Floats, steps: Floats, rows: Floats) -> NDArray[np.int64]:
    """Indices of points no closer to each other than the step of the first of them [mm], those of high rows first.

    In a row each is the nearest to one before it, so that a row is as close as steps allow.
    """
    if not len(points):
        return np.zeros(0, np.int64)
    tree, free, taken = cKDTree(points), np.ones(len(points), bool), []
    waiting = [(-row, math.inf, index) for index, row in enumerate(rows.tolist())]
    heapq.heapify(waiting)
    while waiting:
        _, _, index = heapq.heappop(waiting)
        if not free[index]:
            continue
        taken.append(index)
        free[tree.query_ball_point(points[index], steps[index])] = False
        around = np.array(tree.query_ball_point(points[index], TOL.next_in_row * steps[index]), np.int64)
        for next_one in around[free[around]].tolist():
            heapq.heappush(waiting, (-float(rows[next_one]), float(np.linalg.norm(points[next_one] - points[index])), next_one))
    return np.array(taken, np.int64)


def even_edge(mesh: SurfaceMesh, faces: float) -> float:
    """Edge length [mm] of equilateral triangles, so many that `faces` of them have the area of the mesh."""
    return math.sqrt(4.0 / math.sqrt(3.0) * float(mesh.face_areas.sum()) / faces)


def _shape(mesh: SurfaceMesh) -> tuple[bool, int, int]:
    """Whether it is closed, its Euler characteristic, and its number of shells."""
    used = int(np.count_nonzero(np.bincount(mesh.faces.ravel())))
    euler = used - len(edges_of(mesh.faces)) + len(mesh.faces)
    return mesh.is_closed, euler, shell_count(mesh)


def shell_count(mesh: SurfaceMesh) -> int:
    """Number of connected shells, bodies and cavities alike."""
    count = len(mesh.vertices)
    one, other = mesh.faces[:, [0, 1, 0, 2]].reshape(-1, 2).T  # two sides connect a face
    graph = sp.coo_array((np.ones(len(one), np.int8), (one, other)), shape=(count, count))
    labels = connected_components(graph, directed=False)[1]
    return len(np.unique(labels[mesh.faces[:, 0]]))
