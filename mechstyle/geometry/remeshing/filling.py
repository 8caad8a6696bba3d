"""Tetrahedra inside a closed surface: fTetWild, watched and checked."""

from __future__ import annotations

import contextlib
import io
import math
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components, reverse_cuthill_mckee

from mechstyle._files import write_whole
from mechstyle.errors import BadInput, MechStyleError, SimulationFailed
from mechstyle.geometry.cancelling import CancelCheck, never_cancel
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.remeshing.cleaning import without_degenerate
from mechstyle.geometry.remeshing.decimation import decimated
from mechstyle.geometry.remeshing.evening import crowded, even_edge, manifold_of, remeshed, surface_of
from mechstyle.geometry.remeshing.improvement import improved
from mechstyle.geometry.remeshing.tetwild import Settings, tetwild
from mechstyle.geometry.remeshing.tolerances import TOL
from mechstyle.records.mesh import Floats, Indices, SurfaceMesh, TetMesh, digest_of
from mechstyle.records.simulation import VOLUME_ERROR

VERSION = "19"  # of what is cached: raise it when the result for the same input may change
FEWEST, MOST = 500, 400_000
KEPT: tuple[int, ...] = (24_000, 12_000, 6_000, 3_000)
"""Faces of an input that keeps its triangles: the fewest of these that follow the surface as closely as is asked."""


def fill(
    surface: SurfaceMesh, target: int = 16_000, *,
    keep: SurfaceMesh | None = None, proud: Floats | None = None, timeout: float = 600.0, cache: Path | None = None,
    go_on: CancelCheck = never_cancel,
) -> TetMesh:  # fmt: skip
    """Tetrahedra of about the wished number inside a closed surface.

    Args:
        surface: A closed surface.
        target: Tetrahedra wanted, 500 to 400 000; -40 % to +60 % is accepted, and fine detail may ask for more.
        keep: The surface with its whole relief, or an exaggerated one, vertex by vertex. Its triangles are kept, those that this one needs
            most if there are more than the least of KEPT; without it they become as large as the target asks for and the detail allows,
            unless the surface itself has a relief finer than that.
        proud: How far kept triangles may stand out of the surface at each vertex [mm], shape [vertex_count]: as many of KEPT are kept as
            that takes. None for any distance.
        timeout: Most time for one run of fTetWild [s], as `tetwild` counts it; there are one or two, three at most.
        cache: Folder of earlier results by content, or None. fTetWild gives another mesh every time, so that only a kept one
            makes a run repeatable.
        go_on: Called while fTetWild works; what it raises ends it.

    Returns:
        One body connected through faces, its boundary free of gaps, numbered for memory locality; vertices of a flat base lie in its plane.

    Raises:
        BadInput: If the surface is not closed, not finite or empty, or the target is out of range.
        SimulationFailed: If no mesh that passes the checks was found, saying what the last one failed.
    """
    _check(surface, target)
    kept = None if keep is None else Kept(keep, np.full(len(keep.vertices), np.inf) if proud is None else proud)
    digest = digest_of(
        surface.vertices, surface.faces, np.array([target]), *([] if kept is None else [kept.exaggerated.vertices, kept.proud])
    )
    file = None if cache is None else Path(cache) / f"{digest[:32]}-{VERSION}.npz"
    if file is not None and (known := _cached(file)) is not None:
        return known
    tets = _meshed(surface, target, timeout, go_on, keep=kept)
    if file is not None:
        if (meanwhile := _cached(file)) is not None:  # somebody else was faster, and runs may rest on that mesh already
            return meanwhile
        content = io.BytesIO()
        np.savez_compressed(content, vertices=tets.vertices, tets=tets.tets, digest=np.array(tets.digest))
        with contextlib.suppress(MechStyleError):  # a full disk costs time later, not this result
            write_whole(file, content.getvalue())
    return tets


def _check(surface: SurfaceMesh, target: int) -> None:
    """Refuse what fTetWild would crash on or mesh without a word."""
    if not FEWEST <= target <= MOST:
        raise BadInput(f"cannot fill a part with {target} tetrahedra: ask for {FEWEST} to {MOST}")
    if not (len(surface.faces) and np.isfinite(surface.vertices).all()):
        raise BadInput("the surface is empty or has vertices that are not finite numbers, so it cannot be filled with tetrahedra")
    if not surface.is_closed:
        raise BadInput("the surface is not closed, so it has no inside to fill; load it with mechstyle, which repairs it or says why not")
    if surface.volume <= 0:
        why = "encloses no volume or its faces point inwards"
        raise BadInput(f"the surface {why}; load it with mechstyle, which repairs it or says why not")


class Kept(NamedTuple):
    """What triangles are kept for: `keep` and `proud` of `fill`."""

    exaggerated: SurfaceMesh
    proud: Floats


class Attempt(NamedTuple):
    """One fTetWild run: its mesh, its fault ("" for none), and whether surface detail needs more tetrahedra than wished."""

    tets: TetMesh
    fault: str
    detailed: bool


def _meshed(surface: SurfaceMesh, target: int, timeout: float, go_on: CancelCheck, *, keep: Kept | None) -> TetMesh:
    """Run fTetWild until count and checks are met, aiming lower or higher or sharpening the tolerances, at most `TOL.runs` times.

    A mesh of the wrong size is better than none: after one correction the nearest count is taken, and at once if the surface's detail, or
    that its triangles are kept, is why there are too many.
    """
    aim, sharpness, sound, fault = float(target), 1.0, list[TetMesh](), ""
    for _ in range(TOL.runs):
        tets, fault, detailed = _attempt(surface, aim, sharpness, timeout, go_on, keep=keep)
        if fault:
            sharpness /= 2.0
            continue
        sound.append(tets)
        ratio = len(tets.tets) / target
        if TOL.least_count <= ratio <= TOL.most_count or len(sound) == 2 or (ratio > 1.0 and detailed):
            break
        aim /= ratio
    if not sound:
        wall = 2.0 * surface.volume / float(surface.face_areas.sum())
        why = f"{fault}; its walls are {wall:.1f} mm thick on average, and a thinner one or two that touch are the usual cause"
        raise SimulationFailed(f"the part could not be filled with tetrahedra: {why}; make them thicker there, or scale the part up")
    return min(sound, key=lambda tets: abs(math.log(len(tets.tets) / target)))


def _attempt(surface: SurfaceMesh, aim: float, sharpness: float, timeout: float, go_on: CancelCheck, *, keep: Kept | None) -> Attempt:
    wall = 2.0 * surface.volume / float(surface.face_areas.sum())
    tolerance = sharpness * min(TOL.envelope * wall, TOL.widest_envelope * surface.size)
    epsilon = (1.0 if keep is None else 0.5) * tolerance
    loose = sharpness * TOL.loose * wall
    detail = 0.5 * TOL.lost_detail * wall
    finest = even_edge(surface, round(TOL.finest_input / sharpness))  # coarser ones may be what the fault of the run before comes from
    even = _filled_as(surface, aim, finest, loose, detail, go_on) if keep is None else _simplified(surface, keep, loose, detail, go_on)
    own = (TOL.per_face if keep is None else TOL.per_kept_face) * len(even.faces)
    edge = _edge(surface.volume, own, aim)
    found = _tidied(*tetwild(even.vertices, even.faces, Settings(edge, epsilon / surface.size), timeout=timeout, go_on=go_on))
    settled = _set_down(surface, found, max(TOL.set_down, 1.5 * epsilon))
    better = improved(settled, reach=tolerance, floor=float(surface.vertices[:, 2].min()), go_on=go_on)
    tets = _tidied(better.vertices, better.tets)
    return Attempt(tets, _fault(surface, tets, TOL.lost_detail * wall), detailed=keep is not None or own > aim)


def _edge(volume: float, own: float, aim: float) -> float:
    """Edge length l [mm] for about `aim` tetrahedra inside a surface whose triangles make `own`: the root of 9 V / l³ + own = aim.

    Fitted to fTetWild's counts for six parts in even triangles, from a 1 mm frame to a solid hook, within 20 %. Where the triangles alone
    ask for more than three quarters of the aim, the inside gets the other quarter and the count comes out higher: by up to 1.65 times
    where they are kept.
    """
    return float(np.cbrt(9.0 * volume / max(aim - own, 0.25 * aim)))


def _first_edge(surface: SurfaceMesh, aim: float) -> float:
    """The edge length [mm] of `_edge` when the surface, too, is cut into triangles of that edge: F = 4 A / (√3 l²)."""
    roots = np.roots([aim, 0.0, -4.0 * TOL.per_face / math.sqrt(3.0) * float(surface.face_areas.sum()), -9.0 * surface.volume])
    return float(roots[np.isreal(roots)].real.max())


def _filled_as(surface: SurfaceMesh, aim: float, finest: float, deviation: float, detail: float, go_on: CancelCheck) -> SurfaceMesh:
    """The surface in even triangles, as large as aim or `deviation` [mm] from it allow; in its own where those are as large and serve.

    Even ones have edges of at least `finest` [mm].

    fTetWild spends its time on slivers: even triangles are meshed several times faster. Its own triangles also stay where even ones are
    fewer than the creases ask for: half a millimetre of relief is within the tolerance of a thick part, and would be evened away.
    """
    edge = asked = _first_edge(surface, aim)
    body, tree, own = manifold_of(surface), TriangleTree(surface.vertices, surface.faces), surface.edge_length
    while True:
        even = remeshed(body, max(edge, finest), tolerance=0.25 * deviation, iterations=5, go_on=go_on)
        there = tree.nearest(even.vertices).distance
        back = TriangleTree(even.vertices, even.faces).nearest(surface.vertices).distance
        if edge <= finest or max(np.quantile(there, 0.999), np.quantile(back, 0.999)) <= deviation:
            even = even if even.is_closed else surface
            if not crowded(body, asked, len(even.vertices), go_on):
                return even
            break
        edge *= 0.8
        if edge < own <= asked:
            break
    return _simplified(surface, Kept(surface, np.full(len(surface.vertices), 0.5 * detail)), deviation, detail, go_on)


def _simplified(surface: SurfaceMesh, keep: Kept, deviation: float, detail: float, go_on: CancelCheck) -> SurfaceMesh:
    """The surface in its own triangles; of more than the least of KEPT, those that its exaggerated relief needs least are given up.

    Low ones go in any case, as far as that moves the surface by no more than `deviation` [mm]. Even triangles of the same number round
    the edges of a relief off.
    """
    found = surface if len(surface.faces) <= min(KEPT) else _fewest(surface, keep, detail, go_on)
    edge = math.sqrt(4.0 / math.sqrt(3.0) * float(found.face_areas.mean()))
    return without_degenerate(found, min(TOL.low_input * edge, deviation))


def _fewest(surface: SurfaceMesh, keep: Kept, detail: float, go_on: CancelCheck) -> SurfaceMesh:
    """The surface in the fewest of KEPT triangles that stand out of it no further than they may, or in the most of them.

    The more a relief is exaggerated, the less is left for the shape of the part: less exaggerated where a detail larger than `detail` [mm]
    would be lost; if none stay closed, all are kept.
    """
    losses: list[tuple[float, SurfaceMesh]] = []
    step = TOL.needless * min(detail, float(np.median(keep.proud)))
    for share in TOL.exaggeration:
        high = surface.moved(surface.vertices + share * (keep.exaggerated.vertices - surface.vertices))
        tree, found = TriangleTree(high.vertices, high.faces), None
        fewer = surface_of(manifold_of(high).simplify(step))  # quadrics take ten times as long for what nothing needs
        for count in KEPT:
            fewer = decimated(fewer, count, go_on) if len(fewer.faces) > count else fewer
            there = tree.nearest(fewer.vertices)
            stretch = (high.vertices - surface.vertices)[surface.faces[there.face]]
            low = fewer.moved(fewer.vertices - np.einsum("vi,vij->vj", there.weights, stretch))
            back = TriangleTree(low.vertices, low.faces).nearest(surface.vertices)
            lost, out = float(back.distance.max()), np.einsum("vi,vi->v", back.point - surface.vertices, surface.vertex_normals)
            standing = float(surface.vertex_areas[out > keep.proud].sum())
            if not low.is_closed or (found is not None and (lost > detail or standing > TOL.standing_out)):
                break
            found = lost, low
        if found is not None:
            losses.append(found)
            if found[0] <= detail:
                break
    return min(losses, key=lambda one: one[0])[1] if losses else surface


def _tidied(vertices: Floats, tets: Indices) -> TetMesh:
    """Positively oriented, degenerate ones dropped, the largest body kept, numbered for locality.

    Tetrahedra are put in reverse Cuthill-McKee order of their adjacency, vertices in the order in which these name them.
    """
    volumes = TetMesh(vertices, tets).volumes
    upright = np.where((volumes < 0)[:, None], tets[:, [0, 2, 1, 3]], tets)[volumes != 0]
    body = connected_components(_adjacency(upright), directed=False)[1]
    largest = upright[body == np.bincount(body).argmax()]
    ordered = largest[reverse_cuthill_mckee(_adjacency(largest), symmetric_mode=True)]
    named, first = np.unique(ordered, return_index=True)
    appearance = np.argsort(first)
    rank = np.empty(len(vertices), np.int32)
    rank[named[appearance]] = np.arange(len(named), dtype=np.int32)
    return TetMesh(vertices[named[appearance]] + 0.0, rank[ordered])  # adding zero turns -0 to 0, so that equal means same bytes


def _adjacency(tets: Indices) -> sp.csr_array:
    """Adjacency of tetrahedra by shared faces, shape [tet_count, tet_count], symmetric."""
    faces = np.sort(tets[:, [1, 2, 3, 0, 2, 3, 0, 1, 3, 0, 1, 2]].reshape(-1, 3), axis=1)
    order = np.lexsort(faces.T)
    same = np.flatnonzero((faces[order[1:]] == faces[order[:-1]]).all(axis=1))
    one, other = order[same] // 4, order[same + 1] // 4
    count = len(tets)
    entries = (np.ones(2 * len(one), np.int8), (np.concatenate([one, other]), np.concatenate([other, one])))
    return sp.coo_array(entries, shape=(count, count)).tocsr()


def _set_down(surface: SurfaceMesh, tets: TetMesh, reach: float) -> TetMesh:
    """Boundary vertices within `reach` [mm] of a flat base lie in its plane again; fTetWild leaves them anywhere in its envelope."""
    floor = float(surface.vertices[:, 2].min())
    base = surface.faces[np.all(surface.corners[:, :, 2] < floor + 1e-6, axis=1)]
    outer = np.unique(tets.boundary_faces)
    near = outer[tets.vertices[outer, 2] < floor + reach]
    if not len(base) or not len(near):
        return tets
    settled = tets.vertices.copy()
    settled[near[TriangleTree(surface.vertices, base).nearest(tets.vertices[near]).distance < reach], 2] = floor
    flattened = tets.moved(settled)
    while len(spoilt := np.unique(tets.tets[flattened.quality < 0.5 * tets.quality])):
        settled[spoilt] = tets.vertices[spoilt]
        flattened = tets.moved(settled)
    return flattened


def _fault(surface: SurfaceMesh, tets: TetMesh, deviation: float) -> str:
    """The fault of a mesh in words, "" for none."""
    if tets.volumes.min() <= 0:
        return "some tetrahedra are turned inside out"
    if (pinched := _pinched(tets.boundary_faces)) > TOL.pinched:
        return f"the surface of the tetrahedra touches itself at {pinched:.1%} of its edges"
    volume = float(tets.volumes.sum()) / surface.volume
    if abs(volume - 1.0) > VOLUME_ERROR:
        return f"the tetrahedra hold {volume:.1%} of its volume"
    lost = TriangleTree(tets.vertices, tets.boundary_faces).nearest(surface.vertices).distance
    if lost.max() > deviation:
        x, y, z = surface.vertices[int(lost.argmax())]
        return f"the tetrahedra miss {lost.max():.2f} mm of it around ({x:.1f}, {y:.1f}, {z:.1f}) mm"
    return ""


def _pinched(faces: Indices) -> float:
    """Share of the edges of a boundary at which more than two of its faces meet.

    A surface that cuts through itself by less than the envelope leaves a few, and halving the envelope moves them elsewhere. For
    the elements they are nothing special: one body connected through faces is connected around such an edge, too.
    """
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return float(np.mean(np.unique(edges, axis=0, return_counts=True)[1] > 2))


def _cached(file: Path) -> TetMesh | None:
    """A kept mesh, or None if there is none that can be read and is what was written."""
    try:
        with file.open("rb") as stream, np.load(stream, allow_pickle=False) as kept:
            tets = TetMesh(kept["vertices"], kept["tets"])
            return tets if str(kept["digest"]) == tets.digest else None
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
