"""What the time integration needs to know of a body: numbering, gradients, masses, neighbours. Shared by all orientations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from mechstyle.errors import BadInput
from mechstyle.fea.elasticity import element_frequencies, element_masses, lumped_masses, shape_gradients
from mechstyle.material import Material
from mechstyle.mesh import Floats, Indices, TetMesh


@dataclass(frozen=True, eq=False)
class Discretisation:
    """A body in the order in which it is computed.

    Vertices are numbered along a reverse Cuthill–McKee ordering and tetrahedra by their first vertex, so that what is used
    together lies together in memory; `vertex_order` and `tet_order` lead back to the caller's numbering. Vertices that no
    tetrahedron uses are left out.

    Attributes:
        tets: The renumbered tetrahedra.
        vertex_order: Caller's number of each vertex, shape [vertex_count].
        tet_order: Caller's number of each tetrahedron, shape [tet_count].
        gradients: ∇N_1, ∇N_2, ∇N_3 [1/mm] as rows, shape [tet_count, 3, 3]; ∇N_0 is minus their sum.
        masses: Lumped vertex masses after sliver scaling [g], shape [vertex_count].
        added_mass: Mass added to slivers over the mass of the body.
        first_corner: Where each vertex's corners start in `corners`, shape [vertex_count + 1].
        corners: For each vertex in turn the corners 4 e + a it is of tetrahedra e, ascending, shape [4 tet_count].
    """

    tets: TetMesh
    vertex_order: Indices
    tet_order: Indices
    gradients: Floats
    masses: Floats
    added_mass: float
    first_corner: Indices
    corners: Indices


def discretise(tets: TetMesh, material: Material, added_mass: float) -> Discretisation:
    """Renumber a body and lump its masses, those of slivers increased by at most the share `added_mass` of the whole.

    BadInput if there is no tetrahedron, a vertex is not finite or a tetrahedron is flat or inverted.
    """
    _refuse_unusable(tets)
    vertex_order = _bandwidth_order(tets)
    number = np.zeros(len(tets.vertices), dtype=np.int32)
    number[vertex_order] = np.arange(len(vertex_order), dtype=np.int32)
    renumbered = number[tets.tets]
    tet_order = np.argsort(renumbered.min(axis=1), kind="stable").astype(np.int32)
    body = TetMesh(tets.vertices[vertex_order], renumbered[tet_order])
    scale = sliver_scale(body, material, added_mass)
    masses = element_masses(body, material.density)
    corner_vertices = body.tets.ravel()
    first_corner = np.concatenate([[0], np.cumsum(np.bincount(corner_vertices, minlength=len(body.vertices)))])
    return Discretisation(
        tets=body,
        vertex_order=vertex_order,
        tet_order=tet_order,
        gradients=shape_gradients(body)[:, 1:],
        masses=lumped_masses(body, masses * scale),
        added_mass=float(masses @ scale / masses.sum() - 1.0),
        first_corner=first_corner.astype(np.int32),
        corners=np.argsort(corner_vertices, kind="stable").astype(np.int32),
    )


def sliver_scale(tets: TetMesh, material: Material, added_mass: float) -> Floats:
    """Factors ≥ 1 on element masses that lengthen the stable step most for at most `added_mass` more mass, shape [tet_count].

    Every element whose own stable step 2/ω_e falls below a common target is made heavier until it reaches it; the
    target is the largest that adds no more than the given share of the body's mass.
    """
    frequency2 = element_frequencies(tets, material) ** 2
    share = tets.volumes / tets.volumes.sum()
    # With target frequency² t the added share is Σ share · max(0, frequency²/t − 1): linear in 1/t between sorted frequencies.
    order = np.argsort(-frequency2)
    heavy, stiff = np.cumsum(share[order]), np.cumsum((share * frequency2)[order])
    targets = stiff / (added_mass + heavy)
    target = float(targets.max()) if added_mass > 0 else float(frequency2.max())
    return np.maximum(1.0, frequency2 / target)


def _refuse_unusable(tets: TetMesh) -> None:
    """BadInput unless there are tetrahedra, all finite and of positive volume."""
    if len(tets.tets) == 0:
        raise BadInput("there are no tetrahedra to drop: the part must be meshed inside first")
    if not np.isfinite(tets.vertices).all():
        raise BadInput(f"{int((~np.isfinite(tets.vertices)).any(axis=1).sum())} vertices of the tetrahedra are not finite numbers")
    flat = np.flatnonzero(tets.volumes <= 0.0)
    if len(flat):
        x, y, z = tets.vertices[tets.tets[flat[0]]].mean(axis=0)
        raise BadInput(f"{len(flat)} tetrahedra have no positive volume, the first at ({x:.1f}, {y:.1f}, {z:.1f}) mm; mesh the part again")


def _bandwidth_order(tets: TetMesh) -> Indices:
    """The used vertices in reverse Cuthill–McKee order along the edges of the tetrahedra, shape [used]."""
    start, end = tets.tets[:, [0, 0, 0, 1, 1, 2]].ravel(), tets.tets[:, [1, 2, 3, 2, 3, 3]].ravel()
    count = len(tets.vertices)
    links = coo_array((np.ones(2 * len(start), dtype=np.int32), (np.r_[start, end], np.r_[end, start])), shape=(count, count))
    order = reverse_cuthill_mckee(links.tocsr(), symmetric_mode=True)
    used = np.zeros(count, dtype=bool)
    used[tets.tets] = True
    return order[used[order]].astype(np.int32)
