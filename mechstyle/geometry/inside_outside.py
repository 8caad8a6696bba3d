"""Inside and outside of a hollow part: where a ball is shut in, and where one side ends and the other begins.

Also how much of the sky above it each place of a standing part sees.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.ndimage import label
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

from mechstyle._warp import wp
from mechstyle.geometry.kernels import count_escapes, count_narrow, gather_light
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.records.mesh import Bools, Floats, SurfaceMesh, on_floor

RAYS = 128
HIDDEN, OPEN = 0.51, 0.97
"""Sky seen below which a place that no ball reaches is inside, and above which it is outside: the floor of a flat tray sees nine tenths."""
BALL = 0.04
"""Radius of the ball over the size of the part: what it does not fit through is closed."""
IN_A_PLANE = [(a, b) for a, b in itertools.product(range(-2, 3), repeat=2) if math.gcd(a, b) == 1]
"""Ways on a grid in a plane along two axes, sixteen."""
NEAR = 1.8
"""How far off the middle of a ball on the grid may lie from where it would touch, over the grid's step."""
LONG = 0.25
"""Length of a tube over the size of the part: what is shorter, as the frame of two posts, a floor and a roof, shuts in nothing."""
LIFT, ALL_IN_HOLE = 0.02, 0.98
"""How far off the surface a hole is measured, over its width, and the share of the directions in a plane in which it is narrow."""
CONVEXITY = 8.0
"""How much more loosely two vertices hang together for each radian by which the surface bends away between them."""
HALF = 0.5
"""Probability that a walk ends inside, from which on a place is inside."""
LEAST_SHARE = 0.005
"""Smaller pieces, of the area, belong to what surrounds them."""


SKIN = 1e-4
"""How far off the surface rays begin, over its size."""
KEPT = 4
"""Surfaces whose answer is kept: a run asks for each picture, and first while it prepares the part, which it then reads from disk."""
_known: dict[str, NDArray[np.float64]] = {}


def is_inside(mesh: SurfaceMesh) -> NDArray[np.bool_]:
    """Whether each vertex of a closed surface lies in a hollow that opens to the outside, shape [vertex_count]."""
    return np.asarray(insideness(mesh) > HALF)


def insideness(mesh: SurfaceMesh) -> NDArray[np.float64]:
    """How surely each vertex of a closed surface is inside, in [0, 1], shape [vertex_count]: the border is where it is HALF.

    Inside is where a ball of a twelfth of the part's size is shut in: along none of the ways in a plane along two axes it rolls straight
    out; and what it does not reach from outside and sees less than half of the sky. So a hull is inside and the house that stands out of
    it is not, and neither is what lies under a roof. Outside is where it rolls out, and what sees nearly all of the sky. In between, by
    the random walker (Grady 2006), each vertex goes where a walk along the surface ends more probably; walks rarely cross convex edges,
    so that the border runs along the rim. A surface of the same vertices and faces as a few before is not asked again.
    """
    if mesh.digest in _known:
        return _known[mesh.digest]
    sky = openness(mesh)
    reached, shut, free = _by_ball(mesh)
    inside = (shut & (sky <= OPEN)) | (~reached & (sky < HIDDEN))
    outside = free | (sky > OPEN)
    share = inside.astype(np.float64)
    if inside.any() and outside.any():
        share = _walked(mesh, inside, outside)
        # Pieces of less than LEAST_SHARE of the area go to the other side.
        count, same = len(mesh.vertices), np.equal(*(share[mesh.edges.T] > HALF))
        graph = sp.coo_array((np.ones(int(same.sum())), mesh.edges[same].T), shape=(count, count))
        piece = connected_components(graph, directed=False)[1]
        areas = np.bincount(piece, mesh.vertex_areas)
        small = (areas < LEAST_SHARE * areas.sum())[piece]
        share[small] = 1.0 - share[small]
    share.setflags(write=False)
    while len(_known) >= KEPT:
        _known.pop(next(iter(_known)), None)
    _known[mesh.digest] = share
    return share


def openness(mesh: SurfaceMesh) -> Floats:
    """Share of the sky each vertex sees past the part itself, as a diffuse light would shine on it, in [0, 1], shape [vertex_count]."""
    tree = TriangleTree(mesh.vertices, mesh.faces)
    return escaping(tree, mesh.vertices, mesh.vertex_normals, SKIN * mesh.size, 2.0 * mesh.size)


def in_hole(mesh: SurfaceMesh, widest: float) -> Callable[[Floats, Floats], Bools]:
    """Tells of points on a closed surface with their normals, shape [n, 3], whether they lie in a bore or slot nowhere wider than asked.

    In a plane along two axes a point is surrounded there, and what surrounds it is that near [mm].
    """
    tree = TriangleTree(mesh.vertices, mesh.faces)
    angle = np.pi * (np.arange(RAYS // 2) + 0.5) / (RAYS // 2)
    half = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(RAYS // 2)])

    def tells(points: Floats, normals: Floats) -> Bools:
        lifted, shares = tree.points(points + LIFT * widest * normals), []
        for turn in range(3):
            ways: Any = wp.array(np.roll(half, turn, axis=1).astype(np.float32), dtype=wp.vec3, device=tree.device)
            narrow: Any = wp.empty(len(points), dtype=wp.int32, device=tree.device)
            wp.launch(count_narrow, dim=len(points), inputs=[tree.id, lifted, ways, widest, narrow], device=tree.device)
            shares.append(narrow.numpy() / len(half))
        return np.asarray(np.max(shares, axis=0) >= ALL_IN_HOLE)

    return tells


def _by_ball(mesh: SurfaceMesh) -> tuple[Bools, Bools, Bools]:
    """Whether a ball from outside touches each vertex, whether it is surely shut in there, and surely not, shape [vertex_count]."""
    radius = BALL * mesh.size
    step = 0.5 * radius
    low, high = mesh.vertices.min(axis=0) - 2.0 * radius, mesh.vertices.max(axis=0) + 2.0 * radius
    middles = np.stack(np.meshgrid(*(np.arange(a, b + step, step) for a, b in zip(low, high, strict=True)), indexing="ij"), axis=-1)
    room = TriangleTree(mesh.vertices, mesh.faces).nearest(middles).distance.reshape(middles.shape[:3]) >= radius
    piece = label(room)[0]
    from_outside = piece == piece[0, 0, 0]
    shut = np.zeros_like(room)
    for axis in range(3):
        ways = [tuple(np.insert(way, axis, 0).tolist()) for way in IN_A_PLANE]
        in_plane = ~np.logical_or.reduce([_rolls_out(room, way) for way in ways])
        # But for runs along the axis that are open at both ends and shorter than LONG: frames.
        line = np.zeros((3, 3, 3), bool)
        line[tuple(slice(None) if other == axis else 1 for other in range(3))] = True
        run, count = label(in_plane & room, structure=line)
        beyond = room & ~in_plane
        ends = [np.bincount(run[np.roll(beyond, way, axis=axis) & (run > 0)], minlength=count + 1) > 0 for way in (-1, 1)]
        frame = ends[0] & ends[1] & (np.bincount(run.ravel(), minlength=count + 1) < LONG * mesh.size / step)
        shut |= in_plane & room & ~frame[run]
    apart, near = cKDTree(middles[from_outside]).query(mesh.vertices + radius * mesh.vertex_normals, k=4)
    here, touching = shut[from_outside][near], apart <= NEAR * step
    reached = touching[:, 0]
    return reached, reached & (here | ~touching).all(axis=1), reached & ~(here & touching).any(axis=1)


def _rolls_out(room: Bools, way: tuple[int, ...]) -> Bools:
    """Whether there is room from each place of a grid on, step by step, until its end; twice as far each time."""
    free, steps = room, 1
    while steps < max(room.shape):
        ahead = np.ones_like(free)
        far = [(size, steps * along) for size, along in zip(room.shape, way, strict=True)]
        here = tuple(slice(max(0, -step), max(0, size - max(0, step))) for size, step in far)  # what has a place so far ahead …
        there = tuple(slice(max(0, step), max(0, size + min(0, step))) for size, step in far)  # … and that place
        ahead[here] = free[there]
        free, steps = free & ahead, 2 * steps
    return free


def escaping(tree: TriangleTree, points: Floats, normals: Floats, skin: float, reach: float) -> Floats:
    """Share of a diffuse light at points of a surface that gets past it, in [0, 1], shape [n].

    The points [mm] and the normals to their lit sides have shape [n, 3]; rays begin `skin` off them and are `reach` long [mm].
    """
    lit, rays = (wp.array(ways.astype(np.float32), dtype=wp.vec3, device=tree.device) for ways in (normals, _directions(RAYS, cosine=True)))
    escaped: Any = wp.empty(len(points), dtype=wp.int32, device=tree.device)
    wp.launch(count_escapes, dim=len(points), inputs=[tree.id, tree.points(points), lit, rays, skin, reach, escaped], device=tree.device)
    return np.asarray(escaped.numpy() / RAYS, dtype=np.float64)


def _directions(count: int, *, cosine: bool) -> Floats:
    """Unit vectors with z > 0 on a Fibonacci spiral, each for the same solid angle, or as dense as their z; shape [count, 3]."""
    k = np.arange(count) + 0.5
    angle = np.pi * (3.0 - np.sqrt(5.0)) * k
    height = np.sqrt(1.0 - np.sqrt(k / count) ** 2) if cosine else k / count
    radius = np.sqrt(k / count) if cosine else np.sqrt(1.0 - height**2)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


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


def sky_seen(surface: SurfaceMesh, *, directions: int = 64) -> NDArray[np.float32]:
    """Share of the sky that each vertex of a standing part sees from above the floor, in [0, 1], shape [vertex_count].

    It is the light of an even sky, divided into directions, that falls on a vertex, over that on a horizontal face in the open. A free
    vertical wall has one half. The floor gives no light. Vertices that rest on it see nothing, and at the rim of a resting face its share
    of the area counts as 0.
    """
    sky, count = _directions(directions, cosine=False), len(surface.vertices)
    tree = TriangleTree(surface.vertices, surface.faces)
    normals, rays = (wp.array(ways.astype(np.float32), dtype=wp.vec3, device=tree.device) for ways in (surface.vertex_normals, sky))
    light: Any = wp.empty(count, dtype=wp.float32, device=tree.device)
    inputs = [tree.id, tree.points(surface.vertices), normals, rays, SKIN * surface.size, 2.0 * surface.size, light]
    wp.launch(gather_light, dim=count, inputs=inputs, device=tree.device)
    areas = np.where(on_floor(surface), surface.face_areas, 0.0)
    rests = np.bincount(surface.faces.ravel(), np.repeat(areas / 3.0, 3), count)
    on_the_floor = np.minimum(np.divide(rests, surface.vertex_areas, out=np.zeros(count), where=rests > 0.0), 1.0)
    return np.asarray(np.clip(light.numpy() / sky[:, 2].sum(), 0.0, 1.0) * (1.0 - on_the_floor), dtype=np.float32)
