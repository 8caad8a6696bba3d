"""Tetrahedra inside a closed surface: fTetWild, watched and checked."""

from __future__ import annotations

import math
import os
import tempfile
import warnings
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components, reverse_cuthill_mckee

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.geometry.tetwild import Settings, tetwild
from mechstyle.mesh import SurfaceMesh, TetMesh, digest_of

VERSION = "1"  # of what is cached: raise it when the result for the same input may change
FEWEST, MOST = 500, 400_000
DECIMATIONS = (2_000, 4_000, 6_000, 9_000)  # faces given to fTetWild: its time grows with them, and 16 000 tets have no more outside
EPSILON = 3e-4  # envelope over the diagonal: .04 mm of a 130 mm part, below what a printer resolves
STOP_ENERGY = 20.0
RUNS = 3
VOLUME_ERROR = 0.03
FLAT = 0.05  # mm above the floor within which a vertex on a flat base is set down onto it


def tetrahedralise(surface: SurfaceMesh, target: int = 16_000, *, timeout: float = 300.0, cache: Path | None = None) -> TetMesh:
    """Tetrahedra of about the wished number inside a closed surface.

    Args:
        surface: A closed surface.
        target: Tetrahedra wanted, 500 to 400 000; -40 % to +60 % is accepted, and thin walls may ask for more.
        timeout: Most time for one run of fTetWild [s].
        cache: Folder of earlier results by content, or None. fTetWild gives another mesh every time, so that only a kept one
            makes a run repeatable.

    Returns:
        One connected body with a closed boundary, numbered for memory locality; vertices of a flat base lie in its plane.

    Raises:
        BadInput: If the surface is not closed, not finite or empty, or the target is out of range.
        SimulationFailed: If no mesh that passes the checks was found, saying what the last one failed.
    """
    _check(surface, target)
    file = None if cache is None else Path(cache) / f"{digest_of(surface.vertices, surface.faces, np.array([target]))[:32]}-{VERSION}.npz"
    if file is not None and (kept := _read(file)) is not None:
        return kept
    tets = _meshed(surface, target, timeout)
    if file is not None:
        _write(file, tets)
    return tets


class Attempt(NamedTuple):
    """One run's result and what is wrong with it, "" if nothing is."""

    tets: TetMesh
    fault: str


def _check(surface: SurfaceMesh, target: int) -> None:
    """Refuse what fTetWild would crash on or mesh without a word."""
    if not FEWEST <= target <= MOST:
        raise BadInput(f"cannot fill a part with {target} tetrahedra: ask for {FEWEST} to {MOST}")
    if not (len(surface.faces) and np.isfinite(surface.vertices).all()):
        raise BadInput("the surface is empty or has vertices that are not finite numbers, so it cannot be filled with tetrahedra")
    if not surface.is_closed:
        raise BadInput("the surface is not closed, so it has no inside to fill; load it with mechstyle, which repairs it or says why not")
    if surface.volume <= 0:
        raise BadInput(
            "the surface encloses no volume or its faces point inwards; load it with mechstyle, which repairs it or says why not"
        )


def _meshed(surface: SurfaceMesh, target: int, timeout: float) -> TetMesh:
    """Run fTetWild until count and checks are met, correcting the edge length or tightening the envelope, at most RUNS times."""
    edge, epsilon, best = ideal_edge(surface, target), EPSILON, None
    for _ in range(RUNS):
        attempt = _attempt(surface, Settings(edge, epsilon, STOP_ENERGY), timeout)
        count = len(attempt.tets.tets)
        if not attempt.fault:
            if 0.6 * target <= count <= 1.6 * target:
                return attempt.tets
            if best is None or abs(math.log(count / target)) < abs(math.log(len(best.tets) / target)):
                best = attempt.tets
            edge *= (count / target) ** 0.45  # between a solid, where the count goes with the edge's cube, and a wall: its square
        else:
            epsilon /= 2.0
    if best is None:
        raise SimulationFailed(
            f"the part could not be filled with tetrahedra: {attempt.fault}; thin or self-touching walls are the usual cause"
        )
    return best


def ideal_edge(surface: SurfaceMesh, target: int) -> float:
    """Edge length [mm] at which the inside holds about `target` regular tetrahedra: of a solid, or of one layer in a thin wall."""
    solid = 1.15 * (6.0 * math.sqrt(2.0) * surface.volume / target) ** (1.0 / 3.0)
    wall = math.sqrt(2.0 * math.sqrt(3.0) * float(surface.face_areas.sum()) / target)
    return min(solid, wall)


def _attempt(surface: SurfaceMesh, settings: Settings, timeout: float) -> Attempt:
    coarse = _decimated(surface, 0.7 * settings.epsilon * surface.size)
    vertices, tets = tetwild(coarse.vertices, coarse.faces, settings, timeout=timeout)
    found = _tidied(surface, vertices, tets)
    return Attempt(found, _fault(surface, found))


def _decimated(surface: SurfaceMesh, deviation: float) -> SurfaceMesh:
    """Quadric decimation (Garland and Heckbert 1997) to the fewest faces that stay within `deviation` [mm], at most INPUT_FACES."""
    if len(surface.faces) <= DECIMATIONS[0]:
        return surface
    tree = TriangleTree(surface.vertices, surface.faces)
    for count in DECIMATIONS:
        if count >= len(surface.faces):
            return surface
        coarse = _decimated_to(surface, count)
        if coarse.is_closed and _distance(coarse, surface, tree) <= deviation:
            return coarse
    return coarse if coarse.is_closed else surface


def _decimated_to(surface: SurfaceMesh, count: int) -> SurfaceMesh:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from gpytoolbox import decimate  # noqa: PLC0415 (importing it warns of its own use of SciPy)

        vertices, faces, _, _ = decimate(surface.vertices.copy(), surface.faces.copy(), num_faces=count, method="qslim")
    return SurfaceMesh(vertices, faces)


def _distance(coarse: SurfaceMesh, fine: SurfaceMesh, tree: TriangleTree) -> float:
    """Two-sided largest distance from vertices to surface [mm]."""
    there = tree.nearest(coarse.vertices).distance.max()
    back = TriangleTree(coarse.vertices, coarse.faces).nearest(fine.vertices).distance.max()
    return float(max(there, back))


def _tidied(surface: SurfaceMesh, vertices: NDArray[np.float64], tets: NDArray[np.int32]) -> TetMesh:
    """Positively oriented, degenerate ones dropped, the largest body kept, flat base set down, numbered for locality."""
    volumes = TetMesh(vertices, tets).volumes
    upright = np.where((volumes < 0)[:, None], tets[:, [0, 2, 1, 3]], tets)[volumes != 0]
    graph = sp.coo_array((np.ones(4 * len(upright)), (np.repeat(np.arange(len(upright)), 4), upright.ravel())))
    incidence = sp.csr_array(graph)
    neighbours = sp.csr_array(incidence @ incidence.T)
    _, body = connected_components(neighbours, directed=False)
    upright = upright[body == np.bincount(body).argmax()]
    kept = np.flatnonzero(body == np.bincount(body).argmax())
    order = reverse_cuthill_mckee(sp.csr_array(neighbours[kept][:, kept]), symmetric_mode=True)
    ordered = upright[order]
    used, first = np.unique(ordered, return_index=True)
    rank = np.empty(len(vertices), np.int32)
    rank[used[np.argsort(first)]] = np.arange(len(used), dtype=np.int32)
    return TetMesh(_set_down(surface, vertices[used[np.argsort(first)]]), rank[ordered])


def _set_down(surface: SurfaceMesh, vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vertices within FLAT of a flat base lie in its plane again; fTetWild leaves them anywhere in its envelope."""
    floor = float(surface.vertices[:, 2].min())
    flat = (surface.corners[:, :, 2] < floor + 1e-6).all(axis=1)
    if not flat.any():
        return vertices
    near = np.flatnonzero(vertices[:, 2] < floor + FLAT)
    if not len(near):
        return vertices
    face = TriangleTree(surface.vertices, surface.faces).nearest(vertices[near]).face
    settled = vertices.copy()
    settled[near[flat[face]], 2] = floor
    return settled


def _fault(surface: SurfaceMesh, tets: TetMesh) -> str:
    """What is wrong with a mesh, "" if nothing is."""
    if tets.volumes.min() <= 0:
        return "some tetrahedra are turned inside out"
    if not SurfaceMesh(tets.vertices, tets.boundary_faces).is_closed:
        return "the surface of its tetrahedra is not closed"
    volume = float(tets.volumes.sum()) / surface.volume
    if abs(volume - 1.0) > VOLUME_ERROR:
        return f"the tetrahedra hold {volume:.1%} of its volume"
    return ""


def _read(file: Path) -> TetMesh | None:
    """A kept mesh, or None if there is none that can be read."""
    try:
        with np.load(file, allow_pickle=False) as kept:
            tets = TetMesh(kept["vertices"], kept["tets"])
            return tets if str(kept["digest"]) == tets.digest else None
    except (OSError, ValueError, KeyError, zipfile.BadZipFile):
        return None


def _write(file: Path, tets: TetMesh) -> None:
    """Keep a mesh: written aside, then renamed."""
    file.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=file.parent, prefix=".new-", suffix=".npz")
    try:
        with os.fdopen(handle, "wb") as aside:
            np.savez_compressed(aside, vertices=tets.vertices, tets=tets.tets, digest=np.array(tets.digest))
        Path(name).replace(file)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
