"""Random crops and perspectives of rendered views, as torchvision's RandomResizedCrop and RandomPerspective draw them.

Both are one projective map of the picture plane, so a picture is sampled once. Coordinates run from -1 to 1 over the picture, x to the
right, y down; outside the picture, and outside the crop once it is seen in perspective, all is white.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import torch

from mechstyle.styling.learned.rows import blended

DISTORTION = 0.5
PERSPECTIVE_SHARE = 0.8
ASPECTS = (3.0 / 4.0, 4.0 / 3.0)
_CORNERS = torch.tensor([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


class Warps(NamedTuple):
    """Maps from an augmented picture to the rendered one; all views of one augmentation share one map.

    Attributes:
        perspective: Homographies from the augmented picture into the crop, shape [a, 3, 3].
        half_sides: Half width and height of the crop, shape [a, 2].
        centre: Centre of the crop, shape [a, 2].
    """

    perspective: torch.Tensor
    half_sides: torch.Tensor
    centre: torch.Tensor

    def to(self, device: str | torch.device) -> Warps:
        """The same maps on a device."""
        return Warps(*(part.to(device, non_blocking=True) for part in self))


def random_warps(count: int, area: float, generator: torch.Generator) -> Warps:
    """`count` random crops of a share `area` of the picture, each seen in a random perspective four times out of five.

    An aspect ratio is drawn log-uniformly from 3:4 to 4:3; a crop that would not fit is the whole picture, as torchvision falls back to.
    """
    low, high = (math.log(ratio) for ratio in ASPECTS)
    ratio = torch.exp(low + (high - low) * torch.rand(count, generator=generator))
    sides = torch.stack([(area * ratio).sqrt(), (area / ratio).sqrt()], dim=1)
    sides = torch.where((sides <= 1.0).all(dim=1, keepdim=True), sides, torch.ones_like(sides))
    centre = (1.0 - sides) * (2.0 * torch.rand(count, 2, generator=generator) - 1.0)
    moved = _CORNERS * (1.0 - DISTORTION * torch.rand(count, 4, 2, generator=generator))
    tilted = torch.rand(count, generator=generator) < PERSPECTIVE_SHARE
    moved = torch.where(tilted[:, None, None], moved, _CORNERS)
    return Warps(homographies(moved, _CORNERS.expand_as(moved)), sides, centre)


def homographies(start: torch.Tensor, end: torch.Tensor) -> torch.Tensor:
    """The projective maps, shape [a, 3, 3], that take four points `start` to `end`, both shape [a, 4, 2]."""
    (x, y), (u, v) = start.unbind(dim=2), end.unbind(dim=2)
    zero, one = torch.zeros_like(x), torch.ones_like(x)
    first = torch.stack([x, y, one, zero, zero, zero, -u * x, -u * y], dim=2)
    second = torch.stack([zero, zero, zero, x, y, one, -v * x, -v * y], dim=2)
    solved = torch.linalg.solve(torch.cat([first, second], dim=1), torch.cat([u, v], dim=1))
    return torch.cat([solved, torch.ones_like(solved[:, :1])], dim=1).view(-1, 3, 3)


def warped(images: torch.Tensor, warps: Warps) -> torch.Tensor:
    """Every augmentation of every view, shape [a · b, channels, size, size], augmentation by augmentation.

    Args:
        images: Views with values from 0 to 1, white 1, shape [b, channels, size, size].
        warps: Maps of `a` augmentations.
    """
    views, _, _, size = images.shape
    # Homogeneous coordinates of the pixel centres.
    centre = (2.0 * torch.arange(size, device=images.device, dtype=images.dtype) + 1.0) / size - 1.0
    y, x = torch.meshgrid(centre, centre, indexing="ij")
    place = torch.stack([x, y, torch.ones_like(x)], dim=2)
    projected = torch.einsum("aij,hwj->ahwi", warps.perspective, place)
    seen = projected[..., :2] / projected[..., 2:]
    inside = (seen.abs() <= 1.0).all(dim=3) & (projected[..., 2] > 0.0)
    source = seen * warps.half_sides[:, None, None] + warps.centre[:, None, None]
    # Sampled as darkness below white, because what lies outside is sampled as 0; one pixel's values in all views are one row.
    rows = (images - 1.0).permute(2, 3, 0, 1).reshape(size * size, -1)
    index, weights = _neighbours(source.flatten(0, 2), size)
    found = 1.0 + blended(rows, index, weights * inside.view(-1, 1))
    return found.view(len(inside), size, size, views, -1).permute(0, 3, 4, 1, 2).flatten(0, 1)


def _neighbours(place: torch.Tensor, size: int) -> tuple[torch.Tensor, torch.Tensor]:
    """The four pixels around places, shape [m, 2], and their weights, as linear interpolation has them, both shape [m, 4].

    Unlike `grid_sample`, sums over these have a gradient that is the same bytes whenever it is asked, on a GPU too.
    """
    pixel = (0.5 * size * (place + 1.0) - 0.5).clamp(-2.0, size + 1.0)
    number = torch.arange(4, device=place.device)
    corners = pixel.floor()[:, None] + torch.stack([number % 2, number // 2], dim=1)
    there = ((corners >= 0) & (corners < size)).all(dim=2)
    weights = (1.0 - (pixel[:, None] - corners).abs()).prod(dim=2) * there
    x, y = corners.clamp(0, size - 1).long().unbind(dim=2)
    return y * size + x, weights
