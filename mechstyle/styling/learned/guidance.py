"""Guidance of a learned style, as a loss to descend: here a drawn target, in `clip_guidance` CLIP's view of a prompt.

A guidance first draws all that is random in one iteration, then gives a loss: so that an iteration is one function of tensors.
"""

from __future__ import annotations

import zlib
from typing import Any, NamedTuple, Protocol

import torch

from mechstyle.records.mesh import Floats
from mechstyle.styling.drawn import COLOUR_WEIGHT, Target
from mechstyle.styling.learned.unit_shape import Look


class Draws(Protocol):
    """Random draws of one iteration."""

    @property
    def tensors(self) -> tuple[torch.Tensor, ...]:
        """Its tensors, always in the same order and of the same shapes."""


class NoDraws(NamedTuple):
    """Nothing is random."""

    tensors: tuple[()] = ()


class Guidance(Protocol):
    """A loss to descend, and what the style field knows of the prompt."""

    @property
    def text(self) -> torch.Tensor:
        """Embedding of the prompt, shape [text_size]."""

    def draw(self, generator: torch.Generator) -> Draws:
        """Random draws of one iteration."""

    def loss(self, look: Look, draws: Any) -> torch.Tensor:
        """Loss of a styled part, a scalar to be descended."""

    def distance(self, look: Look) -> torch.Tensor:
        """Distance of a styled part from the target, a deterministic scalar."""


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

    def draw(self, generator: torch.Generator) -> NoDraws:  # noqa: ARG002 — nothing about a target is random
        """Nothing."""
        return NoDraws()

    def loss(self, look: Look, draws: NoDraws) -> torch.Tensor:  # noqa: ARG002
        """Distance from the target."""
        return self.distance(look)

    def distance(self, look: Look) -> torch.Tensor:
        """Distance from the target."""
        relief = (look.displacement - self._displacement) / self._reference
        return self._share @ (relief**2 + COLOUR_WEIGHT * (look.colour - self._colour).square().sum(dim=1))
