import pytest
import torch

from mechstyle.styling.learned.tensors import blended, placed, taken, whole_sums


@pytest.fixture
def drawn():
    """Rows, the two sums each of them goes to, and with what weights."""
    generator = torch.Generator().manual_seed(0)
    rows = torch.randn(5000, 7, generator=generator) * 10.0 ** torch.randint(-6, 1, (5000, 1), generator=generator)
    return rows, torch.randint(0, 300, (5000, 2), generator=generator), torch.rand(5000, 2, generator=generator)


def test_whole_sums_are_the_sums(drawn):
    rows, index, weights = drawn
    expected = torch.zeros(310, 7, dtype=torch.float64)
    for k in range(2):
        expected = expected.index_add(0, index[:, k], rows.double() * weights[:, k, None].double())
    found = whole_sums(rows, index, weights, 310)
    assert torch.allclose(found.double(), expected, rtol=1e-6, atol=1e-6)
    assert (found[300:] == 0.0).all()


def test_rows_are_taken_and_blended_with_their_gradients(drawn):
    values, index, weights = drawn[0][:300].clone().requires_grad_(), drawn[1], drawn[2]
    expected = (values[index] * weights[..., None]).sum(dim=1)
    assert torch.equal(taken(values, index), values[index])
    assert torch.allclose(blended(values, index, weights), expected, atol=1e-6)
    (slope,) = torch.autograd.grad(blended(values, index, weights).square().sum(), values)
    assert torch.allclose(slope, torch.autograd.grad(expected.square().sum(), values)[0], rtol=1e-4, atol=1e-5)


def test_rows_are_placed_with_their_gradients_and_those_at_no_place_have_none():
    rows = torch.arange(8.0, dtype=torch.float64).view(4, 2).requires_grad_()
    place, row = torch.tensor([5, 1, 1, 4]), torch.tensor([-1, 1, -1, -1, 3, 0])  # row 2 names the place of row 1
    found = placed(rows, place, row)
    assert found.tolist() == [[0, 0], [2, 3], [0, 0], [0, 0], [6, 7], [0, 1]]
    (slope,) = torch.autograd.grad((found * torch.arange(1.0, 13.0).view(6, 2)).sum(), rows)
    assert slope.tolist() == [[11, 12], [3, 4], [0, 0], [9, 10]]
