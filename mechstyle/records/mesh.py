"""The two meshes everything works on, a closed triangle surface and the tetrahedra inside it, and the points in simple shapes.

Both are frozen, their arrays write-protected; methods named with a participle return new objects.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]
Bools = NDArray[np.bool_]
Field = NDArray[np.float32]
"""Values at the vertices of a surface, shape [vertex_count] or [vertex_count, 3]."""
Scalar = TypeVar("Scalar", bound=np.generic)

STANDARD_VERTICES = 100_000
"""Vertices of a standardised surface by default, at most: see `simulation.part.standardised`."""
QUICK_VERTICES = 2_000
"""Vertices of a quick run, which has the same tests."""
FEWEST_VERTICES, MOST_VERTICES = 500, 400_000
"""What may be asked for."""


def frozen_array(values: ArrayLike, dtype: Any, shape: tuple[int | None, ...], name: str) -> NDArray[Any]:
    """A contiguous, write-protected copy of `values`, or a ValueError if its shape is not `shape` (None: any)."""
    array = np.array(values, dtype=dtype, order="C", copy=True)
    fits = array.ndim == len(shape) and all(want in (None, have) for want, have in zip(shape, array.shape, strict=True))
    if not fits:
        wanted = ", ".join("n" if size is None else str(size) for size in shape)
        raise ValueError(f"{name} must have shape ({wanted}), not {array.shape}")
    array.setflags(write=False)
    return array


def digest_of(*arrays: NDArray[Any]) -> str:
    """SHA-256 over the type, shape and bytes of the arrays, in order."""
    total = hashlib.sha256()
    for array in arrays:
        total.update(f"{array.dtype.str}{array.shape}".encode())
        total.update(np.ascontiguousarray(array).tobytes())
    return total.hexdigest()


@dataclass(frozen=True, eq=False)
class SurfaceMesh:
    """A triangle surface in millimetres, z up, as it stands on the floor.

    Attributes:
        vertices: Positions [mm], shape [vertex_count, 3], float64.
        faces: Vertex indices, anticlockwise seen from outside, shape [face_count, 3], int32.
        colours: Display RGB in [0, 1], shape [vertex_count, 3], float32, or None for an uncoloured part.

    Example:
        >>> corner = ms.SurfaceMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
        >>> corner.faces.shape
        (4, 3)
    """

    vertices: Floats
    faces: Indices
    colours: NDArray[np.float32] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", frozen_array(self.vertices, np.float64, (None, 3), "vertices"))
        object.__setattr__(self, "faces", frozen_array(self.faces, np.int32, (None, 3), "faces"))
        if self.colours is not None:
            object.__setattr__(self, "colours", frozen_array(self.colours, np.float32, (len(self.vertices), 3), "colours"))
        if self.faces.size and not (self.faces.min() >= 0 and self.faces.max() < len(self.vertices)):
            raise ValueError(f"faces must index the {len(self.vertices)} vertices")

    def __getstate__(self) -> dict[str, object]:
        """The arrays alone: what was derived from them may be added to by another thread while this one is pickled."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    def __repr__(self) -> str:
        """Counts and size; never the arrays."""
        x, y, z = self.extents if len(self.vertices) else (0.0, 0.0, 0.0)
        return f"SurfaceMesh({len(self.vertices)} vertices, {len(self.faces)} faces, {x:.1f} x {y:.1f} x {z:.1f} mm)"

    @cached_property
    def corners(self) -> Floats:
        """Corner positions [mm], shape [face_count, 3, 3]."""
        return self.vertices[self.faces]

    @cached_property
    def face_vectors(self) -> Floats:
        """Face normals times twice the area [mm²], shape [face_count, 3]."""
        a, b, c = self.corners[:, 0], self.corners[:, 1], self.corners[:, 2]
        return np.cross(b - a, c - a)

    @cached_property
    def face_areas(self) -> Floats:
        """Face areas [mm²], shape [face_count]."""
        return 0.5 * np.linalg.norm(self.face_vectors, axis=1)

    @cached_property
    def face_normals(self) -> Floats:
        """Outward unit normals, shape [face_count, 3]; zero for a face without area."""
        lengths = np.linalg.norm(self.face_vectors, axis=1, keepdims=True)
        return np.divide(self.face_vectors, lengths, out=np.zeros_like(self.face_vectors), where=lengths > 0)

    @cached_property
    def vertex_normals(self) -> Floats:
        """Angle-weighted outward unit normals (Thürmer and Wüthrich 1998), shape [vertex_count, 3]."""
        weighted = []
        for corner in range(3):
            here = self.corners[:, corner]
            ahead = self.corners[:, (corner + 1) % 3] - here
            behind = self.corners[:, (corner + 2) % 3] - here
            sine = np.linalg.norm(np.cross(ahead, behind), axis=1)
            angle = np.arctan2(sine, np.einsum("ij,ij->i", ahead, behind))
            weighted.append(self.face_normals * angle[:, None])
        around, count = self.faces.T.ravel(), len(self.vertices)
        total = np.stack([np.bincount(around, part, count) for part in np.concatenate(weighted).T], axis=1)
        lengths = np.linalg.norm(total, axis=1, keepdims=True)
        return np.divide(total, lengths, out=np.zeros_like(total), where=lengths > 1e-12)

    @cached_property
    def vertex_areas(self) -> Floats:
        """A third of the area of the faces around each vertex [mm²], shape [vertex_count]."""
        thirds = np.repeat(self.face_areas / 3.0, 3)
        return np.bincount(self.faces.ravel(), thirds, len(self.vertices)).astype(np.float64)

    @cached_property
    def edges(self) -> Indices:
        """Undirected edges, lower index first, sorted, shape [edge_count, 2]."""
        start, end, count = self.faces.ravel(), np.roll(self.faces, -1, axis=1).ravel(), len(self.vertices)
        names = np.sort(np.minimum(start, end) * np.int64(count) + np.maximum(start, end))  # rows are sorted ten times as slowly
        return np.stack(np.divmod(names[np.diff(names, prepend=-1) > 0], max(count, 1)), axis=1).astype(np.int32)

    @cached_property
    def edge_length(self) -> float:
        """Edge of an equilateral triangle of the mean face area [mm]."""
        return float(np.sqrt(self.face_areas.mean() * 4.0 / np.sqrt(3.0)))

    @cached_property
    def extents(self) -> Floats:
        """Side lengths of the bounding box [mm], shape [3]."""
        return np.ptp(self.vertices, axis=0)

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounding box [mm]."""
        return float(np.linalg.norm(self.extents))

    @cached_property
    def volume(self) -> float:
        """Enclosed volume [mm³]; negative if the faces point inwards."""
        a, b, c = self.corners[:, 0], self.corners[:, 1], self.corners[:, 2]
        return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)

    @property
    def centre_of_mass(self) -> Floats:
        """Centre of mass of the solid inside [mm], shape [3], by the divergence theorem."""
        a, b, c = self.corners[:, 0], self.corners[:, 1], self.corners[:, 2]
        volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
        return np.asarray((volumes[:, None] * (a + b + c)).sum(axis=0) / (4.0 * volumes.sum()))  # no BLAS, which depends on the cores

    @cached_property
    def is_closed(self) -> bool:
        """Whether every directed edge is met by exactly one opposite edge (watertight, manifold edges, oriented)."""
        directed = self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64)
        forth = directed[:, 0] * len(self.vertices) + directed[:, 1]
        back = directed[:, 1] * len(self.vertices) + directed[:, 0]
        forth.sort()
        back.sort()
        return bool(len(forth) and np.array_equal(forth, back) and np.all(np.diff(forth) > 0))

    @cached_property
    def digest(self) -> str:
        """SHA-256 of vertices and faces; colours do not count."""
        return digest_of(self.vertices, self.faces)

    def dilated(self, values: NDArray[Scalar]) -> NDArray[Scalar]:
        """The largest of the values at each vertex and its neighbours (grey dilation), shape [vertex_count].

        What is small afterwards is small over an area: a wall is thin there, not only along a sharp edge or at one vertex.
        """
        largest = values.copy()
        for one, other in (self.edges.T, self.edges.T[::-1]):
            np.maximum.at(largest, one, values[other])
        return largest

    def displaced(self, displacement: ArrayLike) -> SurfaceMesh:
        """The surface with every vertex moved by `displacement` [mm], shape [vertex_count], along its normal."""
        distance = frozen_array(displacement, np.float64, (len(self.vertices),), "displacement")
        return self.moved(self.vertices + self.vertex_normals * distance[:, None])

    def moved(self, vertices: ArrayLike) -> SurfaceMesh:
        """The same faces and colours on other vertex positions [mm], shape [vertex_count, 3]."""
        return self._handing_on(SurfaceMesh(np.asarray(vertices, np.float64), self.faces, self.colours), ("edges",))

    def coloured(self, colours: ArrayLike | None) -> SurfaceMesh:
        """The same surface with other colours in [0, 1], shape [vertex_count, 3]."""
        other = SurfaceMesh(self.vertices, self.faces, None if colours is None else np.asarray(colours, np.float32))
        return self._handing_on(other, _DERIVED)

    def _handing_on(self, other: SurfaceMesh, names: tuple[str, ...]) -> SurfaceMesh:
        """Another surface that knows what this one has worked out already, as far as it holds for both."""
        known = vars(self)
        vars(other).update({name: known[name] for name in names if name in known})
        return other


_DERIVED = tuple(name for name, value in vars(SurfaceMesh).items() if isinstance(value, cached_property))
"""What follows from vertices and faces."""


@dataclass(frozen=True, eq=False)
class TetMesh:
    """Linear tetrahedra in millimetres, positively oriented.

    Attributes:
        vertices: Positions [mm], shape [vertex_count, 3], float64.
        tets: Vertex indices with positive volume, shape [tet_count, 4], int32.
    """

    vertices: Floats
    tets: Indices

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", frozen_array(self.vertices, np.float64, (None, 3), "vertices"))
        object.__setattr__(self, "tets", frozen_array(self.tets, np.int32, (None, 4), "tets"))
        if self.tets.size and not (self.tets.min() >= 0 and self.tets.max() < len(self.vertices)):
            raise ValueError(f"tets must index the {len(self.vertices)} vertices")

    def __getstate__(self) -> dict[str, object]:
        """The arrays alone: what was derived from them may be added to by another thread while this one is pickled."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    def __repr__(self) -> str:
        """Counts and volume; never the arrays."""
        return f"TetMesh({len(self.vertices)} vertices, {len(self.tets)} tets, {self.volumes.sum():.0f} mm³)"

    @cached_property
    def volumes(self) -> Floats:
        """Signed volumes [mm³], shape [tet_count]."""
        a, b, c, d = (self.vertices[self.tets[:, k]] for k in range(4))
        return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0

    @cached_property
    def quality(self) -> Floats:
        """Mean-ratio quality 12 (3V)^(2/3) / Σ l² (Liu and Joe 1994), signed, 1 for a regular tet, 0 for a flat one, shape [tet_count]."""
        corners = self.vertices[self.tets]
        first, second = np.triu_indices(4, k=1)
        lengths2 = ((corners[:, first] - corners[:, second]) ** 2).sum(axis=(1, 2))
        shape = np.sign(self.volumes) * 12.0 * (3.0 * np.abs(self.volumes)) ** (2.0 / 3.0)
        return np.divide(shape, lengths2, out=np.zeros_like(shape), where=lengths2 > 0)

    @cached_property
    def boundary_faces(self) -> Indices:
        """Faces with one tetrahedron only, anticlockwise seen from outside, shape [face_count, 3]."""
        faces = self.tets[:, [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]].reshape(-1, 3)
        _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        return np.ascontiguousarray(faces[np.sort(first[count == 1])])

    @cached_property
    def boundary(self) -> SurfaceMesh:
        """The surface of those faces."""
        used, numbers = np.unique(self.boundary_faces, return_inverse=True)
        return SurfaceMesh(self.vertices[used], numbers.reshape(-1, 3).astype(np.int32))

    @cached_property
    def digest(self) -> str:
        """SHA-256 of vertices and tets."""
        return digest_of(self.vertices, self.tets)

    def moved(self, vertices: ArrayLike) -> TetMesh:
        """The same tetrahedra on other vertex positions [mm], shape [vertex_count, 3]."""
        return replace(self, vertices=np.asarray(vertices, np.float64))


FLOOR_TOLERANCE = 0.1
"""Faces whose corners are this close to the lowest point stand on the floor [mm] …"""
STEEPEST = np.cos(np.radians(5.0))
"""… if they look down within 5°."""


def in_box(points: Floats, low: ArrayLike, high: ArrayLike, *, margin: float = 0.0) -> Bools:
    """Whether points, shape [..., 3], lie between the lowest and the highest corner, or no more than a margin outside; lengths in mm."""
    return np.asarray(((points >= np.asarray(low) - margin) & (points <= np.asarray(high) + margin)).all(axis=-1))


def in_ball(points: Floats, centre: ArrayLike, radius: float, *, margin: float = 0.0) -> Bools:
    """Whether points, shape [..., 3], lie within a radius of a centre, the border included; as `in_box`."""
    return np.asarray(np.linalg.norm(points - np.asarray(centre), axis=-1) <= radius + margin)


def in_half_space(points: Floats, point: ArrayLike, normal: ArrayLike, *, margin: float = 0.0) -> Bools:
    """Whether points, shape [..., 3], lie on the side of a plane that its normal, of any length, points to; as `in_box`."""
    towards = np.asarray(normal, np.float64)
    return np.asarray((points - np.asarray(point)) @ towards >= -margin * np.linalg.norm(towards))


def on_floor(surface: SurfaceMesh) -> Bools:
    """Whether each face lies flat on the floor, which is at the lowest vertex, shape [face_count]."""
    low = surface.corners[:, :, 2] < surface.vertices[:, 2].min() + FLOOR_TOLERANCE
    return np.asarray(low.all(axis=1) & (surface.face_normals[:, 2] < -STEEPEST))
