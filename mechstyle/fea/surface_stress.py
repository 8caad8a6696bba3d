"""Stress where it is: on the surface, beside places where it has no limit, and in a ball there.

Bending, notches and holes have their largest stress on the surface, where a mean over a volume sees half of it in a thin wall and a Gauss
point lies too deep. So, with σ_s the stress at a vertex of the surface:

* **σ_s** is the volume-weighted mean over the tetrahedra of a vertex of their stress at that corner. The largest of them over the mean,
  less 1, is its jump: the estimate of its error (Zienkiewicz and Zhu 1992).
* **σ_2** is the area-weighted mean of σ_s within 2 mm on the same side of the wall. Pure bending is constant along a flat face, so nothing
  is lost, and what a mean misses around a round bar is added (`fea/plane_sections.py`); over a sharp inner edge, where σ_s grows with every
  finer mesh, it has a limit.
* Near contact, and near the border of a support or load, the surface itself has no finite stress; the mean over a **ball** decides there.
  Near is measured along the wall, past edges but not through it: the upper side of a floor bends freely while its underside rests.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mechstyle.fea.ball_average import RADIUS, BallAverage, largest_around
from mechstyle.fea.plane_sections import Patches
from mechstyle.fea.sides import Sides
from mechstyle.records.mesh import Bools, Floats, TetMesh

CONTACT_REACH = 3.0 + RADIUS
"""How far from a vertex that touched the floor the ball decides [mm]: nearer than 3 mm the stress of the contact itself is read, and a mean
along the surface is to see none of it."""

BORDER_REACH = 2.0
"""How far from the border of a support or load it does [mm]."""

SPLINTER = 2.0
"""Area of a side, within RADIUS of a spot, under which it is a splinter of the mesh [mm²]: a disc has 12.6, a square corner a quarter.
A folded triangle of 0.25 mm² at a foot looks upwards, and told 303 MPa of contact as if that bent the wall; a dart of 0.014 mm² inside
a hook told 188 MPa, where the largest of all other sides was 60. A strip as wide as a line of plastic has 1.6 mm²."""

RESOLVED = 0.15
"""Largest jump with which a mesh is said to resolve the stress at a vertex."""

Place = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Deciding:
    """The stress that decides.

    Attributes:
        field: At the vertices [MPa], shape [vertex_count]: on the surface outside zones σ_2, and with a load the larger of it and σ_s
            where that is resolved; in zones and inside the body the largest ball average of the tetrahedra there.
        outside: The same on the surface outside zones, 0 elsewhere [MPa], shape [vertex_count].
        surface: The largest on the surface outside zones [MPa], 0 if all of it is in zones.
        contact: The largest on the surface in zones [MPa], 0 if there are none.
        averaged: The largest without σ_s [MPa].
        resolved: The largest σ_s that counts [MPa], 0 if none does.
        surface_where, contact_where: Places of `surface` and `contact` [mm].
    """

    field: Floats
    outside: Floats
    surface: float
    contact: float
    averaged: float
    resolved: float
    surface_where: Place
    contact_where: Place

    @property
    def where(self) -> Place:
        """Place of `peak` [mm]."""
        return self.surface_where if self.surface >= self.contact else self.contact_where

    @property
    def peak(self) -> float:
        """The largest on the surface [MPa]."""
        return _largest(self.surface, self.contact)


class SurfaceStress:
    """What reads the deciding stress on a mesh and its morphs; neighbours and normals are those of the mesh given here.

    Args:
        tets: The undeformed mesh.
    """

    def __init__(self, tets: TetMesh) -> None:
        self.sides = Sides(tets)
        self.average = BallAverage(tets)
        self._near = self.sides.near(RADIUS)
        self._splinters = np.asarray(self._near @ self.sides.weights(tets)) < SPLINTER
        self._beside = self.sides.near_on_any_side(RADIUS, self._splinters)
        self._last: tuple[TetMesh, Patches] | None = None

    def contact_zone(self, touched: ArrayLike) -> Bools:
        """Spots near vertices that touched the floor, [vertex_count]; shape [spot_count]."""
        return self.sides.around(np.asarray(touched, dtype=bool), CONTACT_REACH, self._splinters)

    def border_zone(self, border: ArrayLike) -> Bools:
        """Spots near vertices on the border of supports and loads, [vertex_count]; shape [spot_count]."""
        return self.sides.around(np.asarray(border, dtype=bool), BORDER_REACH, self._splinters)

    def at_vertices(self, tets: TetMesh, corners: ArrayLike) -> tuple[Floats, Floats]:
        """σ_s [MPa] and its jump from the stress at the corners of the tetrahedra [MPa], [tet_count, 4]; both of shape [vertex_count].

        Where a vertex has one tetrahedron there is nothing to compare with: its jump is infinite.
        """
        stress = np.asarray(corners, dtype=np.float64)
        of, count = tets.tets.ravel(), len(tets.vertices)
        volume = np.bincount(of, np.repeat(tets.volumes, 4), count)
        total = np.bincount(of, (tets.volumes[:, None] * stress).ravel(), count)
        mean = np.divide(total, volume, out=np.zeros(count), where=volume > 0.0)
        largest = np.zeros(count)
        np.maximum.at(largest, of, stress.ravel())
        with np.errstate(invalid="ignore"):  # the stress of a failed drop is infinite
            jump = np.divide(largest, mean, out=np.ones(count), where=mean > 0.0) - 1.0
        return mean, np.where(np.bincount(of, minlength=count) > 1, jump, np.inf)

    def along(self, tets: TetMesh, at_vertices: Floats) -> Floats:
        """σ_2 at the spots from σ_s at the vertices [MPa], shape [spot_count]; σ_s where the surface has no area."""
        patches = self._patches(tets)
        there, at_points = at_vertices[self.sides.vertices], self.sides.points @ at_vertices
        own, around = patches.along(at_points, there), self._beside @ patches.weights
        # Squared, so that a strip as wide as a line of plastic keeps two thirds of its own, and a fin of 0.5 mm² a sixteenth.
        share = np.where(around > 0.0, np.minimum(patches.areas / SPLINTER, 1.0) ** 2, 1.0)
        beside = np.divide(self._beside @ (patches.weights * at_points), around, out=there, where=around > 0.0)
        return np.asarray(share * own + (1.0 - share) * beside)

    def _patches(self, tets: TetMesh) -> Patches:
        """Of a body; those of the last are kept, because a body is read landing by landing."""
        last = self._last
        if last is None or last[0] is not tets:
            last = self._last = tets, Patches(self._near, self.sides, tets)
        return last[1]

    def of_landing(self, tets: TetMesh, von_mises: ArrayLike, corners: ArrayLike, touched: ArrayLike) -> Deciding:
        """The deciding stress of a drop: σ_2 alone, because styled surfaces have roots as sharp as the mesh, where σ_s measures the mesh.

        Args:
            tets: The body, a morph of the mesh.
            von_mises: Stress at the Gauss points [MPa], shape [tet_count, points].
            corners: Stress at the corners [MPa], shape [tet_count, 4].
            touched: Which vertices touched the floor, shape [vertex_count].
        """
        return self._deciding(tets, von_mises, self.at_vertices(tets, corners)[0], np.zeros(0), self.contact_zone(touched))

    def of_load(self, tets: TetMesh, von_mises: ArrayLike, corners: ArrayLike, border: ArrayLike) -> Deciding:
        """The deciding stress under a load: σ_2, and σ_s where the mesh resolves it.

        Args:
            tets: The body, a morph of the mesh.
            von_mises: Stress at the Gauss points [MPa], shape [tet_count, points].
            corners: Stress at the corners [MPa], shape [tet_count, 4].
            border: Which vertices lie on the border of a support or load, shape [vertex_count].
        """
        stress, jump = self.at_vertices(tets, corners)
        return self._deciding(tets, von_mises, stress, np.where(jump <= RESOLVED, stress, 0.0), self.border_zone(border))

    def _deciding(self, tets: TetMesh, von_mises: ArrayLike, at_vertices: Floats, counting: Floats, zone: Bools) -> Deciding:
        vertices = self.sides.vertices
        field = largest_around(tets, von_mises, self.average)
        in_ball = field[vertices[zone]]
        along = self.along(tets, at_vertices)[~zone]
        point = counting[vertices[~zone]] if len(counting) else np.zeros_like(along)
        outside = np.zeros(len(field))
        np.maximum.at(outside, vertices[~zone], np.maximum(along, point))
        field[vertices] = outside[vertices]
        np.maximum.at(field, vertices[zone], in_ball)
        contact, averaged, resolved = (float(values.max(initial=0.0)) for values in (in_ball, along, point))
        inside = np.zeros(len(field))
        np.maximum.at(inside, vertices[zone], in_ball)
        surface_at, contact_at = (_place(tets, values) for values in (outside, inside))
        surface = _largest(averaged, resolved)
        return Deciding(field, outside, surface, contact, _largest(averaged, contact), resolved, surface_at, contact_at)


def worst(found: Sequence[Deciding]) -> Deciding:
    """The largest of several landings, place by place."""
    figures = {name: _largest(*(getattr(one, name) for one in found)) for name in ("surface", "contact", "averaged", "resolved")}
    surface_where = max(found, key=lambda one: one.surface).surface_where
    contact_where = max(found, key=lambda one: one.contact).contact_where
    field, outside = (np.max([getattr(one, name) for one in found], axis=0) for name in ("field", "outside"))
    return Deciding(field=field, outside=outside, surface_where=surface_where, contact_where=contact_where, **figures)


def _place(tets: TetMesh, values: Floats) -> Place:
    """Where the largest of values at the vertices is [mm]."""
    x, y, z = tets.vertices[np.argmax(values)]
    return float(x), float(y), float(z)


def _largest(*values: float) -> float:
    """The largest, or not a number if one is none."""
    return float(np.max(values))
