"""The network against a second forward written plainly from the published description, and its gradients against differences."""

import numpy as np
import pytest
import torch

from mechstyle.styling.learned.style_field import StyleField, standardised

POINTS = 40
TEXT = 24


@pytest.fixture
def points():
    return standardised(torch.randn(POINTS, 3, generator=torch.Generator().manual_seed(1)) * torch.tensor([3.0, 1.0, 0.2]))


@pytest.fixture
def text():
    return torch.randn(TEXT, generator=torch.Generator().manual_seed(2))


def trained() -> StyleField:
    """A field in which no parameter is at its special initial value, so that every path counts."""
    field = StyleField(TEXT, seed=3).double()
    generator = torch.Generator().manual_seed(4)
    with torch.no_grad():
        for parameter in field.parameters():
            parameter.add_(torch.randn(parameter.shape, generator=generator, dtype=torch.float64), alpha=0.05)
    return field


def plain_forward(weights: dict[str, np.ndarray], x: np.ndarray, text: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The network as an X-Mesh paper reader would write it down, one einsum a formula."""
    sigmoid = lambda z: 1.0 / (1.0 + np.exp(-z))  # noqa: E731

    def linear(name, z):
        return np.einsum("ni,oi->no", z, weights[name + ".weight"]) + weights[name + ".bias"]

    def block(name, z):
        z = np.maximum(linear(name + ".linear", z), 0.0)
        z = (z - z.mean(axis=1, keepdims=True)) / np.sqrt(z.var(axis=1, keepdims=True) + 1e-5)
        return z * weights[name + ".norm.weight"] + weights[name + ".norm.bias"]

    def dynamic(name, z):
        u = (np.einsum("oi,i->o", weights[name + ".generator.weight"], text) + weights[name + ".generator.bias"]).reshape(-1, 30)
        made = np.einsum("ik,ko->io", u, weights[name + ".basis"])
        return np.einsum("ni,io->no", z, made[:-1]) + made[-1]

    def gate(name, z):
        return dynamic(name + ".widen", np.maximum(dynamic(name + ".narrow", z), 0.0))

    phase = 2.0 * np.pi * np.einsum("ni,ik->nk", x, weights["features.frequencies"])
    z = np.concatenate([x, np.sin(phase), np.cos(phase)], axis=1)
    for number in range(5):
        z = block(f"base.{number}", z)
    z = z * sigmoid(gate("attention.channel", z).mean(axis=0))[None, :]
    z = z * sigmoid(gate("attention.spatial", z).mean(axis=1))[:, None]
    return tuple(linear(f"{head}.2", block(f"{head}.1", block(f"{head}.0", z))) for head in ("colour", "displacement"))


def test_the_network_is_the_published_one(points, text):
    field = trained()
    weights = {name: value.detach().numpy() for name, value in field.state_dict().items()}
    expected = plain_forward(weights, points.double().numpy(), text.double().numpy())
    found = field(field.features(points.double()), text.double())
    for mine, theirs in zip(found, expected, strict=True):
        assert np.abs(mine.detach().numpy() - theirs).max() < 1e-12 * np.abs(theirs).max() + 1e-12


def test_it_has_the_published_number_of_parameters():
    """9,609,086, less two layer normalisations that the released network has and never uses, and two of three displacements."""
    field = StyleField(512)
    assert sum(parameter.numel() for parameter in field.parameters()) == 9_609_086 - 2 * 2 * 256 - 2 * 257
    assert sum(parameter.numel() for parameter in field.attention.parameters()) == 8_943_480


def test_gradients_agree_with_finite_differences(points, text):
    field, generator = trained(), torch.Generator().manual_seed(5)
    weigh = [torch.randn(POINTS, size, generator=generator, dtype=torch.float64) for size in (3, 1)]

    def loss() -> torch.Tensor:
        found = field(field.features(points.double()), text.double())
        return sum((one * other).sum() for one, other in zip(found, weigh, strict=True))

    loss().backward()
    for name, parameter in field.named_parameters():
        direction = torch.randn(parameter.shape, generator=generator, dtype=torch.float64)
        direction /= direction.norm()  # a small step, so that hardly a unit crosses the kink of its ReLU
        slope = float((parameter.grad * direction).sum())
        with torch.no_grad():
            parameter.add_(direction, alpha=1e-6)
            ahead = float(loss())
            parameter.sub_(direction, alpha=2e-6)
            central = (ahead - float(loss())) / 2e-6
            parameter.add_(direction, alpha=1e-6)
        assert central == pytest.approx(slope, rel=1e-5, abs=1e-6), name
