"""Discrete operators of a triangle surface: cotangent weights, tangent frames, parallel transport, diffusion.

What rests on them: relief that does not fold over itself.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.sparse.linalg import cg

from mechstyle.records.mesh import Floats, Indices, SurfaceMesh

Complexes = NDArray[np.complex128]

_EXACT = 1e-10  # of a diffused field, what its equation may be off
_SHARP = float(np.cos(np.radians(20.0)))  # a vertex is on a sharp edge if a face around it leans more than this from its normal


class Operators:
    """Discrete operators on one surface; lengths in mm.

    Attributes:
        mesh: The surface.
        tail: First vertex of each edge, shape [edge_count].
        head: Second vertex of each edge, shape [edge_count].
    """

    def __init__(self, mesh: SurfaceMesh) -> None:
        self.mesh = mesh
        self.tail: Indices = mesh.edges[:, 0]
        self.head: Indices = mesh.edges[:, 1]

    @cached_property
    def edge_vectors(self) -> Floats:
        """From tail to head [mm], shape [edge_count, 3]."""
        return np.asarray(self.mesh.vertices[self.head] - self.mesh.vertices[self.tail])

    @cached_property
    def weights(self) -> Floats:
        """Cotangent weight of each edge, ½(cot α + cot β), kept positive, shape [edge_count]."""
        count = len(self.mesh.vertices)
        total = sp.csr_array((count, count))
        for corner in range(3):
            here = self.mesh.corners[:, corner]
            left = self.mesh.corners[:, (corner + 1) % 3] - here
            right = self.mesh.corners[:, (corner + 2) % 3] - here
            sine = np.maximum(np.linalg.norm(np.cross(left, right), axis=1), 1e-12)
            half_cot = 0.5 * np.einsum("ij,ij->i", left, right) / sine
            i, j = np.sort(self.mesh.faces[:, [(corner + 1) % 3, (corner + 2) % 3]], axis=1).T
            total = total + sp.csr_array((half_cot, (i, j)), (count, count))
        # Obtuse triangles would give negative weights, with which a smoothest field need not exist.
        return np.asarray(np.clip(total[self.tail, self.head], 0.05, 5.0))

    @cached_property
    def sharp(self) -> NDArray[np.bool_]:
        """Which vertices lie on a sharp edge, one that turns by 40° or more, shape [vertex_count]."""
        faces = self.mesh.faces[self.mesh.face_areas > 0.0]
        normals = self.mesh.face_normals[self.mesh.face_areas > 0.0]
        leaning = np.einsum("ikj,ij->ik", self.mesh.vertex_normals[faces], normals) < _SHARP
        marked = np.zeros(len(self.mesh.vertices), dtype=bool)
        marked[faces[leaning]] = True
        return marked

    @cached_property
    def room(self) -> Floats:
        """Way along the surface to the nearest sharp edge [mm], infinite where there is none, shape [vertex_count]."""
        if not self.sharp.any():
            return np.full(len(self.mesh.vertices), np.inf)
        count, lengths = len(self.mesh.vertices), np.linalg.norm(self.edge_vectors, axis=1)
        graph = sp.csr_array((np.maximum(lengths, 1e-9), (self.tail, self.head)), (count, count))
        return np.asarray(dijkstra(graph, directed=False, indices=np.flatnonzero(self.sharp), min_only=True))

    @cached_property
    def sides(self) -> Indices:
        """Label of the side of the part each vertex is on, up to the sharp edges; -1 on these, shape [vertex_count]."""
        return np.where(self.sharp, -1, self.components(~self.sharp[self.tail] & ~self.sharp[self.head]))

    @cached_property
    def frames(self) -> tuple[Floats, Floats]:
        """Orthonormal tangent vectors x, y with x × y = n at each vertex, shape [vertex_count, 3] each."""
        normal = self.mesh.vertex_normals
        other = np.where(np.abs(normal[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
        x = np.cross(normal, other)
        x /= np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-12)
        return np.asarray(x), np.asarray(np.cross(normal, x))

    @cached_property
    def transport(self) -> Floats:
        """Angle that takes frame coordinates at the tail to those at the head [rad], shape [edge_count].

        The tail's frame is turned by the least rotation that takes its normal to the head's.
        """
        x, y = self.frames
        turned = self.carried(x[self.tail])
        return np.asarray(np.arctan2(np.einsum("ij,ij->i", turned, y[self.head]), np.einsum("ij,ij->i", turned, x[self.head])))

    def carried(self, vectors: Floats) -> Floats:
        """Tangent vectors at the tails, shape [edge_count, 3], turned into the tangent planes of the heads."""
        before, after = self.mesh.vertex_normals[self.tail], self.mesh.vertex_normals[self.head]
        cosine = np.einsum("ij,ij->i", before, after)
        along = np.einsum("ij,ij->i", vectors, after) / np.maximum(1.0 + cosine, 1e-6)
        return np.asarray(vectors - along[:, None] * (before + after))

    @cached_property
    def laplacian(self) -> sp.csr_array:
        """Positive cotangent Laplacian, shape [vertex_count, vertex_count]."""
        count = len(self.mesh.vertices)
        degree = np.bincount(self.tail, self.weights, count) + np.bincount(self.head, self.weights, count)
        links = sp.csr_array((self.weights, (self.tail, self.head)), (count, count))
        return sp.csr_array(sp.diags_array(degree) - links - links.T)

    @cached_property
    def ring_mean(self) -> sp.csr_array:
        """Matrix that takes the mean over each vertex's neighbours, shape [vertex_count, vertex_count]."""
        count, ones = len(self.mesh.vertices), np.ones(len(self.tail))
        graph = sp.csr_array((ones, (self.tail, self.head)), (count, count))
        graph = graph + graph.T
        return sp.csr_array(sp.diags_array(1.0 / np.maximum(graph.sum(axis=1), 1.0)) @ graph)

    def slope(self, values: Floats) -> Floats:
        """Gradient magnitude of values [n] along the surface, averaged over the edges around each vertex [1/mm], shape [n]."""
        steps = np.abs(values[self.head] - values[self.tail])
        lengths = np.linalg.norm(self.edge_vectors, axis=1)
        count = len(values)
        squares, runs = (np.bincount(self.tail, part, count) + np.bincount(self.head, part, count) for part in (steps**2, lengths**2))
        return np.asarray(np.sqrt(2.0 * squares / np.maximum(runs, 1e-12)))  # an edge sees half of a slope's square on average

    def diffused(self, values: Floats, length: float) -> Floats:
        """Values [n] or [n, k] smoothed over `length` [mm]: one implicit step of heat flow."""
        heat_flow = sp.csr_array(sp.diags_array(self.mesh.vertex_areas) + 0.5 * length**2 * self.laplacian)
        columns, inverse = np.atleast_2d(values.T), sp.diags_array(1.0 / heat_flow.diagonal())
        found = [cg(heat_flow, self.mesh.vertex_areas * one, x0=one, rtol=_EXACT, M=inverse)[0] for one in columns]
        return np.stack(found, axis=-1).reshape(values.shape)

    def components(self, together: NDArray[np.bool_]) -> Indices:
        """Label of the piece each vertex is in, when only the edges marked `together` [edge_count] hold."""
        count, kept = len(self.mesh.vertices), int(together.sum())
        graph = sp.csr_array((np.ones(kept), (self.tail[together], self.head[together])), (count, count))
        return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int32)


_STEEPEST = 0.17  # cosine of 80°, the most a face may turn
_ROUNDS = 60


def unfolded(operators: Operators, displacement: Floats) -> Floats:
    """The displacement [mm], shape [n], lowered around every face that would turn by more than 80°.

    Normals converge in an inner corner and diverge little across a steep edge, so that moved vertices can overtake each other. There
    the relief is drawn towards that of its neighbours and a little towards zero, in rounds, which ends at the undisplaced surface at
    the latest. It never grows, so that limits kept before are still kept.
    """
    mesh = operators.mesh
    lowered, with_area = displacement.copy(), mesh.face_areas > 0.0
    nearby = np.flatnonzero(with_area)
    for _ in range(_ROUNDS):
        styled = SurfaceMesh(mesh.displaced(lowered).vertices, mesh.faces[nearby])
        turned = nearby[np.einsum("ij,ij->i", styled.face_normals, mesh.face_normals[nearby]) < _STEEPEST]
        if not len(turned):
            break
        around = np.unique(mesh.faces[turned])
        calm = 0.5 * lowered[around] + 0.4 * (operators.ring_mean[around] @ lowered)
        low, high = np.minimum(0.0, 0.95 * lowered[around]), np.maximum(0.0, 0.95 * lowered[around])
        lowered[around] = np.clip(calm, low, high)
        moved = np.zeros(len(lowered), bool)
        moved[around] = True
        nearby = np.flatnonzero(moved[mesh.faces].any(axis=1) & with_area)  # no other face has turned since
    return lowered
