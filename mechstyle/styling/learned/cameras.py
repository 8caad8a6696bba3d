"""Cameras of the views that guide a style, in the axes of Kaolin: the part at the origin, y up."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import torch

from mechstyle.errors import BadInput


@dataclass(frozen=True)
class Cameras:
    """Cameras on a sphere that all look at the origin.

    A part that stands with z up is turned by (x, y, z) → (x, z, -y); its front, azimuth 0 of `pictures.camera`, is at azimuth π/2 here,
    and azimuths run the other way round.

    Attributes:
        elevation: Angle above the plane y = 0 [rad], shape [views].
        azimuth: Angle from +x towards +z [rad], shape [views].
        distance: From the origin [radii of the part].
        fov: Opening angle over the height of the picture [degrees].
    """

    elevation: torch.Tensor
    azimuth: torch.Tensor
    distance: float = 2.0
    fov: float = 60.0

    def __post_init__(self) -> None:
        """Refuse cameras that see nothing."""
        if self.elevation.ndim != 1 or self.elevation.shape != self.azimuth.shape or not len(self.elevation):
            shapes = f"{tuple(self.elevation.shape)} and {tuple(self.azimuth.shape)}"
            raise BadInput(f"cameras need one elevation and one azimuth for each view, not shapes {shapes}")
        if not (self.distance > 0 and 0 < self.fov < 170):
            raise BadInput(f"cameras at distance {self.distance:g} opened by {self.fov:g}°: use a distance above 0 and 0 to 170°")

    def to(self, device: str | torch.device) -> Cameras:
        """The same cameras on a device."""
        elevation, azimuth = (angle.to(device, non_blocking=True) for angle in (self.elevation, self.azimuth))
        return replace(self, elevation=elevation, azimuth=azimuth)

    def and_of(self, other: Cameras) -> Cameras:
        """These views, then another's directions at this distance and opening."""
        return replace(self, elevation=torch.cat([self.elevation, other.elevation]), azimuth=torch.cat([self.azimuth, other.azimuth]))

    @property
    def axes(self) -> torch.Tensor:
        """Unit vectors to the right, up, and from the origin to the camera, as rows, shape [views, 3, 3]."""
        e, a = self.elevation, self.azimuth
        back = torch.stack([e.cos() * a.cos(), e.sin(), e.cos() * a.sin()], dim=1)
        upright = torch.where(e.cos() < 0, -1.0, 1.0)  # beyond a pole +y stays up, so the picture turns
        right = torch.stack([upright * a.sin(), torch.zeros_like(a), -upright * a.cos()], dim=1)
        return torch.stack([right, torch.linalg.cross(back, right), back], dim=1)

    def project(self, points: torch.Tensor, size: int) -> torch.Tensor:
        """Column and row, counted from the upper left corner of a square picture, and 1 / depth of points, shape [views, n, 3].

        Args:
            points: Shape [n, 3].
            size: Pixels of the picture each way.
        """
        x, y, z = (points @ self.axes.to(points).reshape(-1, 3).T).T.reshape(len(self.elevation), 3, -1).unbind(dim=1)
        inverse = 1.0 / (self.distance - z)
        reach = inverse * (0.5 * size / math.tan(math.radians(0.5 * self.fov)))
        return torch.stack([0.5 * size + x * reach, 0.5 * size - y * reach, inverse], dim=2)


def random_views(count: int, center: tuple[float, float], std: float, generator: torch.Generator) -> Cameras:
    """Views around a centre, the first of them the centre itself, as in the published run of X-Mesh (Ma et al. 2023).

    Args:
        count: Views, at least 1.
        center: Elevation and azimuth [rad].
        std: The deviation is π / std in elevation and 2π / std in azimuth; 4 in the published run.
        generator: Of the CPU, so that views are the same on every device.
    """
    if count < 1 or std <= 0:
        raise BadInput(f"{count} views with a spread of π/{std:g} cannot be drawn: use at least one view and a positive number")
    offsets = torch.randn(2, count - 1, generator=generator) * torch.tensor([[math.pi / std], [2.0 * math.pi / std]])
    around = torch.tensor(center)[:, None] + torch.cat([torch.zeros(2, 1), offsets], dim=1)
    return Cameras(around[0], around[1])
