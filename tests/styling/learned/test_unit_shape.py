import numpy as np
import pytest
import torch

from mechstyle.styling.learned.unit_shape import Logits, UnitShape

INWARD, OUTWARD = 0.5, 0.8


@pytest.fixture
def shape(sphere):
    """A ball of radius 10 mm about (3, 0, 0), its lower half frozen."""
    count = len(sphere.vertices)
    return UnitShape.of(sphere, np.full(count, INWARD), np.full(count, OUTWARD), sphere.vertices[:, 2] >= 0.0)


def logits(shape, scale=1.0, seed=0) -> Logits:
    generator = torch.Generator().manual_seed(seed)
    count = len(shape.positions)
    return Logits(scale * torch.randn(count, 3, generator=generator), scale * torch.randn(count, generator=generator))


def test_a_part_is_centred_of_radius_one_and_turned_upright(holder):
    shape = UnitShape.of(holder, np.ones(len(holder.vertices)), np.ones(len(holder.vertices)), np.ones(len(holder.vertices)))
    assert torch.allclose(shape.positions.mean(dim=0), torch.zeros(3), atol=1e-6)
    assert float(shape.positions.norm(dim=1).max()) == pytest.approx(1.0, abs=1e-6)
    highest = int(holder.vertices[:, 2].argmax())
    assert int(shape.positions[:, 1].argmax()) == highest
    back = shape.positions.numpy()[:, [0, 2, 1]] * [1.0, -1.0, 1.0] * shape.radius + holder.vertices.mean(axis=0)
    assert np.allclose(back, holder.vertices, atol=1e-4)
    bottom = int(holder.vertex_normals[:, 2].argmin())
    assert float(shape.normals[bottom, 1]) == pytest.approx(-1.0, abs=1e-5)


def test_no_output_of_a_field_exceeds_the_bounds(shape):
    look = shape.look(logits(shape, scale=50.0))
    assert float(look.displacement.min()) == pytest.approx(-INWARD)
    assert float(look.displacement.max()) == pytest.approx(OUTWARD)
    assert float(look.colour.min()) >= 0.0
    assert float(look.colour.max()) <= 1.0


def test_a_displacement_goes_along_the_normals_and_the_part_keeps_its_unit_radius(shape):
    even = shape.placed(torch.full_like(shape.mask, 0.7))
    assert torch.allclose(even, shape.positions, atol=1e-3)  # a ball that grows evenly looks the same
    bumped = torch.zeros_like(shape.mask)
    top = int(shape.positions[:, 1].argmax())
    bumped[top] = 2.0
    placed = shape.placed(bumped)
    assert float(placed.norm(dim=1).max()) == pytest.approx(1.0, abs=1e-6)
    assert float(placed[top, 1]) == pytest.approx(1.0, abs=1e-6)
    assert float(placed[:, 1].min()) == pytest.approx(-10.0 / 12.0, abs=1e-3)


def test_where_the_mask_is_zero_nothing_moves_and_no_gradient_flows_but_colour(shape):
    colour, displacement = (part.requires_grad_() for part in logits(shape))
    look = shape.look(Logits(colour, displacement))
    (look.positions * torch.randn(look.positions.shape, generator=torch.Generator().manual_seed(1))).sum().backward()
    look = shape.look(Logits(colour, displacement))
    look.colour.sum().backward()
    frozen = shape.mask == 0.0
    assert not look.displacement[frozen].any()
    assert not displacement.grad[frozen].any()
    assert displacement.grad[~frozen].all()
    assert colour.grad.all()
