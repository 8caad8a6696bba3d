"""A relief under a part that keeps it standing level: drawn inwards, its highest areas in the plane of the floor, nothing below it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.sparse.csgraph import connected_components

from mechstyle.geometry.resting_face import resting_face
from mechstyle.records.mesh import Bools, Field, Floats, Indices, SurfaceMesh

QUANTILES = (0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0)
"""Share of a flat face that a relief may leave the floor on: the first that keeps LEAST_SHARE of it level is taken.

A relief shifted by its maximum stands on points, and the points carry the impact; level areas of a sixth of the base were enough.
"""
LEAST_SHARE = 0.05
"""Least share of a flat face that stays level."""
WHOLLY = 1.0 - 1e-6
"""A vertex of which more than this share rests is within the face; less is rounding."""
SEEN = 0.02
"""What is lifted off the floor by less still stands on it [mm]."""


@dataclass(frozen=True, eq=False)
class FlatFace:
    """One connected flat face on the floor."""

    faces: Indices  # its triangles, as places in `vertices`, shape [face_count, 3]
    areas: Floats  # their areas [mm²], shape [face_count]
    vertices: Indices  # its vertices, shape [k]
    resting: Floats  # share of the area around a vertex that rests, 1 within the face, less on its rim, shape [k]
    weights: Floats  # resting area at the vertices that are wholly within it [mm²], shape [k]; at all of them if the face is a narrow strip

    def shift(self, relief: Floats) -> float:
        """How far a relief [mm], shape [k], is drawn inwards: by its quantile, not at all if that lies inwards already and enough is level.

        Minus infinity where no shift leaves enough of the face level.
        """
        # Each is the smallest value that, with all below it, holds a share of the weight; values of no weight do not count.
        counted = self.weights > 0.0
        order = np.argsort(relief[counted], kind="stable")
        values, total = relief[counted][order], np.cumsum(self.weights[counted][order])
        quantiles = (float(values[min(np.searchsorted(total, share * total[-1]), len(total) - 1)]) for share in QUANTILES)
        highest = next(quantiles)
        for shift in chain((max(highest, 0.0), highest), quantiles):
            if self.share(relief - self.resting * shift >= 0.0) >= LEAST_SHARE:
                return shift
        return -np.inf

    def share(self, level: Bools) -> float:
        """Share of its area whose triangles have level corners, given which vertices are, shape [k]."""
        return float(self.areas[level[self.faces].all(axis=1)].sum() / self.areas.sum())


class LevelBase:
    """The flat faces a surface, as it stands, rests on, and the floor as a bound on its relief; worked out once per surface."""

    def __init__(self, surface: SurfaceMesh) -> None:
        self._surface = surface
        self.faces = flat_faces(surface)
        gap = surface.vertices[:, 2] - surface.vertices[:, 2].min()
        up = surface.vertex_normals[:, 2]
        self.ceiling = np.divide(gap, -up, out=np.full(len(gap), np.inf), where=up < 0.0)
        """Largest displacement outwards that stays above the floor [mm], shape [vertex_count]."""
        self.deepest = np.divide(gap, up, out=np.full(len(gap), np.inf), where=up > 0.0)
        """The same inwards, where that leads down."""

    @property
    def resting(self) -> Floats:
        """Share of the area around each vertex that rests on the floor, shape [vertex_count]."""
        share = np.zeros(len(self._surface.vertices))
        for face in self.faces:
            share[face.vertices] = face.resting
        return share

    @property
    def standing(self) -> Bools:
        """Whether a vertex belongs to the flat faces, their rims included, shape [vertex_count]."""
        return self.resting > 0.0

    def levelled(self, displacement: ArrayLike) -> Field:
        """A relief [mm], shape [vertex_count], shifted inwards on every flat face and then kept above the floor.

        A relief that is levelled already stays as it is, and one that is scaled is levelled to the scaled result.
        """
        relief = np.array(displacement, np.float64)
        for face in self.faces:
            there = relief[face.vertices]
            shift = face.shift(there)
            relief[face.vertices] = there - face.resting * shift if np.isfinite(shift) else np.maximum(there, 0.0)
        return self.clipped(relief)

    def clipped(self, displacement: ArrayLike) -> Field:
        """A relief [mm], shape [vertex_count], less what would go below the floor."""
        return np.clip(np.asarray(displacement, np.float64), -self.deepest, self.ceiling).astype(np.float32)

    def share(self, displacement: ArrayLike) -> float | None:
        """Share of the area of the flat faces that a relief leaves on the floor, None for a part that stands on none."""
        if not self.faces:
            return None
        lifted = np.asarray(displacement, np.float64) * self._surface.vertex_normals[:, 2]
        level = sum(face.share(lifted[face.vertices] <= SEEN) * face.areas.sum() for face in self.faces)
        return float(level / sum(face.areas.sum() for face in self.faces))

    def contrast(self, displacement: ArrayLike) -> Field:
        """A relief [mm], shape [vertex_count], without its mean on each flat face: what is left of it whatever it was shifted by."""
        relief = np.array(displacement, np.float64)
        for face in self.faces:
            relief[face.vertices] -= face.resting * np.average(relief[face.vertices], weights=face.weights)
        return relief.astype(np.float32)


def flat_faces(surface: SurfaceMesh) -> tuple[FlatFace, ...]:
    """The connected flat faces a part stands on, none for one that would roll, tip or stand on a point."""
    base = resting_face(surface)
    if base is None:
        return ()
    corners, areas = surface.faces[base.faces], surface.face_areas[base.faces]
    rests = np.bincount(corners.ravel(), np.repeat(areas / 3.0, 3), len(surface.vertices)).astype(np.float64)
    share = np.divide(rests, surface.vertex_areas, out=np.zeros_like(rests), where=rests > 0.0)
    share[share > WHOLLY] = 1.0
    count = len(surface.vertices)
    ends = (np.concatenate([corners[:, 0], corners[:, 1]]), np.concatenate([corners[:, 1], corners[:, 2]]))
    body = connected_components(sp.coo_array((np.ones(len(ends[0])), ends), shape=(count, count)).tocsr(), directed=False)[1]
    found = []
    for label in np.unique(body[corners[:, 0]]):
        here = body[corners[:, 0]] == label
        vertices, places = np.unique(corners[here], return_inverse=True)
        within = np.where(share[vertices] == 1.0, rests[vertices], 0.0)
        weights = within if within.sum() > 0.5 * areas[here].sum() else rests[vertices]
        found.append(FlatFace(places.reshape(-1, 3).astype(np.int32), areas[here], vertices.astype(np.int32), share[vertices], weights))
    return tuple(found)
