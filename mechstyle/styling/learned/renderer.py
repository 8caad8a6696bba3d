"""Pictures of a part that can be differentiated by its vertices and colours: Warp decides what is seen, torch computes how it looks.

Light is that of X-Mesh (Ma et al. 2023): the first spherical harmonics with coefficients 1 (Kaolin's `spherical_harmonic_lighting`), in
the axes of each camera. Normals are smooth, because the light of flat ones jumps where faces meet; weights are correct in perspective;
outlines fade, so that gradients know where the part ends. Cameras have the axes of Kaolin: the part at the origin, y up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

from mechstyle.errors import BadInput, MissingPiece

try:
    import torch
    from torch.nn import functional
except ModuleNotFoundError as error:
    raise MissingPiece("rendering with gradients needs torch: install it with `pip install 'mechstyle[clip]'`") from error

from mechstyle.styling.learned.antialias import antialiased
from mechstyle.styling.learned.tensors import added, edges_of, face_of, nearest_faces, taken

__all__ = ["Cameras", "Rendered", "Renderer", "random_views"]

AMBIENT = 0.28209479177387814  # Y_00 = 1 / (2 √π)
DIRECTED = 0.4886025119029199  # Y_1m = √(3 / 4π) times x, y or z
BACKGROUND = 1.0
LEAST_AREA = 1e-2
"""Of the mean of all faces, or around all vertices, below which a face or a normal says nothing but noise: its gradient, which goes with
1 / area, would drown all others."""
LEAST_BLEND = 1e-3
"""Length of the sum of unit normals below which they cancel each other."""


@dataclass(frozen=True, eq=False)
class Rendered:
    """Views of a part."""

    image: torch.Tensor  # RGB in [0, 1] on white, row 0 at the top, shape [views, 3, size, size]
    coverage: torch.Tensor  # share of each pixel the part covers, shape [views, 1, size, size]; 0 or 1 without antialiasing


class Renderer:
    """Renders views of surfaces that share their faces.

    Args:
        faces: Vertex indices, anticlockwise seen from outside, shape [face_count, 3], any integers.
        size: Pixels of a picture each way.
        antialias: Whether outlines fade and have gradients.
        device: Of all tensors, "cpu" or "cuda".
        static: Whether no shape depends on what is seen, as CUDA graphs need; by default on CUDA only, since it costs a CPU time.

    Raises:
        BadInput: Faces or a size that cannot be drawn.
    """

    def __init__(
        self, faces: torch.Tensor, size: int = 224, *, antialias: bool = True, device: str | torch.device = "cpu",
        static: bool | None = None,
    ) -> None:  # fmt: skip
        if faces.ndim != 2 or faces.shape[1] != 3 or not len(faces) or faces.is_floating_point():
            raise BadInput(f"faces must be integers of shape [face_count, 3], not {faces.dtype} of shape {tuple(faces.shape)}")
        if not 1 <= size <= 4096:
            raise BadInput(f"views of {size} x {size} pixels cannot be rendered: use 1 to 4096")
        self._faces = faces.to(device=device, dtype=torch.int32).contiguous()
        self._corners = self._faces.long().T.contiguous()
        self._least, self._most = int(faces.min()), int(faces.max())
        self._size = size
        self._edges = edges_of(self._faces) if antialias else None
        self._static = self._faces.is_cuda if static is None else static
        self._empty = torch.tensor([BACKGROUND, BACKGROUND, BACKGROUND, 0.0], device=device)

    def __call__(self, positions: torch.Tensor, colours: torch.Tensor, cameras: Cameras) -> Rendered:
        """Every view of a surface.

        Args:
            positions: Vertices in the unit sphere, y up, shape [n, 3], float32 or float64.
            colours: Display RGB, brought to [0, 1], shape [n, 3], or [views, n, 3] if views differ in it, of the same type.
            cameras: The views.

        Raises:
            BadInput: Shapes that do not fit each other or the faces.
        """
        self._check(positions, colours, len(cameras.elevation))
        axes = cameras.axes.to(positions)
        normals, steady = self._normals(positions)
        pixels = cameras.project(positions, self._size)
        buffer = nearest_faces(pixels, self._faces, self._size, self._size)
        surface = torch.cat([pixels, colours.clamp(0.0, 1.0).expand_as(pixels), normals.expand_as(pixels)], dim=2)
        light = axes.sum(dim=1)
        picture = self._shaded(surface, steady, light, face_of(buffer).view(-1))
        if self._edges is not None:
            look = partial(_smooth_look, light)
            picture = antialiased(picture, surface, self._edges, buffer, look, static=self._static)
        views = picture.view(4, -1, self._size, self._size).transpose(0, 1)
        return Rendered(views[:, :3], views[:, 3:])

    def _check(self, positions: torch.Tensor, colours: torch.Tensor, views: int) -> None:
        if positions.ndim != 2 or positions.shape[1] != 3 or colours.shape not in {positions.shape, (views, *positions.shape)}:
            shapes = f"{tuple(positions.shape)} and {tuple(colours.shape)}"
            raise BadInput(f"positions and the colours of a view must both have shape [vertex_count, 3], not {shapes}")
        if not 0 <= self._least <= self._most < len(positions):
            raise BadInput(f"the faces name vertices {self._least} to {self._most}, but there are {len(positions)} positions")

    def _normals(self, positions: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Unit normals of the vertices, by area, shape [n, 3], and which faces have an area."""
        a, b, c = taken(positions, self._corners)
        across = torch.linalg.cross(b - a, c - a)
        areas = across.detach().norm(dim=1)
        steady = areas >= LEAST_AREA * areas.mean()
        across = _held(across, ~steady[:, None])
        across = added(across.repeat(3, 1), self._corners.reshape(-1), len(positions))
        return _steady_unit(across, LEAST_AREA * across.detach().norm(dim=1).mean()), steady

    def _shaded(self, surface: torch.Tensor, steady: torch.Tensor, light: torch.Tensor, face: torch.Tensor) -> torch.Tensor:
        """RGB and coverage of all pixels, shape [4, views · size²], that see these faces (-1 for none) under one light per view."""
        count = self._size**2
        pixel = torch.arange(len(face), device=face.device) if self._static else (face >= 0).nonzero()[:, 0]
        seen = face[pixel] >= 0
        shown = torch.where(seen, face[pixel], pixel % len(self._faces))  # a dummy face, spread: a single one would serialise the adds
        view = pixel // count
        corners = taken(surface.flatten(0, 1), self._corners.index_select(1, shown) + view * surface.shape[1])
        place, beside = corners.split([2, corners.shape[-1] - 2], dim=-1)
        # Twice the areas [pixels²] that pixel centres span with each corner's opposite side, shape [3, k].
        x, y = (pixel % count % self._size).to(corners) + 0.5, (pixel % count // self._size).to(corners) + 0.5
        (ax, ay), (bx, by), (cx, cy) = (corner.unbind(dim=1) for corner in place)
        ax, bx, cx, ay, by, cy = ax - x, bx - x, cx - x, y - ay, y - by, y - cy
        areas = torch.stack([bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx])
        samples = _smooth_look(light, beside, _held(areas, ~steady.index_select(0, shown)), view)
        empty = self._empty.to(surface)
        if self._static:
            return torch.where(seen[:, None], samples, empty).T.contiguous()
        return empty.repeat(len(face), 1).index_copy(0, pixel, samples).T.contiguous()


def _smooth_look(light: torch.Tensor, corners: torch.Tensor, weights: torch.Tensor, view: torch.Tensor) -> torch.Tensor:
    """RGB and coverage, shape [k, 4], of points between vertices under one light per view, shape [views, 3]; see `antialias.Look`.

    The corners hold 1 / depth, colour and normal of the vertices, shape [r, k, 7]; their weights in the picture, in any unit, have shape
    [r, k].
    """
    inverse_depth, look = corners.split([1, 6], dim=2)
    # In space, not in the picture; a triangle may be so thin that rounding puts the pixel outside, and they stay between 0 and 1 even so.
    positive = (weights[..., None] * inverse_depth).clamp(min=1e-20)
    colour, normal = ((positive / positive.sum(dim=0)) * look).sum(dim=0).split(3, dim=1)
    brightness = AMBIENT + DIRECTED * (_steady_unit(normal, LEAST_BLEND) * light.index_select(0, view)).sum(dim=1, keepdim=True)
    return torch.cat([(colour * brightness).clamp(0.0, 1.0), torch.ones_like(brightness)], dim=1)


def _steady_unit(vectors: torch.Tensor, least: float | torch.Tensor) -> torch.Tensor:
    """Vectors scaled to length 1, shape [k, 3]; what is shorter than `least` gets no gradient, since that goes with 1 / length."""
    return functional.normalize(_held(vectors, vectors.detach().norm(dim=1, keepdim=True) < least), dim=1)


def _held(values: torch.Tensor, where: torch.Tensor) -> torch.Tensor:
    """The values, without gradient in some places."""
    return torch.where(where, values.detach(), values)


@dataclass(frozen=True)
class Cameras:
    """Cameras on a sphere that all look at the origin.

    A part that stands with z up is turned by (x, y, z) → (x, z, -y); its front, azimuth 0 of `pictures.camera`, is at azimuth π/2 here,
    and azimuths run the other way round.
    """

    elevation: torch.Tensor  # angle above the plane y = 0 [rad], shape [views]
    azimuth: torch.Tensor  # angle from +x towards +z [rad], shape [views]
    distance: float = 2.0  # from the origin [radii of the part]
    fov: float = 60.0  # opening angle over the height of the picture [degrees]

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
    """Views around a centre (elevation, azimuth [rad]), the first the centre itself, as in the published run of X-Mesh (Ma et al. 2023).

    The deviation is π / std in elevation and 2π / std in azimuth. The generator is one of the CPU, so that views are the same on every
    device.
    """
    if count < 1 or std <= 0:
        raise BadInput(f"{count} views with a spread of π/{std:g} cannot be drawn: use at least one view and a positive number")
    offsets = torch.randn(2, count - 1, generator=generator) * torch.tensor([[math.pi / std], [2.0 * math.pi / std]])
    around = torch.tensor(center)[:, None] + torch.cat([torch.zeros(2, 1), offsets], dim=1)
    return Cameras(around[0], around[1])
