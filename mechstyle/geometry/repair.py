"""From triangles as files have them to one closed, outward, manifold body; every repair is said in words."""

from __future__ import annotations

from typing import Any

import manifold3d
import numpy as np
import trimesh
from numpy.typing import NDArray

from mechstyle.errors import BadInput, SimulationFailed
from mechstyle.geometry.standardise import manifold_of, surface_of
from mechstyle.geometry.tetwild import Settings, tetwild
from mechstyle.mesh import Floats, SurfaceMesh, TetMesh

DEBRIS = 1e-3
"""Bodies smaller than this share of the largest are dropped as debris."""
LARGEST_HOLE = 0.02
"""Openings whose edges are together longer than this share of all edges are not holes but a missing side."""
REMESH_TIMEOUT = 120.0


def repaired(vertices: Floats, faces: NDArray[np.int64], name: str) -> tuple[SurfaceMesh, tuple[str, ...]]:
    """One closed body from a triangle soup, and what had to be done to it, one sentence each.

    Args:
        vertices: Positions [mm], shape [n, 3].
        faces: Vertex indices, shape [m, 3].
        name: What to call the file in a refusal.

    Raises:
        BadInput: If it encloses nothing, cannot be closed, or consists of separate bodies.
    """
    notes: list[str] = []
    mesh = _welded(trimesh.Trimesh(vertices, faces, process=False), notes)
    if not len(mesh.faces):
        raise BadInput(f"{name} holds no triangle with an area: export it again from the program it was made with")
    body = _closed(mesh, name, notes)
    body = _one_body(body, name, notes)
    return surface_of(body), tuple(notes)


def _welded(mesh: trimesh.Trimesh, notes: list[str]) -> trimesh.Trimesh:
    """Equal vertices merged, whatever their normals and texture say; degenerate and repeated faces dropped.

    Faces with repeated indices go, faces without area stay: they close gaps between their neighbours.
    """
    before = len(mesh.vertices)
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    if len(mesh.vertices) < before:
        notes.append(f"welded {before - len(mesh.vertices)} duplicate vertices")
    a, b, c = mesh.faces.T
    proper = (a != b) & (b != c) & (c != a)
    once = np.zeros(len(mesh.faces), bool)
    once[mesh.unique_faces()] = True
    keep = proper & once
    if not keep.all():
        notes.append(f"dropped {int((~keep).sum())} degenerate or repeated faces")
        mesh.update_faces(keep)
    mesh.remove_unreferenced_vertices()
    return mesh


def _closed(mesh: trimesh.Trimesh, name: str, notes: list[str]) -> Any:
    """The mesh as a valid Manifold: as it is, welded closer, wound the right way, holes filled, or meshed anew from its inside."""
    body = _accepted(_surface(mesh))
    if body is None:
        body = _accepted(_surface(mesh), merge=True)
        if body is not None:
            notes.append("closed hairline gaps between its faces")
    if body is None:
        body = _filled(mesh, notes)
    if body is None:
        body = _from_inside(mesh, name, notes)
    if body.volume() < 0:
        notes.append("turned its faces outwards")
        body = _accepted(_flipped(surface_of(body)))
    return body


def _surface(mesh: trimesh.Trimesh) -> SurfaceMesh:
    return SurfaceMesh(mesh.vertices, mesh.faces)


def _flipped(mesh: SurfaceMesh) -> SurfaceMesh:
    return SurfaceMesh(mesh.vertices, mesh.faces[:, ::-1])


def _accepted(surface: SurfaceMesh, *, merge: bool = False) -> Any | None:
    """A Manifold of the surface, or None if it is not one."""
    if merge:
        loose = manifold3d.Mesh(surface.vertices.astype(np.float32), surface.faces.astype(np.uint32))
        body = manifold3d.Manifold(loose) if loose.merge() else None
    else:
        body = manifold_of(surface)
    fits = body is not None and body.status() == manifold3d.Error.NoError and not body.is_empty()
    return body if fits and abs(body.volume()) > 0 else None


def _filled(mesh: trimesh.Trimesh, notes: list[str]) -> Any | None:
    """Consistent winding and small holes closed."""
    mended = mesh.copy()
    trimesh.repair.fix_winding(mended)
    trimesh.repair.fix_inversion(mended, multibody=True)
    body = _accepted(_surface(mended))
    if body is not None:
        notes.append("made the winding of its faces consistent")
        return body
    before = len(mended.faces)
    if _open_share(mended) > LARGEST_HOLE:
        return None
    trimesh.repair.fill_holes(mended)
    body = _accepted(_surface(mended)) or _accepted(_surface(mended), merge=True)
    if body is not None:
        notes.append(f"closed its holes with {len(mended.faces) - before} faces")
    return body


def _open_share(mesh: trimesh.Trimesh) -> float:
    """Length of the edges with one face over that of all edges."""
    edges = mesh.edges_sorted
    _, first, count = np.unique(edges, axis=0, return_index=True, return_counts=True)
    lengths = np.linalg.norm(np.diff(mesh.vertices[edges[first]], axis=1)[:, 0], axis=1)
    return float(lengths[count == 1].sum() / max(lengths.sum(), 1e-12))


def _from_inside(mesh: trimesh.Trimesh, name: str, notes: list[str]) -> Any:
    """What fTetWild takes for its inside: the last resort for surfaces that cut through themselves or do not quite meet."""
    share = _open_share(mesh)
    if share > LARGEST_HOLE:
        raise BadInput(
            f"{name} is open and cannot be closed: {share:.0%} of its edge length borders nothing; "
            "close it (give it a thickness, cap its openings) and export it again"
        )
    size = float(np.linalg.norm(mesh.extents))
    try:
        vertices, tets = tetwild(
            np.asarray(mesh.vertices), np.asarray(mesh.faces, np.int32), Settings(0.03 * size, 5e-4), timeout=REMESH_TIMEOUT
        )
    except SimulationFailed as error:
        raise BadInput(
            f"{name} is not a closed surface and could not be repaired ({error}); repair it in the program it was made with"
        ) from error
    body = _accepted(_boundary(vertices, tets))
    if body is None:
        raise BadInput(f"{name} is not a closed surface and could not be repaired; repair it in the program it was made with")
    notes.append("rebuilt its surface from the volume inside it, because its faces cut through each other or do not meet")
    return body


def _boundary(vertices: Floats, tets: NDArray[np.int32]) -> SurfaceMesh:
    """The outer surface of tetrahedra of any orientation."""
    volumes = TetMesh(vertices, tets).volumes
    upright = np.where((volumes < 0)[:, None], tets[:, [0, 2, 1, 3]], tets)
    faces = TetMesh(vertices, upright).boundary_faces
    used, index = np.unique(faces, return_inverse=True)
    return SurfaceMesh(vertices[used], index.reshape(-1, 3))


def _one_body(body: Any, name: str, notes: list[str]) -> Any:
    """Debris dropped and overlapping bodies united; separate ones refused."""
    shells = body.decompose()
    solids = sorted((shell for shell in shells if shell.volume() > 0), key=lambda shell: -shell.volume())
    cavities = [shell for shell in shells if shell.volume() < 0]
    if not solids:
        raise BadInput(f"{name} encloses no volume: its faces cancel out")
    large = [solid for solid in solids if solid.volume() >= DEBRIS * solids[0].volume()]
    if len(large) < len(solids):
        notes.append(f"dropped {len(solids) - len(large)} specks smaller than {DEBRIS:.1%} of the part")
    if len(large) == 1 and len(solids) == 1:
        return body
    united = manifold3d.Manifold.batch_boolean(large, manifold3d.OpType.Add)
    for cavity in cavities:
        united -= _accepted(_flipped(surface_of(cavity))) or manifold3d.Manifold()
    left = [part for part in united.decompose() if part.volume() > 0]
    if len(left) > 1:
        sizes = ", ".join(f"{part.volume():.0f} mm³" for part in sorted(left, key=lambda part: -part.volume())[:4])
        raise BadInput(
            f"{name} holds {len(left)} separate bodies ({sizes}): a drop test needs one; save the part you want alone, or join them"
        )
    if len(large) > 1:
        notes.append(f"united {len(large)} overlapping bodies")
    return united
