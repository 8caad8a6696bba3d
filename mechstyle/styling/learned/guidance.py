"""Guidance of a learned style, as a loss to descend: a drawn target, or CLIP's view of a prompt.

A guidance first draws all that is random in one iteration, then gives a loss: so that an iteration is one function of tensors.

By CLIP rendered views are to look like the prompt, as in the published run of X-Mesh (Ma et al. 2023). Their random crops and perspectives
are those of torchvision's RandomResizedCrop and RandomPerspective, both one projective map of the picture plane, so that a picture is
sampled once. Coordinates run from -1 to 1 over the picture, x to the right, y down; outside the picture, and outside the crop once it is
seen in perspective, all is white.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from typing import Any, NamedTuple

import torch
from torch.nn import functional

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawn import COLOUR_WEIGHT, Target
from mechstyle.styling.learned.clip import Clip
from mechstyle.styling.learned.renderer import Cameras, random_views
from mechstyle.styling.learned.tensors import blended
from mechstyle.styling.learned.unit_shape import Look


class NoDraws(NamedTuple):
    """Nothing is random."""

    tensors: tuple[()] = ()


class TargetGuidance:
    """The drawn target of an offline style: Σ A_i [((s_i − s*_i)/s_ref)² + 4 ‖c_i − c*_i‖²] / Σ A_i, as in `drawn`.

    The field knows the prompt by a random embedding that only the prompt decides.
    """

    def __init__(self, target: Target, areas: Floats, prompt: str, *, text_size: int = 512, device: str = "cpu") -> None:
        share = torch.tensor(areas / areas.sum(), dtype=torch.float32)
        displacement, colour = torch.tensor(target.displacement), torch.tensor(target.colour)
        mean_square = float(share @ displacement**2)
        self._reference = mean_square**0.5 if mean_square > 0 else 1.0
        self._share, self._displacement, self._colour = (part.to(device) for part in (share, displacement, colour))
        generator = torch.Generator().manual_seed(zlib.crc32(prompt.encode()))
        self.text = torch.randn(text_size, generator=generator).to(device)

    def draw(self, _generator: torch.Generator) -> NoDraws:
        """Nothing about a target is random."""
        return NoDraws()

    def loss(self, look: Look, _draws: Any) -> torch.Tensor:
        """Distance from the target, a scalar to be descended."""
        return self.distance(look)

    def distance(self, look: Look) -> torch.Tensor:
        """Distance from the target."""
        relief = (look.displacement - self._displacement) / self._reference
        return self._share @ (relief**2 + COLOUR_WEIGHT * (look.colour - self._colour).square().sum(dim=1))


VIEWS = 5
FRONT = (0.0, 0.0)
"""Centre of the views: elevation and azimuth [rad]."""
SPREAD = 4.0
"""The views' deviation is π/4 in elevation and 2π/4 in azimuth."""
COLOUR_CROP = 0.4
SHAPE_CROP = 0.1
"""Share of the picture in a close look at the coloured part, and at the grey one."""
GREY = 0.5
_JUDGED_ELEVATION = 0.3

Render = Callable[[torch.Tensor, torch.Tensor, Cameras], Any]


class ClipDraws(NamedTuple):
    """Random draws of one iteration of CLIP guidance."""

    cameras: Cameras  # views of the coloured part
    warps: Warps  # augmentations of these: one of the whole picture, then close looks
    grey_cameras: Cameras  # other views, of the part without its colours
    grey_warps: Warps  # augmentations of these, closer looks

    def to(self, device: str) -> ClipDraws:
        """The same on a device."""
        return ClipDraws(self.cameras.to(device), self.warps.to(device), self.grey_cameras.to(device), self.grey_warps.to(device))

    @property
    def tensors(self) -> tuple[torch.Tensor, ...]:
        """Elevations and azimuths, then the maps, of both sets of views."""
        views = (self.cameras, self.grey_cameras)
        return (*(angle for each in views for angle in (each.elevation, each.azimuth)), *self.warps, *self.grey_warps)


class ClipGuidance:
    """CLIP's likeness between a prompt and rendered views.

    The loss is −Σ_a cos(mean over the views of E(augmentation a), E(prompt)) over one augmentation of the whole coloured picture, `crops`
    close looks at it, and `crops` closer looks at the part in plain grey, which tell the shape apart from the paint. All pictures
    of one iteration are embedded in one batch: 5 · (1 + 2 · crops).
    """

    def __init__(self, clip: Clip, prompt: str, render: Render, *, crops: int = 4, device: str = "cpu") -> None:
        self._clip, self._render, self._crops, self._device = clip, render, crops, device
        self.text = clip.text(prompt)
        around = torch.arange(VIEWS, device=device) * (2.0 * torch.pi / VIEWS)
        self._judged = Cameras(torch.full_like(around, _JUDGED_ELEVATION), around)

    def draw(self, generator: torch.Generator) -> ClipDraws:
        """Two sets of views and their augmentations, the same on every device."""
        cameras, grey_cameras = (random_views(VIEWS, FRONT, SPREAD, generator) for _ in range(2))
        whole, close = random_warps(1, 1.0, generator), random_warps(self._crops, COLOUR_CROP, generator)
        closer = random_warps(self._crops, SHAPE_CROP, generator)
        both = Warps(*(torch.cat(parts) for parts in zip(whole, close, strict=True)))
        return ClipDraws(cameras, both, grey_cameras, closer).to(self._device)

    def loss(self, look: Look, draws: Any) -> torch.Tensor:
        """Minus the sum of the cosines, from −(1 + 2 · crops) upwards."""
        cameras = draws.cameras.and_of(draws.grey_cameras)
        colours = torch.stack([look.colour, torch.full_like(look.colour, GREY)]).repeat_interleave(VIEWS, dim=0)
        coloured, plain = self._render(look.positions, colours, cameras).image.split(VIEWS)
        pictures = torch.cat([warped(coloured, draws.warps), warped(plain, draws.grey_warps)])
        return -self._likeness(pictures).sum()

    def distance(self, look: Look) -> torch.Tensor:
        """1 − cosine between the prompt and the mean of five views around the part, slightly from above."""
        return 1.0 - self._likeness(self._render(look.positions, look.colour, self._judged).image)[0]

    def _likeness(self, pictures: torch.Tensor) -> torch.Tensor:
        """Cosine between the prompt and the mean embedding of each group of views, shape [augmentations]."""
        embedded = self._clip.pictures(pictures)
        return functional.cosine_similarity(embedded.view(-1, VIEWS, embedded.shape[1]).mean(dim=1), self.text[None], dim=1)


Draws = NoDraws | ClipDraws
"""Random draws of one iteration: tensors, always in the same order and of the same shapes."""
Guidance = TargetGuidance | ClipGuidance
"""A loss to descend, and what the style field knows of the prompt: its embedding `text`, shape [text_size]."""
DISTORTION = 0.5
PERSPECTIVE_SHARE = 0.8
ASPECTS = (3.0 / 4.0, 4.0 / 3.0)
_CORNERS = torch.tensor([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


class Warps(NamedTuple):
    """Maps from an augmented picture to the rendered one; all views of one augmentation share one map."""

    perspective: torch.Tensor  # homographies from the augmented picture into the crop, shape [a, 3, 3]
    half_sides: torch.Tensor  # half width and height of the crop, shape [a, 2]
    centre: torch.Tensor  # centre of the crop, shape [a, 2]

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
