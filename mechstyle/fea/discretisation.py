"""A body prepared for time integration: numbering, gradients, masses, neighbours. Shared by all orientations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from mechstyle.errors import BadInput
from mechstyle.fea.elasticity import barycentric_gradients, element_frequencies, lumped_masses
from mechstyle.fea.elements import LINEAR, Element, ElementMesh, with_nodes
from mechstyle.records.material import Material
from mechstyle.records.mesh import Floats, Indices, TetMesh


@dataclass(frozen=True, eq=False)
class Discretisation:
    """A body in the order in which it is computed.

    Nodes are numbered along a reverse Cuthill–McKee ordering and tetrahedra by their first node, so that what is used together
    lies together in memory. Vertices that no tetrahedron uses are left out.

    Attributes:
        mesh: The tetrahedra and nodes in the caller's numbering, without unused vertices.
        vertices: Caller's numbers of the vertices of `mesh`, shape [vertex_count].
        place: Where each node of `mesh` is computed, shape [node_count].
        tet_order: Tetrahedron of `mesh` that is computed in each place, shape [tet_count].
        connectivity: Nodes of each tetrahedron in the order of computation, shape [tet_count, nodes].
        gradients: ∇L_1, ∇L_2, ∇L_3 [1/mm] as rows, shape [tet_count, 3, 3]; ∇L_0 is minus their sum.
        volumes: Volumes [mm³], shape [tet_count].
        frequencies: Largest eigenfrequency of each tetrahedron on its own [rad/ms] up to a common factor, shape [tet_count]: as of a linear
            element, see `sliver_scale`.
        masses: Lumped masses after sliver scaling [g], shape [node_count].
        added_mass: Mass added to slivers over the mass of the body.
        slots: Where an element's share of a force on a node goes before the shares are added up, shape [tet_count, nodes]: the slots
            of a node follow each other in the order of the tetrahedra.
        first_slot: Where each node's slots start, shape [node_count + 1].
    """

    mesh: ElementMesh
    vertices: Indices
    place: Indices
    tet_order: Indices
    connectivity: Indices
    gradients: Floats
    volumes: Floats
    frequencies: Floats
    masses: Floats
    added_mass: float
    slots: Indices
    first_slot: Indices

    @property
    def positions(self) -> Floats:
        """Nodes in the order of computation [mm], shape [node_count, 3]."""
        positions = np.empty_like(self.mesh.nodes)
        positions[self.place] = self.mesh.nodes
        return positions

    @property
    def centre(self) -> Floats:
        """Centre of mass [mm], shape [3]."""
        return np.asarray(self.masses @ self.positions / self.masses.sum())

    @property
    def arms(self) -> Floats:
        """Nodes seen from the centre of mass, in the order of computation [mm], shape [node_count, 3]."""
        return self.positions - self.centre


def discretise(tets: TetMesh, material: Material, added_mass: float, element: Element = LINEAR) -> Discretisation:
    """Number a body and lump its masses, those of slivers increased by at most the share `added_mass` of the whole.

    BadInput if there is no tetrahedron, a vertex is not finite or a tetrahedron is flat or inverted.
    """
    _refuse_unusable(tets)
    vertices = np.unique(tets.tets)
    mesh = with_nodes(TetMesh(tets.vertices[vertices], np.searchsorted(vertices, tets.tets).astype(np.int32)), element)
    place = np.argsort(_bandwidth_order(mesh)).astype(np.int32)
    numbered = place[mesh.connectivity]
    tet_order = np.argsort(numbered.min(axis=1), kind="stable").astype(np.int32)
    connectivity = np.ascontiguousarray(numbered[tet_order])
    scale = sliver_scale(mesh.tets, material, added_mass)
    masses = material.density * mesh.tets.volumes
    lumped = np.empty(len(mesh.nodes))
    lumped[place] = lumped_masses(mesh, masses * scale)
    slot_nodes = connectivity.ravel()
    return Discretisation(
        mesh=mesh,
        vertices=vertices.astype(np.int32),
        place=place,
        tet_order=tet_order,
        connectivity=connectivity,
        gradients=barycentric_gradients(mesh.tets)[tet_order, 1:],
        volumes=mesh.tets.volumes[tet_order],
        frequencies=(element_frequencies(mesh.tets, material) / np.sqrt(scale))[tet_order],
        masses=lumped,
        added_mass=float(masses @ (scale - 1.0) / masses.sum()),
        slots=np.argsort(np.argsort(slot_nodes, kind="stable")).astype(np.int32).reshape(connectivity.shape),
        first_slot=np.concatenate([[0], np.cumsum(np.bincount(slot_nodes, minlength=len(place)))]).astype(np.int32),
    )


def sliver_scale(tets: TetMesh, material: Material, added_mass: float) -> Floats:
    """Factors ≥ 1 on element masses that lengthen the stable step most for at most `added_mass` more mass, shape [tet_count].

    Every element whose own stable step 2/ω_e falls below a common target is made heavier until it reaches it; the
    target is the largest that adds no more than the given share of the body's mass. Frequencies are those of linear elements;
    quadratic ones lie between 1.9 and 2.6 times as high, whatever the shape, so the slivers are the same.
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


def _bandwidth_order(mesh: ElementMesh) -> Indices:
    """The nodes in reverse Cuthill–McKee order along what the elements join, shape [node_count]."""
    count, tet_count = len(mesh.nodes), len(mesh.connectivity)
    start = np.repeat(np.arange(tet_count), mesh.element.nodes)
    inside = csr_array((np.ones(len(start), dtype=np.int32), (mesh.connectivity.ravel(), start)), shape=(count, tet_count))
    return reverse_cuthill_mckee((inside @ inside.T).tocsr(), symmetric_mode=True).astype(np.int32)
