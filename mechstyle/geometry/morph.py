"""Carrying a displacement of the surface into the tetrahedra without meshing anew."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

from mechstyle.errors import BadInput
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.records.mesh import Floats, SurfaceMesh, TetMesh, frozen_array

LEAST_QUALITY = 0.08  # mean ratio below which a tetrahedron is backed off ...
LEAST_SHARE = 0.5  # ... or below this share of its own quality at rest, if that is less
FACTOR = 0.75  # of the displacement that is left at the vertices of such a tetrahedron, per round
WIDEN_EVERY = 8  # rounds after which the back-off takes in one more ring of tetrahedra, so that it always ends
REMESH_SHARE = 0.02  # of the area backed off, above which meshing anew is advised
REMESH_DEVIATION = 0.005  # of the diagonal, the same


@dataclass(frozen=True, eq=False)
class Morphed:
    """Tetrahedra that follow a displacement of the surface.

    Attributes:
        tets: The moved tetrahedra, same numbering as at rest.
        displacement: What they follow [mm], shape [vertex_count], float32: the request, less what would have spoilt a tetrahedron.
            Asked for again, it gives the same tetrahedra.
        backed_off: Share of the surface area whose displacement was reduced.
        deviation: Largest reduction [mm].
        remesh: Whether meshing anew is advised: more than 2 % of the area was reduced, or somewhere by more than 0.5 % of
            the diagonal.
    """

    tets: TetMesh
    displacement: NDArray[np.float32]
    backed_off: float
    deviation: float
    remesh: bool


class Morph:
    """Moves one set of tetrahedra with one surface; built once per part.

    Boundary nodes take the displacement of the surface point they lie on. Inner nodes follow harmonically:
    the Laplace equation on the tetrahedra at rest, linear elements, factored once.

    Args:
        surface: The surface at rest, n vertices.
        tets: Its tetrahedra at rest.
        device: Warp device of the searches.
    """

    def __init__(self, surface: SurfaceMesh, tets: TetMesh, *, device: str = "cpu") -> None:
        self.surface = surface
        self.tets = tets
        self._outer = np.unique(tets.boundary_faces)
        self._inner = np.setdiff1d(np.arange(len(tets.vertices)), self._outer)
        self._onto_nodes = TriangleTree(surface.vertices, surface.faces, device).interpolation(tets.vertices[self._outer])
        self._onto_surface = TriangleTree(tets.vertices, tets.boundary_faces, device).interpolation(surface.vertices)
        self._nearest_outer = self._outer[cKDTree(tets.vertices[self._outer]).query(tets.vertices)[1]]
        self._floor = np.minimum(LEAST_QUALITY, LEAST_SHARE * tets.quality)
        stiffness = laplacian(tets)
        self._coupling = stiffness[self._inner][:, self._outer]
        self._factored = splu(stiffness[self._inner][:, self._inner].tocsc()) if len(self._inner) else None

    def morphed(self, displacement: ArrayLike) -> Morphed:
        """The tetrahedra under a displacement of the surface along its vertex normals [mm], shape [n].

        Where a tetrahedron would fall below a mean ratio of 0.08 (or half of its own at rest), the displacement around it
        is scaled by 0.75, again and again until none does. Zero displacement gives back the vertices at rest, bit for bit.

        Raises:
            BadInput: If the displacement has the wrong length or is not finite.
        """
        request = np.asarray(displacement, dtype=np.float32)
        if request.shape != (len(self.surface.vertices),) or not np.isfinite(request).all():
            raise BadInput(f"a displacement needs {len(self.surface.vertices)} finite numbers, one per surface vertex")
        share = np.ones(len(self.tets.vertices))
        accepted, rounds = request, 0
        while True:
            moved = self.tets.moved(self._vertices(accepted))
            bad = moved.quality < self._floor
            if not bad.any():
                return self._result(moved, request, accepted)
            rounds += 1
            share[self._to_reduce(bad, rings=rounds // WIDEN_EVERY)] *= FACTOR
            accepted = (request * (self._onto_surface @ share)).astype(np.float32)

    def _vertices(self, displacement: NDArray[np.float32]) -> Floats:
        """Node positions [mm] under a surface displacement, shape [k, 3]."""
        vectors = self.surface.vertex_normals * displacement[:, None].astype(np.float64)
        outer = self._onto_nodes @ vectors
        vertices = self.tets.vertices.copy()
        vertices[self._outer] += outer
        if self._factored is not None:
            vertices[self._inner] += self._factored.solve(-(self._coupling @ outer))
        return vertices

    def _to_reduce(self, bad: NDArray[np.bool_], rings: int) -> NDArray[np.int32]:
        """Boundary nodes of the bad tetrahedra and of `rings` rings around them; for inner nodes the nearest boundary node."""
        tets = self.tets.tets
        for _ in range(rings):
            touched = np.zeros(len(self.tets.vertices), dtype=bool)
            touched[tets[bad]] = True
            bad = np.any(touched[tets], axis=1, keepdims=True)[:, 0]
        return np.asarray(np.unique(self._nearest_outer[tets[bad]]))

    def _result(self, moved: TetMesh, request: NDArray[np.float32], accepted: NDArray[np.float32]) -> Morphed:
        lost = np.abs(request.astype(np.float64) - accepted)
        areas = self.surface.vertex_areas
        share, deviation = float(areas[lost > 0].sum() / areas.sum()), float(lost.max(initial=0.0))
        remesh = share > REMESH_SHARE or deviation > REMESH_DEVIATION * self.surface.size
        return Morphed(moved, frozen_array(accepted, np.float32, (None,), "displacement"), share, deviation, remesh)


def laplacian(tets: TetMesh) -> sp.csr_array:
    """Stiffness of the Laplace equation with linear elements, K_ij = Σ V ∇λ_i·∇λ_j [mm], shape [vertex_count, vertex_count]."""
    corners = tets.vertices[tets.tets]
    edges = corners[:, 1:] - corners[:, :1]
    gradients = np.linalg.inv(edges).transpose(0, 2, 1)
    gradients = np.concatenate([-gradients.sum(axis=1, keepdims=True), gradients], axis=1)
    local = tets.volumes[:, None, None] * (gradients @ gradients.transpose(0, 2, 1))
    rows, columns = np.repeat(tets.tets, 4, axis=1), np.tile(tets.tets, (1, 4))
    count = len(tets.vertices)
    return sp.coo_array((local.ravel(), (rows.ravel(), columns.ravel())), shape=(count, count)).tocsr()
