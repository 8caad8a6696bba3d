"""Guidance by CLIP: rendered views are to look like the prompt, as in the published run of X-Mesh (Ma et al. 2023)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import torch
from torch.nn import functional

from mechstyle.styling.learned.augment import Warps, random_warps, warped
from mechstyle.styling.learned.clip import Clip
from mechstyle.styling.learned.renderer import Cameras, random_views
from mechstyle.styling.learned.unit_shape import Look

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


class Draws(NamedTuple):
    """Random draws of one iteration of CLIP guidance.

    Attributes:
        cameras: Views of the coloured part.
        warps: Augmentations of these: one of the whole picture, then close looks.
        grey_cameras: Other views, of the part without its colours.
        grey_warps: Augmentations of these, closer looks.
    """

    cameras: Cameras
    warps: Warps
    grey_cameras: Cameras
    grey_warps: Warps

    def to(self, device: str) -> Draws:
        """The same on a device."""
        return Draws(self.cameras.to(device), self.warps.to(device), self.grey_cameras.to(device), self.grey_warps.to(device))

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

    def draw(self, generator: torch.Generator) -> Draws:
        """Two sets of views and their augmentations, the same on every device."""
        cameras, grey_cameras = (random_views(VIEWS, FRONT, SPREAD, generator) for _ in range(2))
        whole, close = random_warps(1, 1.0, generator), random_warps(self._crops, COLOUR_CROP, generator)
        closer = random_warps(self._crops, SHAPE_CROP, generator)
        both = Warps(*(torch.cat(parts) for parts in zip(whole, close, strict=True)))
        return Draws(cameras, both, grey_cameras, closer).to(self._device)

    def loss(self, look: Look, draws: Draws) -> torch.Tensor:
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
