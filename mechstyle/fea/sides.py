"""The boundary of a body seen as sides of its walls: which spots lie near each other on the same side.

A spot is a vertex together with the direction of the surface there. Where faces meet smoothly a vertex is one spot; on a sharp edge or
corner it is one for each of its faces, because what is near it on the one side has nothing to do with what is near it on the other.
Near means within a straight distance, with normals that differ by less than 60°, and connected by such surface: the other side of a thin
wall is not near, and neither is the same side of the next wall. Around marked vertices the surface may also turn by an edge, be it sharp,
chamfered or rounded, but not by as much as from one side of a wall to the other.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from mechstyle.records.mesh import Bools, Floats, Indices, SurfaceMesh, TetMesh

SAME_SIDE = math.cos(math.radians(60.0))
ROUND_AN_EDGE = math.cos(math.radians(110.0))
"""More than the 90° from a flat face to the next past a chamfer, less than the 125° from the corner of a floor to its upper side."""

SMOOTH = math.cos(math.radians(30.0))
"""Faces within 30° of the mean normal of their vertex meet smoothly there."""

ISLAND = 4.0
"""Area of a piece of surface that belongs to the zone around it [mm²]: a third of the disc over which a mean along the surface is taken.
Ledges of bricks are that small: on a towel hook 2 mm² would do."""

SPACING = 1.0
"""Distance of the points that stand for the surface, about [mm]."""


class Sides:
    """Spots and points on the boundary of a mesh.

    Attributes:
        faces: Boundary faces, shape [face_count, 3].
        vertices: Vertex of each spot, shape [spot_count].
        spots: Spot at each corner of each face, shape [face_count, 3].
        points: Interpolation from the vertices to the points, of which those of a face share its area, shape [point_count, vertex_count].
        face_of: Face of each point, shape [point_count].
    """

    def __init__(self, tets: TetMesh) -> None:
        boundary = SurfaceMesh(tets.vertices, tets.boundary_faces)
        self.faces, self._vertices, self._normals = boundary.faces, boundary.vertices, boundary.face_normals
        self._areas = boundary.face_areas
        # By angle, so that a corner of a floor does not look sideways where its triangle of the floor is small.
        self._means = boundary.vertex_normals
        self.spots, self.vertices, self._face = _spots(self.faces, self._normals, self._means)
        self._directions = self._directed(boundary)
        self.points, self.face_of = surface_points(tets, self.faces)
        self._beside = _neighbours(self.faces)

    @property
    def positions(self) -> Floats:
        """Of the spots on the mesh they were made from [mm], shape [spot_count, 3]."""
        return self._vertices[self.vertices]

    def weights(self, tets: TetMesh) -> Floats:
        """Area each point stands for on a morph of the mesh [mm²], shape [point_count]."""
        areas = SurfaceMesh(tets.vertices, self.faces).face_areas
        return np.asarray((areas / np.bincount(self.face_of, minlength=len(areas)))[self.face_of])

    def directions(self, tets: TetMesh) -> Floats:
        """Outward unit normals at the spots of a morph of the mesh, shape [spot_count, 3]."""
        return self._directed(SurfaceMesh(tets.vertices, self.faces))

    def _directed(self, boundary: SurfaceMesh) -> Floats:
        return np.where(self._face[:, None] < 0, boundary.vertex_normals[self.vertices], boundary.face_normals[self._face])

    def near(self, reach: float) -> csr_array:
        """Which points lie within `reach` [mm] of which spots on the same side, ones of shape [spot_count, point_count]."""
        spot, point = self._within(reach, np.ones(len(self.vertices), dtype=bool))
        alike = _cosines(self._directions[spot], self._normals[self.face_of[point]]) >= SAME_SIDE
        return self._joined(spot[alike], point[alike])

    def near_on_any_side(self, reach: float, asked: Bools) -> csr_array:
        """Which points lie within `reach` [mm] of which spots and are joined to them by the surface, past edges, too.

        Args:
            reach: Straight distance [mm].
            asked: Spots asked about, shape [spot_count]; none are near the others.

        Returns:
            Ones, shape [spot_count, point_count].
        """
        return self._joined(*self._within(reach, asked))

    def _within(self, reach: float, asked: Bools) -> tuple[Indices, Indices]:
        """Pairs of a spot asked about and a point within a straight distance [mm]."""
        spots = np.flatnonzero(asked).astype(np.int32)
        there = cKDTree(self.points @ self._vertices)
        found = cKDTree(self.positions[spots]).sparse_distance_matrix(there, reach, output_type="ndarray")
        return spots[found["i"]], found["j"]

    def _joined(self, spot: Indices, point: Indices) -> csr_array:
        """Of pairs those that are joined by the faces of the pairs, ones of shape [spot_count, point_count]."""
        kept = self._connected(spot, self.face_of[point])
        ones = np.ones(int(kept.sum()), np.float32)
        return coo_array((ones, (spot[kept], point[kept])), shape=(len(self.vertices), len(self.face_of))).tocsr()

    def around(self, marked: Bools, reach: float, splinters: Bools) -> Bools:
        """Spots within `reach` [mm] of marked vertices, not through the wall; shape [spot_count].

        Args:
            marked: Which vertices are, shape [vertex_count].
            reach: Straight distance [mm].
            splinters: Spots of sides too small to be one of a wall, of which the mean of all faces at the vertex tells on which side they
                are, shape [spot_count].
        """
        seeds = np.unique(self.vertices[marked[self.vertices]])
        if not len(seeds):
            return np.zeros(len(self.vertices), dtype=bool)
        found = cKDTree(self.positions).sparse_distance_matrix(cKDTree(self._vertices[seeds]), reach, output_type="ndarray")
        directions = np.where(splinters[:, None], self._means[self.vertices], self._directions)
        beside = _cosines(directions[found["i"]], self._means[seeds[found["j"]]]) >= ROUND_AN_EDGE
        close = np.zeros(len(self.vertices), dtype=bool)
        close[found["i"][beside]] = True
        reached = np.asarray(close[self.spots].any(axis=1))
        one, other = self._beside.nonzero()
        within = reached[one] & reached[other]
        links = coo_array((np.ones(within.sum()), (one[within], other[within])), shape=self._beside.shape)
        _, label = connected_components(links, directed=False)
        kept = reached & np.isin(label, label[marked[self.faces].any(axis=1)])
        zone = np.zeros(len(self.vertices), dtype=bool)
        zone[self.spots[kept]] = True
        zone &= close
        near = np.zeros(len(self.vertices), dtype=bool)
        near[found["i"]] = True
        zone[self.spots[self._islands(zone, near)]] = True
        return zone

    def _islands(self, zone: Bools, near: Bools) -> Bools:
        """Faces in pieces smaller than ISLAND that a zone surrounds, none of them farther away than it reaches; shape [face_count].

        Next to a contact the walls of a brick look away from it: what they part from the zone is no other side of the wall. A hole inside
        the body that no zone touches is a side of its own, however small and near.

        Args:
            zone: Spots in the zone, shape [spot_count].
            near: Spots within its reach, whichever way they look, shape [spot_count].
        """
        outside = np.asarray(~zone[self.spots].all(axis=1))
        one, other = self._beside.nonzero()
        both = outside[one] & outside[other]
        links = coo_array((np.ones(both.sum()), (one[both], other[both])), shape=self._beside.shape)
        count, piece = connected_components(links, directed=False)
        joins = np.bincount(piece, self._areas * outside, count) < ISLAND
        joins[piece[outside & ~near[self.spots].all(axis=1)]] = False
        touched = np.zeros(count, dtype=bool)
        touched[piece[one[outside[one] & ~outside[other]]]] = True
        return np.asarray(outside & (joins & touched)[piece])

    def _connected(self, spot: Indices, face: Indices) -> Bools:
        """Which pairs of a spot and a face near it are joined to the spot by such faces; a pair may be named several times."""
        count = len(self.faces)
        pairs, number = np.unique(spot.astype(np.int64) * count + face, return_inverse=True)
        beside = self._beside[pairs % count].tocoo()
        linked = pairs[beside.row] // count * count + beside.col
        place = np.minimum(np.searchsorted(pairs, linked), len(pairs) - 1)
        there = pairs[place] == linked
        links = coo_array((np.ones(there.sum()), (beside.row[there], place[there])), shape=(len(pairs),) * 2)
        _, label = connected_components(links, directed=False)
        own = np.zeros(len(pairs), dtype=bool)
        ours = self.spots.ravel().astype(np.int64) * count + np.repeat(np.arange(count), 3)
        own[np.isin(pairs, ours)] = True
        return np.asarray(np.isin(label, label[own])[number])


def _cosines(one: Floats, other: Floats) -> Floats:
    return np.asarray(np.einsum("nx,nx->n", one, other))


def _spots(faces: Indices, normals: Floats, means: Floats) -> tuple[Indices, Indices, Indices]:
    """Spot at each corner of the faces, vertex of each spot, and its face on a sharp edge or corner, elsewhere -1."""
    corners = faces.ravel()
    sharp = np.zeros(len(means), dtype=bool)
    sharp[corners[_cosines(means[corners], np.repeat(normals, 3, axis=0)) < SMOOTH]] = True
    names = np.where(sharp[corners], len(means) + np.arange(len(corners)), corners)  # a sharp corner is a spot of its own
    _, first, spots = np.unique(names, return_index=True, return_inverse=True)
    vertices = corners[first]
    return spots.reshape(-1, 3).astype(np.int32), vertices, np.where(sharp[vertices], first // 3, -1)


def surface_points(tets: TetMesh, faces: Indices) -> tuple[csr_array, Indices]:
    """Points that stand for faces: centroids of n² equal triangles a face is cut into, n from its longest edge.

    Returns:
        Interpolation from the vertices, shape [point_count, vertex_count], and face of each point, shape [point_count].
    """
    corners = tets.vertices[faces]
    longest = np.linalg.norm(corners - corners[:, [1, 2, 0]], axis=2).max(axis=1)
    cuts = np.maximum(1, np.rint(longest / SPACING)).astype(int)
    owners, shares = [], []
    for n in np.unique(cuts):
        cut = np.flatnonzero(cuts == n)
        inside = _centroids(int(n))
        owners.append(np.repeat(cut, len(inside)))
        shares.append(np.tile(inside, (len(cut), 1)))
    face_of, weights = np.concatenate(owners).astype(np.int32), np.concatenate(shares)
    rows = np.repeat(np.arange(len(face_of)), 3)
    return coo_array((weights.ravel(), (rows, faces[face_of].ravel())), shape=(len(face_of), len(tets.vertices))).tocsr(), face_of


def _centroids(n: int) -> Floats:
    """Barycentric coordinates of the centroids of the n² equal triangles of a regular division, shape [n², 3]."""
    i, j = (index.ravel() for index in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    up, down = i + j < n, i + j < n - 1
    plane = np.concatenate([np.stack([i, j], axis=1)[up] + 1 / 3, np.stack([i, j], axis=1)[down] + 2 / 3]) / n
    return np.concatenate([1.0 - plane.sum(axis=1, keepdims=True), plane], axis=1)


def _neighbours(faces: Indices) -> csr_array:
    """Which faces share an edge, shape [face_count, face_count]."""
    ends = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, edge = np.unique(ends, axis=0, return_inverse=True)
    owner = np.repeat(np.arange(len(faces)), 3)
    meets = coo_array((np.ones(len(owner), np.int8), (owner, edge.ravel())), shape=(len(faces), int(edge.max()) + 1)).tocsr()
    return (meets @ meets.T).tocsr()
