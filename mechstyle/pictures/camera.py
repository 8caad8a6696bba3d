"""Cameras of pictures: named views that fit a part."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechstyle.errors import BadInput, unknown

Floats = NDArray[np.float64]

# Azimuth from the front (towards the viewer is -y) anticlockwise seen from above, and elevation above the floor [degrees].
VIEWS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"front": (0.0, 0.0), "three_quarter": (35.0, 28.0), "side": (90.0, 0.0), "top": (0.0, 90.0), "below": (35.0, -38.0)}
)
OPENING = 24.0
"""Default opening angle over the height of a picture [degrees]."""
MARGIN = 0.06  # of a picture that is left free around a part


@dataclass(frozen=True)
class Camera:
    """A perspective camera that looks at a point, z up."""

    azimuth: float  # direction it stands in, from -y anticlockwise seen from above [degrees]
    elevation: float  # direction it stands in, above the floor [degrees]
    target: tuple[float, float, float]  # the point in the middle of the picture [mm]
    distance: float  # from the target to the camera [mm]
    field_of_view: float = OPENING  # opening angle over the height of the picture [degrees]
    aspect: float = 1.0  # width over height of the picture

    def __post_init__(self) -> None:
        """Refuse a camera that sees nothing."""
        if not (self.distance > 0 and 0 < self.field_of_view < 170 and self.aspect > 0 and -90 <= self.elevation <= 90):
            raise BadInput(f"{self}: distance and aspect must be positive, the opening 0 to 170, the elevation -90 to 90 degrees")

    @classmethod
    def fitted(cls, points: ArrayLike, azimuth: float, elevation: float, *, aspect: float = 1.0, field_of_view: float = OPENING) -> Camera:
        """The nearest camera in a direction from which all points are in the picture, 6 % of it left free on each side.

        A point (x, y, z) in camera axes around a target shifted by (s, t) is inside when |x - s| <= k (d - z) and |y - t| <= h (d - z);
        the smallest d and the shift follow from the extremes of x ± k z and y ± h z.
        """
        cloud = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        if not len(cloud) or not np.isfinite(cloud).all():
            raise BadInput("a camera cannot be fitted to no points, or to points that are not finite")
        middle = 0.5 * (cloud.min(axis=0) + cloud.max(axis=0))
        axes = _axes(azimuth, elevation)
        x, y, z = ((cloud - middle) @ axes.T).T
        high = math.tan(math.radians(field_of_view / 2)) * (1 - 2 * MARGIN)
        wide = high * aspect
        spans = [(float((u + k * z).max()), float((u - k * z).min()), k) for u, k in ((x, wide), (y, high))]
        distance = max((top - bottom) / (2 * k) for top, bottom, k in spans)
        shift = [(top + bottom) / 2 for top, bottom, _ in spans]
        near = float(z.max()) + 1e-3 * float(np.ptp(cloud, axis=0).max()) + 1e-9
        target = middle + shift[0] * axes[0] + shift[1] * axes[1]
        return cls(azimuth, elevation, (float(target[0]), float(target[1]), float(target[2])), max(distance, near), field_of_view, aspect)

    @classmethod
    def named(cls, view: str, points: ArrayLike, *, aspect: float = 1.0, field_of_view: float = OPENING) -> Camera:
        """A camera of `VIEWS`, fitted to the points [mm], shape [n, 3]."""
        if view not in VIEWS:
            raise unknown("view", view, VIEWS)
        azimuth, elevation = VIEWS[view]
        return cls.fitted(points, azimuth, elevation, aspect=aspect, field_of_view=field_of_view)

    @property
    def axes(self) -> Floats:
        """Unit vectors to the right, up, and from the target to the camera, as rows, shape [3, 3]."""
        return _axes(self.azimuth, self.elevation)

    @property
    def eye(self) -> Floats:
        """Position of the camera [mm], shape [3]."""
        return np.asarray(self.target + self.distance * self.axes[2])

    def project(self, points: ArrayLike) -> Floats:
        """Picture coordinates in [-1, 1] across the picture (y up) and depth along the axis [mm] of points [mm], shape [n, 3]."""
        x, y, z = ((np.asarray(points, dtype=np.float64) - self.eye) @ self.axes.T).T
        reach = math.tan(math.radians(self.field_of_view / 2)) * np.where(z < 0, -z, 1.0)
        return np.stack([x / (reach * self.aspect), y / reach, -z], axis=-1)

    def directions(self, width: int, height: int) -> Floats:
        """Viewing directions through the pixel centres, of depth 1, row 0 at the top, shape [height, width, 3]."""
        high = math.tan(math.radians(self.field_of_view / 2))
        x = ((2 * np.arange(width) + 1) / width - 1) * high * self.aspect
        y = (1 - (2 * np.arange(height) + 1) / height) * high
        right, up, back = self.axes
        return x[None, :, None] * right + y[:, None, None] * up - back


def _axes(azimuth: float, elevation: float) -> Floats:
    a, e = math.radians(azimuth), math.radians(elevation)
    right = np.array([math.cos(a), math.sin(a), 0.0])
    back = np.array([math.sin(a) * math.cos(e), -math.cos(a) * math.cos(e), math.sin(e)])
    return np.stack([right, np.cross(back, right), back])
