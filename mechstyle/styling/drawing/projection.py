"""How a flat picture lies on a part: from one side, from the six sides of a box, or around an upright axis.

Everything that decides where it lies is worked out once, on the part's own surface; `PlacedPicture` looks it up at any place near it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mechstyle.records.mesh import Floats, SurfaceMesh
from mechstyle.records.regions import ENDS
from mechstyle.styling.drawing.charts import box_axes, is_prismatic
from mechstyle.styling.drawing.colours import smoothstep
from mechstyle.styling.drawing.raster import Raster, Sample

_SHARPNESS = 6.0  # power of the cosine by which sides of a box share a place: higher blends over less
_GLANCING, _FACING = 0.2, 0.45  # cosines between which a picture thrown from one side fades out, where it would be drawn out long
_UPRIGHT = 0.5  # least horizontal part of the normal of what goes around an axis
_ROUNDS = 8
IN_DOUBT = ("front", "top", "back", "left", "right", "bottom")
"""Of two ends that show as much of a part the one that comes first is looked at."""
_FILLED = 0.6  # of a face that one picture takes unasked
_WORTH = 0.05  # least share of the surface that a face must have to say how large a picture fits


class Layer(NamedTuple):
    """A flat picture on a surface, at some places."""

    u: Floats  # to the right from the middle of the picture [widths], shape [n]
    v: Floats  # upwards from its middle [heights], shape [n]
    share: Floats  # how much of what is seen there is of this layer, shape [n]


@dataclass(frozen=True, eq=False)
class Side:
    """One side to look at a part from: axes to the right, upwards and outwards as rows, and the middle of the picture [mm]."""

    axes: Floats
    middle: Floats

    def seen(self, points: Floats, width: float, aspect: float) -> tuple[Floats, Floats]:
        """Places in the picture of points, shape [n, 3]."""
        right, up = (points - self.middle) @ self.axes[0], (points - self.middle) @ self.axes[1]
        return right / width, up / (width * aspect)


@dataclass(frozen=True, eq=False)
class BoxProjection:
    """From all six sides of a box; on slanted places those that face them share. The width is that of the picture on the part [mm]."""

    sides: tuple[Side, Side, Side]
    width: float
    aspect: float
    notes: tuple[str, ...] = ()

    def layers(self, points: Floats, normals: Floats) -> list[Layer]:
        """The layers at points [mm] with unit normals, shapes [n, 3]; their shares add up to 1 at most."""
        facing = np.stack([normals @ side.axes[2] for side in self.sides])
        weight = np.abs(facing) ** _SHARPNESS
        share = weight / np.maximum(weight.sum(axis=0), 1e-12)
        layers = []
        for side, cosine, part in zip(self.sides, facing, share, strict=True):
            u, v = side.seen(points, self.width, self.aspect)
            layers.append(Layer(np.where(cosine < 0.0, -u, u), v, part))
        return layers


@dataclass(frozen=True, eq=False)
class PlanarProjection:
    """From one side; it fades out where the surface turns away."""

    side: Side
    width: float
    aspect: float
    notes: tuple[str, ...] = ()

    def layers(self, points: Floats, normals: Floats) -> list[Layer]:
        """The layer at points, as of `BoxProjection`."""
        return [Layer(*self.side.seen(points, self.width, self.aspect), smoothstep(_GLANCING, _FACING, normals @ self.side.axes[2]))]


@dataclass(frozen=True, eq=False)
class AroundProjection:
    """Around an upright axis, a whole number of times where it is repeated; lids and floors are seen from above."""

    axis: Floats  # x and y of the axis [mm]
    radius: float  # at which the picture is as wide as asked for [mm]
    middle: float  # height of its middle [mm]
    width: float
    aspect: float
    lids: Side | None  # what is seen from above; None for nothing
    notes: tuple[str, ...] = ()

    def layers(self, points: Floats, normals: Floats) -> list[Layer]:
        """The layers at points, as of `BoxProjection`."""
        away = points[:, :2] - self.axis
        angle = np.arctan2(away[:, 0], -away[:, 1])  # 0 in front, growing to the right
        outside = np.einsum("ij,ij->i", away, normals[:, :2]) >= 0.0
        u = np.where(outside, angle, -angle) * self.radius / self.width
        upright = smoothstep(_UPRIGHT - 0.2, _UPRIGHT + 0.2, np.linalg.norm(normals[:, :2], axis=1))
        sides = Layer(u, (points[:, 2] - self.middle) / (self.width * self.aspect), upright)
        if self.lids is None:
            return [sides]
        across, up = self.lids.seen(points, self.width, self.aspect)
        return [sides, Layer(np.where(normals[:, 2] < 0.0, -across, across), up, 1.0 - upright)]


Projection = BoxProjection | PlanarProjection | AroundProjection
"""A way to lay a picture on a part."""


def box_projection(mesh: SurfaceMesh, width: float | None, usual: float, aspect: float, *, repeated: bool) -> BoxProjection:
    """Lay a picture, repeated or not, of an aspect height over width on all sides of a part.

    Its width [mm] is by default `usual` if it is repeated, else what fits the narrowest side.
    """
    x, y, z = _axes(mesh)
    frames = (np.stack([y, z, x]), np.stack([-x, z, y]), np.stack([x, y, z]))
    sides = [Side(axes, _middle(mesh, axes)) for axes in frames]
    if width is None and repeated:
        width = usual
    elif width is None:
        areas = mesh.face_areas / mesh.face_areas.sum()
        share = [float(areas[np.abs(mesh.face_normals @ side.axes[2]) > np.sqrt(0.5)].sum()) for side in sides]
        width = min(_fitting(mesh, side, aspect) for side, one in zip(sides, share, strict=True) if one >= min(_WORTH, max(share)))
    return BoxProjection((sides[0], sides[1], sides[2]), width, aspect)


def planar_projection(
    mesh: SurfaceMesh, width: float | None, usual: float, aspect: float, *, repeated: bool, end: str = ""
) -> PlanarProjection:
    """Lay a picture on one side of a part, one of ENDS or, by default, the one that shows most; other arguments as above."""
    named = end or max(IN_DOUBT, key=lambda one: round(_shown(mesh, _frame(mesh, one)), 3))
    axes = _frame(mesh, named)
    side = Side(axes, _middle(mesh, axes, facing=True))
    if width is None:
        width = usual if repeated else _fitting(mesh, side, aspect)
    return PlanarProjection(side, width, aspect, () if end else (f"the picture is thrown from the {named}, which shows most of the part",))


def around_projection(mesh: SurfaceMesh, width: float | None, usual: float, aspect: float, *, repeated: bool) -> AroundProjection:
    """Lay a picture around a part, a whole number of times if it is repeated; arguments as above."""
    axis = _axis(mesh)
    away = np.linalg.norm(mesh.vertices[:, :2] - axis, axis=1)
    outward = np.einsum("ij,ij->i", mesh.vertices[:, :2] - axis, mesh.vertex_normals[:, :2]) > _UPRIGHT * np.maximum(away, 1e-9)
    radius = max(_median(away[outward], mesh.vertex_areas[outward]) if outward.any() else float(np.median(away)), 1e-6)
    low, high = mesh.vertices[:, 2].min(), mesh.vertices[:, 2].max()
    middle = 0.5 * float(low + high)
    if not repeated:
        fits = _FILLED * min(2.0 * radius, float(high - low) / aspect)
        return AroundProjection(axis, radius, middle, fits if width is None else width, aspect, None)
    asked = usual if width is None else width
    times = max(round(2.0 * np.pi * radius / asked), 1)
    fitted = float(2.0 * np.pi * radius / times)
    fitted_note = (f"{times} pictures go around the part, {fitted:.3g} mm wide each instead of {asked:.3g} mm",)
    lids = Side(np.eye(3), np.array([*axis, 0.0]))
    return AroundProjection(axis, radius, middle, fitted, aspect, lids, fitted_note if abs(fitted / asked - 1.0) > 0.02 else ())


def _axes(mesh: SurfaceMesh) -> Floats:
    """Those of the box that a part is like, or as it stands: a round part has no corners to be turned by."""
    return box_axes(mesh) if is_prismatic(mesh) else np.eye(3)


def _frame(mesh: SurfaceMesh, end: str) -> Floats:
    """Axes to the right, upwards and outwards of a part seen from one of its ends."""
    axes = _axes(mesh)
    axis, sign = ENDS[end]
    outwards = np.eye(3)[axis] * sign
    # The nearest axis of the box: it is turned by at most 45° about z.
    nearest = int(np.abs(axes @ outwards).argmax())
    outwards = axes[nearest] * np.sign(axes[nearest] @ outwards)
    up = axes[1] if axis == 2 else axes[2]
    return np.stack([np.cross(up, outwards), up, outwards])


def _shown(mesh: SurfaceMesh, axes: Floats) -> float:
    """Share of the surface that faces a side."""
    areas = mesh.face_areas
    return float(areas[mesh.face_normals @ axes[2] > _FACING].sum() / areas.sum())


def _middle(mesh: SurfaceMesh, axes: Floats, *, facing: bool = False) -> Floats:
    """Middle of the box around a part, or around what of it faces outwards [mm]."""
    shown = mesh.vertices
    if facing and (turned := mesh.vertex_normals @ axes[2] > _FACING).any():
        shown = shown[turned]
    there = shown @ axes.T
    return np.asarray(0.5 * (there.min(axis=0) + there.max(axis=0)) @ axes)


def _fitting(mesh: SurfaceMesh, side: Side, aspect: float) -> float:
    """Width of a picture that takes most of what faces a side, or its opposite [mm]."""
    turned = np.abs(mesh.vertex_normals @ side.axes[2]) > _FACING
    there = (mesh.vertices[turned] if turned.any() else mesh.vertices) @ side.axes[:2].T
    across, up = np.ptp(there, axis=0)
    return _FILLED * max(float(min(across, up / aspect)), 1e-6)


def _axis(mesh: SurfaceMesh) -> Floats:
    """Place, x and y, of the upright axis that the normals meet best, by area; the middle of the part if they meet none [mm]."""
    centres = mesh.vertices[mesh.faces].mean(axis=1)[:, :2]
    flat = mesh.face_normals[:, :2]
    level = np.linalg.norm(flat, axis=1)
    across = np.stack([-flat[:, 1], flat[:, 0]], axis=1) / np.maximum(level, 1e-9)[:, None]
    weight = mesh.face_areas * (level > _UPRIGHT)
    middle = 0.5 * (mesh.vertices[:, :2].min(axis=0) + mesh.vertices[:, :2].max(axis=0))
    axis, size = middle, max(float(mesh.extents[:2].max()), 1e-9)
    for _ in range(_ROUNDS):  # of least squares reweighted towards least distances, which a handle hardly moves
        miss = np.abs(np.einsum("ij,ij->i", axis - centres, across))
        pull = weight / (miss + 0.01 * size)
        system = np.einsum("i,ij,ik->jk", pull, across, across) + 1e-6 * pull.sum() * np.eye(2)
        wanted = np.einsum("i,ij,ik,ik->j", pull, across, across, centres) + 1e-6 * pull.sum() * middle
        axis = np.linalg.solve(system, wanted) if pull.any() else middle
    return np.asarray(np.clip(axis, mesh.vertices[:, :2].min(axis=0), mesh.vertices[:, :2].max(axis=0)))


def _median(values: Floats, weights: Floats) -> float:
    order = np.argsort(values)
    return float(values[order][np.searchsorted(np.cumsum(weights[order]), 0.5 * weights.sum())])


@dataclass(frozen=True, eq=False)
class PlacedPicture:
    """A picture on a part."""

    raster: Raster  # the picture
    projection: Projection  # how it lies on the part
    repeated: bool  # whether it is repeated
    raised: bool  # whether its light and dark become relief
    side: str  # where the relief goes from the surface, one of SIDES
    coloured: bool  # whether its colours are taken

    def seen(self, points: Floats, normals: Floats, footprint: float) -> Sample:
        """What it shows at points [mm] with unit normals, shapes [n, 3], each of which stands for a place of `footprint` [mm]."""
        height, colour, cover = np.zeros(len(points)), np.zeros((len(points), 3)), np.zeros(len(points))
        for layer in self.projection.layers(points, normals):
            here = np.flatnonzero(layer.share > 1e-4)
            shown = self.raster.at(layer.u[here], layer.v[here], footprint / self.projection.width, repeated=self.repeated)
            part = layer.share[here] * shown.cover
            height[here] += part * shown.height
            colour[here] += part[:, None] * shown.colour
            cover[here] += part
        whole = np.maximum(cover, 1e-9)
        return Sample(height / whole, colour / whole[:, None], np.minimum(cover, 1.0))
