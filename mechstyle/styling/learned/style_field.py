"""The X-Mesh style field: a coordinate network that gives every vertex a colour and a displacement (Ma et al. 2023).

Written from the published description, not from its code. Names in the state dict, with the sizes of the published network:

    features.frequencies       B [3, 256], a buffer: restoring the network restores what it was trained on
    base.I.linear, base.I.norm I = 0 … 4: 515 → 256, then 256 → 256
    attention.G.S.generator    G = channel | spatial, S = narrow | widen: text embedding [512] → U [(in + 1) · 30]
    attention.G.S.basis        V [30, out]
    colour.I, displacement.I   I = 0, 1 blocks as in the base; I = 2 the last linear map, zero at first

The rest of this room imports torch only through modules such as this one, which are loaded when they are wanted.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import torch
from torch import nn
from torch.nn import functional

WIDTH = 256
BASE_BLOCKS = 5
HEAD_BLOCKS = 2
FREQUENCIES = 256
SIGMA = 12.0
"""Deviation of the Fourier frequencies over standardised coordinates, as in the published run."""
REDUCTION = 8
RANK = 30


class FourierFeatures(nn.Module):
    """γ(x) = [x, sin 2πxB, cos 2πxB] with B ~ N(0, σ²) (Tancik et al. 2020)."""

    def __init__(self, sigma: float) -> None:
        super().__init__()
        self.register_buffer("frequencies", sigma * torch.randn(3, FREQUENCIES))

    def forward(self, points: torch.Tensor) -> torch.Tensor:
        """Features, shape [n, 515], of points, shape [n, 3]."""
        phase = 2.0 * torch.pi * points @ self.frequencies
        return torch.cat([points, phase.sin(), phase.cos()], dim=1)


class Block(nn.Module):
    """Linear, then ReLU, then layer normalisation."""

    def __init__(self, size: int) -> None:
        super().__init__()
        self.linear = nn.Linear(size, WIDTH)
        self.norm = nn.LayerNorm(WIDTH)

    def forward(self, values: torch.Tensor, before: nn.LayerNorm | None = None) -> torch.Tensor:
        """Values, shape [n, 256], normalised but not yet scaled and shifted, of values as `scaled` takes them."""
        return functional.layer_norm(scaled(self.linear, values, before).relu(), (WIDTH,))


def scaled(linear: nn.Linear, values: torch.Tensor, norm: nn.LayerNorm | None) -> torch.Tensor:
    """A linear map of values that a normalisation has still to scale and shift: in its weights, which are fewer than the values."""
    if norm is None:
        return linear(values)
    return functional.linear(values, linear.weight * norm.weight, linear.bias + linear.weight @ norm.bias)


class DynamicLinear(nn.Module):
    """A linear map whose weights the text decides: [W; b] = U(text) V, with U one linear map of the text embedding."""

    def __init__(self, text_size: int, size: int, out: int) -> None:
        super().__init__()
        self.generator = nn.Linear(text_size, (size + 1) * RANK)
        self.basis = nn.Parameter(0.0 * torch.randn(RANK, out))  # zero, but drawn: what is drawn after it stays the same

    def forward(self, values: torch.Tensor, text: torch.Tensor) -> torch.Tensor:
        """Values, shape [n, out], of values, shape [n, size], under a text embedding."""
        map_and_bias = self.generator(text).view(-1, RANK) @ self.basis
        return torch.addmm(map_and_bias[-1], values, map_and_bias[:-1])


class Gate(nn.Module):
    """A perceptron of one narrow hidden layer with weights made from the text."""

    def __init__(self, text_size: int) -> None:
        super().__init__()
        self.narrow = DynamicLinear(text_size, WIDTH, WIDTH // REDUCTION)
        self.widen = DynamicLinear(text_size, WIDTH // REDUCTION, WIDTH)

    def forward(self, values: torch.Tensor, text: torch.Tensor) -> torch.Tensor:
        """Gate values before the sigmoid, shape [n, 256]."""
        return self.widen(self.narrow(values, text).relu(), text)


class TextGuidedAttention(nn.Module):
    """TDAM: features scaled per channel, then per point, by gates that the text generates.

    V starts at zero as in the released code. The gradient of the narrow map is then zero for ever, so the gates depend on the text alone
    and learn a constant per channel.
    """

    def __init__(self, text_size: int) -> None:
        super().__init__()
        self.channel = Gate(text_size)
        self.spatial = Gate(text_size)

    def forward(self, values: torch.Tensor, text: torch.Tensor) -> torch.Tensor:
        """Values scaled by both gates, shape [n, 256]."""
        values = values * self.channel(values, text).mean(dim=0, keepdim=True).sigmoid()
        return values * self.spatial(values, text).mean(dim=1, keepdim=True).sigmoid()


class StyleField(nn.Module):
    """Colour and displacement, before their bounds, at points of a part under a text embedding.

    Args:
        text_size: Length of the text embedding; 512 for CLIP ViT-B/32.
        seed: Decides the initial weights and B, whatever torch's global generator has been used for.
    """

    def __init__(self, text_size: int = 512, *, seed: int = 0) -> None:
        super().__init__()
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            self.features = FourierFeatures(SIGMA)
            sizes = [3 + 2 * FREQUENCIES, *[WIDTH] * (BASE_BLOCKS - 1)]
            self.base = nn.Sequential(*map(Block, sizes))
            self.attention = TextGuidedAttention(text_size)
            self.colour = _head(3)
            self.displacement = _head(1)  # along the normal, as the paper's text says; the released code has 3

    def forward(self, features: torch.Tensor, text: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Colour, shape [n, 3], and displacement, shape [n, 1], from `features(points)` and a text embedding.

        The features are an argument because the points of a part never move: they are worth computing once.
        """
        values, norm = _through(self.base, features)
        shared: Any = self.attention(torch.addcmul(norm.bias, values, norm.weight), text)
        return _headed(self.colour, shared), _headed(self.displacement, shared)


def _through(blocks: Iterable[Block], values: torch.Tensor) -> tuple[torch.Tensor, nn.LayerNorm]:
    """Values after the blocks, and the normalisation still to be applied to them."""
    norm = None
    for block in blocks:
        values, norm = block(values, norm), block.norm
    return values, norm


def _headed(head: nn.Sequential, values: torch.Tensor) -> torch.Tensor:
    """Output of a `_head`."""
    return scaled(head[-1], *_through(head[:-1], values))


def _head(out: int) -> nn.Sequential:
    """Two blocks and a last map that is zero at first, so that iteration 0 is the plain part."""
    last = nn.Linear(WIDTH, out)
    nn.init.zeros_(last.weight)
    nn.init.zeros_(last.bias)
    return nn.Sequential(*[Block(WIDTH) for _ in range(HEAD_BLOCKS)], last)


def standardised(points: torch.Tensor) -> torch.Tensor:
    """Points, shape [n, 3], with mean 0 and unbiased deviation 1 in each coordinate; a flat coordinate stays 0."""
    centred = points - points.mean(dim=0)
    return centred / centred.std(dim=0).clamp(min=1e-9)
