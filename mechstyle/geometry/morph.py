"""Carrying a displacement of the surface into the tetrahedra without meshing anew."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

from mechstyle.errors import BadInput
from mechstyle.geometry.proximity import TriangleTree
from mechstyle.records.mesh import FLOOR_TOLERANCE, Floats, SurfaceMesh, TetMesh, frozen_array

LEAST_QUALITY = 0.08  # mean ratio below which a tetrahedron is backed off ...
LEAST_SHARE = 0.5  # ... or below this share of its own undeformed quality, if that is less
FACTOR = 0.75  # of the displacement that is left at the vertices of such a tetrahedron, per round
WIDEN_EVERY = 8  # rounds after which the back-off takes in one more ring of tetrahedra, so that it always ends


@dataclass(frozen=True, eq=False)
class Morphed:
    """Tetrahedra that follow a displacement of the surface."""

    tets: TetMesh  # the moved tetrahedra, same numbering as the undeformed ones
    # what they follow [mm], shape [vertex_count], float32: the request, less what would have spoilt a tetrahedron. Asked for again, it
    # gives the same tetrahedra. Never more than the request: where they cannot come back as far as that from what they were made for,
    # they stand in for it, and `deviation` says how far off they are
    displacement: NDArray[np.float32]
    # how far their boundary has gone along the normals from where it is without relief [mm], shape [vertex_count]; flat facets carry less
    # than the displacement where they are larger than the relief
    followed: NDArray[np.float32]
    backed_off: float  # share of the surface area whose displacement was reduced, or is stood in for
    deviation: float  # largest reduction, or distance of a stand-in [mm]


class Morph:
    """Moves one set of tetrahedra with one surface; built once per part.

    Boundary nodes take the displacement of the surface point they lie on, but go no lower than the surface does: they lie a little beside
    it, and a node 0.03 mm below the floor would land alone. Under the part they take its height, or a relief laid flat would leave a bed of
    nodes on the floor and hundredths above it, which lands on few of them. Inner nodes follow harmonically: the Laplace equation on the
    tetrahedra as they were made, linear elements, factored once.

    Tetrahedra of the undeformed surface carry no relief: on flat faces they are larger than it. Made for half of a relief they keep its
    triangles, and neither the way back to none nor the way on to all of it is long enough to turn many of them inside out, unless it is as
    deep as its triangles are wide: then a tetrahedron with all corners on the surface would vanish on the way back, and is backed off.

    Args:
        surface: The undeformed surface, n vertices.
        tets: Tetrahedra of it displaced by `at`.
        at: The displacement they were made for [mm], shape [n]; None for none.
        device: Warp device of the searches.
    """

    def __init__(self, surface: SurfaceMesh, tets: TetMesh, at: ArrayLike | None = None, *, device: str = "cpu") -> None:
        self.surface = surface
        self.tets = tets
        self.at = frozen_array(np.zeros(len(surface.vertices)) if at is None else at, np.float32, (len(surface.vertices),), "displacement")
        made_for = surface.displaced(self.at)
        self._outer = np.unique(tets.boundary_faces)
        self._inner = np.setdiff1d(np.arange(len(tets.vertices)), self._outer)
        self._onto_nodes = TriangleTree(made_for.vertices, made_for.faces, device).interpolation(tets.vertices[self._outer])
        self._onto_surface = TriangleTree(tets.vertices, tets.boundary_faces, device).interpolation(made_for.vertices)
        self._nearest_outer = self._outer[cKDTree(tets.vertices[self._outer]).query(tets.vertices)[1]]
        self._floor = np.minimum(LEAST_QUALITY, LEAST_SHARE * tets.quality)
        stiffness = laplacian(tets)
        # How far nodes under the part lie above the surface they were made for [mm], where setting them right spoils no tetrahedron.
        lifted = tets.vertices[self._outer, 2] - self._onto_nodes @ made_for.vertices[:, 2]
        lifted[self._onto_nodes @ (surface.vertices[:, 2] - surface.vertices[:, 2].min()) > FLOOR_TOLERANCE] = 0.0
        while True:
            set_right = tets.vertices.copy()
            set_right[self._outer, 2] -= lifted
            spoilt = np.isin(self._outer, tets.tets[tets.moved(set_right).quality < self._floor])
            if not lifted[spoilt].any():
                break
            lifted[spoilt] = 0.0
        self._lifted = lifted
        self._coupling = stiffness[self._inner][:, self._outer]
        self._factored = splu(stiffness[self._inner][:, self._inner].tocsc()) if len(self._inner) else None

    def morphed(self, displacement: ArrayLike) -> Morphed:
        """The tetrahedra under a displacement of the surface along its vertex normals [mm], shape [n].

        Where a tetrahedron would fall below a mean ratio of 0.08 (or half of its own as it was made), the way of the displacement around
        it from `at` is scaled by 0.75, again and again until none does. `at` gives back the vertices as they were made, bit for bit.

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
            for _ in range(rounds // WIDEN_EVERY):  # rings around the bad ones
                touched = np.zeros(len(self.tets.vertices), dtype=bool)
                touched[self.tets.tets[bad]] = True
                bad = np.any(touched[self.tets.tets], axis=1, keepdims=True)[:, 0]
            share[np.unique(self._nearest_outer[self.tets.tets[bad]])] *= FACTOR  # for an inner node the nearest on the boundary
            made_for = self.at.astype(np.float64)
            accepted = (made_for + (request - made_for) * (self._onto_surface @ share)).astype(np.float32)

    def _vertices(self, displacement: NDArray[np.float32]) -> Floats:
        """Node positions [mm] under a surface displacement, shape [k, 3]."""
        if np.array_equal(displacement, self.at):
            return self.tets.vertices.copy()
        vectors = self.surface.vertex_normals * (displacement.astype(np.float64) - self.at)[:, None]
        outer = self._onto_nodes @ vectors
        outer[:, 2] -= self._lifted
        floor = float(self.surface.displaced(displacement).vertices[:, 2].min())
        outer[:, 2] = np.maximum(outer[:, 2], floor - self.tets.vertices[self._outer, 2])
        vertices = self.tets.vertices.copy()
        vertices[self._outer] += outer
        if self._factored is not None:
            vertices[self._inner] += self._factored.solve(-(self._coupling @ outer))
        return vertices

    def _result(self, moved: TetMesh, request: NDArray[np.float32], accepted: NDArray[np.float32]) -> Morphed:
        lost = np.abs(request.astype(np.float64) - accepted)
        areas = self.surface.vertex_areas
        share, deviation = float(areas[lost > 0].sum() / areas.sum()), float(lost.max(initial=0.0))
        gone = self._onto_surface @ (moved.vertices - self._without_relief)
        followed = np.einsum("ij,ij->i", gone, self.surface.vertex_normals).astype(np.float32)
        given = np.clip(accepted, np.minimum(request, 0.0), np.maximum(request, 0.0))
        return Morphed(moved, frozen_array(given, np.float32, (None,), "displacement"), followed, share, deviation)

    @property
    def volume_without_relief(self) -> float:
        """Volume of the tetrahedra without any displacement [mm³]."""
        return float(self.tets.moved(self._without_relief).volumes.sum())

    @cached_property
    def _without_relief(self) -> Floats:
        """Node positions [mm] without any displacement, sound or not, shape [k, 3]."""
        return self._vertices(np.zeros_like(self.at))


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
