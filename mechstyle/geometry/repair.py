"""From triangles as files have them to closed, outward, manifold solids; every repair is said in words."""

from __future__ import annotations

from typing import Any

import manifold3d
import numpy as np
import scipy.sparse as sp
import trimesh
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.geometry.bodies import without_unused
from mechstyle.geometry.inside_outside import SKIN, escaping
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.crossings import overlaps
from mechstyle.geometry.remeshing.evening import manifold_of, surface_of
from mechstyle.geometry.remeshing.tetwild import Settings, tetwild
from mechstyle.records.mesh import Floats, Indices, SurfaceMesh, TetMesh

HAIRLINE = 1e-4
"""Gaps up to this share of the part's diagonal, finer than printers resolve, are closed by moving their sides together."""
LARGEST_HOLE = 0.02
"""An opening larger than this share of the surface is no hole but a missing side, and filling it would invent a body."""
CROOKED = 1.5
"""A fan with more than this many times the area of its opening is folded: the opening is a crack and not a hole."""
FLATTEST = 0.01
"""Thickness below which something is a sheet and no body [mm]."""
INSIDE = 0.99
"""A shell that faces inwards is a cavity if this share of it lies within a body; else it is a body inside out."""
NEARLY, SEEN = 0.96, 0.02
"""Where a face is looked at, from its middle to its corners, and the share of rays that get out from what is seen from outside."""
PROBED = 50
"""About so many faces of a piece of surface are looked at before all of them are."""
MOST_TIME = 300.0
"""Processor time for fTetWild [s]: what keeps it longer is beyond repair."""


def solids_of(vertices: Floats, faces: NDArray[np.int64], name: str, notes: list[str]) -> list[Any]:
    """Closed solids of a triangle soup [mm], as Manifolds; a sentence on each repair is added to the notes.

    A solid whose surface cuts through itself is closed and therefore left as it is. BadInput, about the file of this name, if the soup
    encloses nothing or cannot be closed.
    """
    # Equal positions become one vertex; faces with repeated indices go, faces without area stay: they close gaps between their neighbours.
    # Faces back to back stay for now: bodies that share a side have them, and Manifold takes them out in pairs.
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    mesh.remove_unreferenced_vertices()
    mesh.merge_vertices()  # which every STL needs: nothing to tell
    welded = SurfaceMesh(mesh.vertices, mesh.faces)
    lowest_first = (welded.faces.argmin(axis=1)[:, None] + np.arange(3)) % 3
    surface = _without_repeats(welded, np.take_along_axis(welded.faces, lowest_first, axis=1))
    if dropped := len(welded.faces) - len(surface.faces):
        notes.append(f"dropped {counted(dropped, 'degenerate or repeated face', 'degenerate or repeated faces')}")
    if not len(surface.faces):
        raise BadInput(f"{name} holds no triangle with an area: export it again from the program it was made with")
    spread = np.linalg.svd(surface.vertices - surface.vertices.mean(axis=0), compute_uv=False) / np.sqrt(len(surface.vertices))
    if spread[-1] < FLATTEST:  # all its vertices lie in a plane, or nearly
        raise BadInput(f"{name} is flat and encloses no volume: give it a thickness, and export it again")
    return _solids(_closed(surface, name, notes), name, notes)


def overlaps_of(surface: SurfaceMesh) -> tuple[str, ...]:
    """A sentence on where the surface passes through itself, none if it does not."""
    places = overlaps(surface)
    if not len(places):
        return ()
    named = ", ".join(f"({x:.1f}, {y:.1f}, {z:.1f})" for x, y, z in places[:3]) + (", ..." if len(places) > 3 else "")
    where = f"in {counted(len(places), 'place', 'places')}, around {named} mm"
    return (f"its surface passes through itself {where}: what is inside twice counts once; unite it in the program it was made with",)


def counted(number: int, thing: str, things: str) -> str:
    """A number of things in words."""
    return f"{number} {thing if number == 1 else things}"


def _area(area: float) -> str:
    return f"{area:.0f} mm²" if area >= 10.0 else f"{area:.2g} mm²"


# --- a closed surface ---------------------------------------------------------------------------------------------


def _without_repeats(surface: SurfaceMesh, key: NDArray[Any]) -> SurfaceMesh:
    """The first face of every `key`, shape [face_count, 3], that has three different vertices."""
    once = np.sort(np.unique(key, axis=0, return_index=True)[1])
    faces = surface.faces[once]
    a, b, c = faces.T
    return without_unused(surface.vertices, faces[(a != b) & (b != c) & (c != a)])


def _closed(surface: SurfaceMesh, name: str, notes: list[str]) -> Any:
    """The surface as a valid Manifold of positive volume, mended no more than it takes."""
    body = _accepted(surface)
    for mend in (_joined, _wound, _emptied, _wound, _plugged):
        if body is None:
            surface = mend(surface, name, notes)
            body = _accepted(surface)
    if body is None:  # the last resort for surfaces that do not quite meet, or meet three at an edge: what fTetWild takes for the inside
        refused, advice = f"{name} is not a closed surface and could not be repaired", "repair it in the program it was made with"
        try:
            vertices, tets = tetwild(surface.vertices, surface.faces, Settings(0.03 * surface.size, 5e-4), timeout=MOST_TIME)
        except SimulationFailed as error:
            raise BadInput(f"{refused} ({error}); {advice}") from error
        upright = np.where((TetMesh(vertices, tets).volumes < 0)[:, None], tets[:, [0, 2, 1, 3]], tets)
        body = _accepted(without_unused(vertices, TetMesh(vertices, upright).boundary_faces))
        if body is None:
            raise BadInput(f"{refused}; {advice}")
        notes.append("rebuilt its surface from the volume inside it, because its faces do not meet two at an edge")
    if body.volume() < 0:
        notes.append("turned its faces outwards")
        body = inside_out(body)
    return body


def _accepted(surface: SurfaceMesh) -> Any | None:
    """A Manifold of the surface, or None if it is not one.

    Manifold is not asked about a surface that is open: with an odd number of sides it reads memory that is not its own, and may crash.
    """
    start, end = surface.faces[:, [0, 1, 2]].ravel().astype(np.int64), surface.faces[:, [1, 2, 0]].ravel().astype(np.int64)
    count = len(surface.vertices)
    if not np.array_equal(np.sort(start * count + end), np.sort(end * count + start)):
        return None
    body = manifold_of(surface)
    return body if body.status() == manifold3d.Error.NoError and not body.is_empty() else None


def inside_out(body: Any) -> Any:
    """The same surface, facing the other way."""
    surface = surface_of(body)
    return manifold_of(SurfaceMesh(surface.vertices, surface.faces[:, ::-1]))


def _joined(surface: SurfaceMesh, _name: str, notes: list[str]) -> SurfaceMesh:
    """Vertices on open edges joined to others closer than a hairline."""
    open_ones = np.unique(_rim(surface))
    pairs = cKDTree(surface.vertices[open_ones]).query_pairs(HAIRLINE * surface.size, output_type="ndarray")
    if not len(pairs):
        return surface
    notes.append("closed hairline gaps between its faces")
    cluster = _linked(pairs, len(open_ones))
    index = np.arange(len(surface.vertices), dtype=np.int32)
    index[open_ones] = open_ones[np.unique(cluster, return_index=True)[1][cluster]]
    faces = index[surface.faces]
    return _without_repeats(SurfaceMesh(surface.vertices, faces), faces)


def _linked(pairs: NDArray[Any], count: int) -> NDArray[np.int32]:
    """The connected component of each of `count` things, shape [count], by the pairs that hang together, shape [k, 2]."""
    return connected_components(sp.coo_array((np.ones(len(pairs)), pairs.T), shape=(count, count)), directed=False)[1]


def _rim(surface: SurfaceMesh) -> Indices:
    """The edges with one face, directed as in that face, shape [k, 2]."""
    edge, count = _edges_of(surface)
    return surface.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)[count[edge] == 1]


def _wound(surface: SurfaceMesh, _name: str, notes: list[str]) -> SurfaceMesh:
    """Copies of faces dropped, whichever way they face, and every shell wound one way: that of most of its area."""
    single = _without_repeats(surface, np.sort(surface.faces, axis=1))
    if len(single.faces) < len(surface.faces):
        notes.append(f"dropped {counted(len(surface.faces) - len(single.faces), 'face', 'faces')} with another back to back")
    mesh = trimesh.Trimesh(single.vertices, single.faces, process=False)
    with np.errstate(divide="ignore", invalid="ignore"):  # of flat parts, whose volume it divides by
        trimesh.repair.fix_winding(mesh)  # type: ignore[no-untyped-call]  # trimesh annotates in part
    turned = (mesh.faces != single.faces).any(axis=1)
    shell = _linked(mesh.face_adjacency, len(mesh.faces))
    most_turned = np.bincount(shell, single.face_areas * np.where(turned, 1.0, -1.0)) > 0
    turned ^= most_turned[shell]
    if turned.any():
        notes.append("made the winding of its faces consistent")
    return SurfaceMesh(single.vertices, np.where(turned[:, None], single.faces[:, ::-1], single.faces))


def _emptied(surface: SurfaceMesh, _name: str, notes: list[str]) -> SurfaceMesh:
    """Sheets without thickness dropped that lie within what is closed without them: loose ones, and walls that were left inside.

    They end where an edge has not two faces, and from neither side of them a ray gets out. One after the other is tried, the smallest
    first, so that of the wall across a cavity not the cavity is taken; then all at once, as of walls that cross.
    """
    # A piece of surface is what edges of two faces connect.
    edge, count = _edges_of(surface)
    order = np.argsort(edge, kind="stable")
    pairs = order[np.flatnonzero(count[edge[order]] == 2)].reshape(-1, 2) // 3
    patch = _linked(pairs, len(surface.faces)).astype(np.int32)
    inner, sizes = _inner(surface, patch, edge, count), np.bincount(patch, surface.face_areas).astype(np.float64)
    sides, last = edge.reshape(-1, 3), int(patch.max())
    faces_of = np.split(np.argsort(patch, kind="stable"), np.cumsum(np.bincount(patch))[:-1])
    dropped: set[int] = set()

    def closes(faces: NDArray[np.int64], pieces: int) -> bool:
        """Whether without these faces each of their edges has two others or none, and something is left; then they are gone."""
        own, uses = np.unique(sides[faces], return_counts=True)
        if len(dropped) + pieces > last or not np.isin(count[own] - uses, (0, 2)).all():
            return False
        count[own] -= uses
        return True

    hidden = [int(number) for number in np.argsort(sizes) if number in inner]
    dropped |= {number for number in hidden if closes(faces_of[number], 1)}
    if not dropped and hidden and closes(np.flatnonzero(np.isin(patch, hidden)), len(hidden)):
        dropped = set(hidden)
    if not dropped:
        return surface
    notes.append(f"dropped {counted(len(dropped), 'sheet', 'sheets')} without thickness inside it")
    return without_unused(surface.vertices, surface.faces[~np.isin(patch, list(dropped))])


def _edges_of(surface: SurfaceMesh) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The number of the edge of each of three sides of each face, shape [3 * face_count], and how many faces each edge has."""
    sides = np.sort(surface.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, edge, count = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    return edge.reshape(-1), count


def _inner(surface: SurfaceMesh, patch: NDArray[np.int32], edge: NDArray[np.int64], count: NDArray[np.int64]) -> set[int]:
    """The pieces that end at edges of not two faces, and of which nothing is seen from outside; edges as of `_edges_of`.

    Some faces of each are looked at first: of a large piece with a hole in it they already tell.
    """
    ending = np.unique(patch[np.flatnonzero(count[edge] != 2) // 3])
    faces = np.flatnonzero(np.isin(patch, ending) & (surface.face_areas > 0.0))
    tree = TriangleTree(surface.vertices, surface.faces)
    skin, far = SKIN * surface.size, 2.0 * surface.size
    most, stride = np.zeros(int(patch.max()) + 1), -(-np.bincount(patch[faces], minlength=int(patch.max()) + 1) // PROBED)
    probed = faces % np.maximum(stride[patch[faces]], 1) == 0
    for batch in (faces[probed], faces[~probed]):
        left = batch[most[patch[batch]] < SEEN]
        if not len(left):
            continue
        corners, middles = surface.corners[left], surface.corners[left].mean(axis=1, keepdims=True)
        points = np.concatenate([middles, middles + NEARLY * (corners - middles)], axis=1).reshape(-1, 3)
        normals = np.repeat(surface.face_normals[left], 4, axis=0)
        seen = np.maximum(*(escaping(tree, points, way * normals, skin, far) for way in (1.0, -1.0)))
        np.maximum.at(most, np.repeat(patch[left], 4), seen)
    return {int(number) for number in ending if most[number] < SEEN}


def _plugged(surface: SurfaceMesh, name: str, notes: list[str]) -> SurfaceMesh:
    """Every small hole closed by a fan of triangles around its middle; cracks stay open."""
    rim = _rim(surface)
    if not len(rim):
        return surface
    number = np.unique(_linked(rim, len(surface.vertices))[rim[:, 0]], return_inverse=True)[1].reshape(-1)  # of the opening of each edge

    def sums(rows: Floats) -> Floats:
        return np.stack([np.bincount(number, column) for column in rows.T], axis=1)

    start, end = surface.vertices[rim[:, 0]], surface.vertices[rim[:, 1]]
    middles = sums(start) / np.bincount(number)[:, None]
    spokes = 0.5 * np.cross(start - middles[number], end - middles[number])
    areas, total = np.linalg.norm(sums(spokes), axis=1), surface.face_areas.sum()  # vector areas: those of openings that are plane
    if areas.max() > LARGEST_HOLE * total:
        raise BadInput(
            f"{name} is open and cannot be closed: an opening of {_area(areas.max())} is no small hole in a surface of {_area(total)}; "
            "give it a thickness or cap the opening, and export it again"
        )
    fan_areas = np.bincount(number, np.linalg.norm(spokes, axis=1))
    round_ones = np.flatnonzero((areas > 0) & (fan_areas <= CROOKED * areas))
    if not len(round_ones):
        return surface
    fans = np.isin(number, round_ones)
    notes.append(f"closed {counted(len(round_ones), 'hole', 'holes')} of {_area(areas[round_ones].sum())} in all")
    plugs = np.stack([rim[fans][:, 1], rim[fans][:, 0], len(surface.vertices) + number[fans]], axis=1)
    return without_unused(np.vstack([surface.vertices, middles]), np.vstack([surface.faces, plugs]))


# --- solids -------------------------------------------------------------------------------------------------------


def _solids(body: Any, name: str, notes: list[str]) -> list[Any]:
    """The solids of a closed surface: flat shells dropped, those that are inside out turned, cavities taken out of what they lie in."""
    # twice the volume over the surface is the thickness of a sheet
    found = body.decompose()
    shells = [shell for shell in found if 2 * abs(shell.volume()) > FLATTEST * shell.surface_area()]
    if not shells:
        raise BadInput(f"{name} encloses no volume: give it a thickness, and export it again")
    solids = [shell for shell in shells if shell.volume() > 0]
    inward = [inside_out(shell) for shell in shells if shell.volume() < 0]
    hosts = [host_of(shell, solids) for shell in inward]
    turned = [shell for shell, host in zip(inward, hosts, strict=True) if host is None]
    if flat := len(found) - len(shells):
        notes.append(f"left out {counted(flat, 'sheet', 'sheets')} that enclosed nothing")
    if turned:
        notes.append(f"turned {counted(len(turned), 'body', 'bodies')} outwards")
    if len(solids) == 1 and not (turned or flat):
        return [body]
    for shell, host in zip(inward, hosts, strict=True):
        if host is not None:
            solids[host] -= shell
    return solids + turned


def host_of(shell: Any, solids: list[Any]) -> int | None:
    """The first of the solids that a shell lies within; a second one around it fills it again. None if there is none."""
    return next((index for index, solid in enumerate(solids) if (solid ^ shell).volume() >= INSIDE * shell.volume()), None)
