import pytest
import torch

from mechstyle.styling.learned.guidance import Warps, random_warps, warped

CORNERS = torch.tensor([[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]])
SIZE = 32


def drawn(count=400, area=0.4, seed=0) -> Warps:
    return random_warps(count, area, torch.Generator().manual_seed(seed))


@pytest.fixture
def views():
    return torch.rand(3, 3, SIZE, SIZE, generator=torch.Generator().manual_seed(9))


@pytest.mark.parametrize("area", [0.1, 0.4])
def test_crops_have_the_area_and_aspects_asked_for_and_lie_within_the_picture(area):
    warps = drawn(area=area)
    assert torch.allclose(warps.half_sides.prod(dim=1), torch.tensor(area), atol=1e-6)
    aspect = warps.half_sides[:, 0] / warps.half_sides[:, 1]
    assert 0.75 <= float(aspect.min()) < 0.8
    assert 1.25 < float(aspect.max()) <= 4.0 / 3.0 + 1e-6
    assert float((warps.centre.abs() + warps.half_sides).max()) <= 1.0 + 1e-6
    assert float((warps.centre.abs() + warps.half_sides).max()) > 0.99


def test_four_of_five_are_seen_in_perspective_with_corners_at_most_half_way_in():
    warps = drawn(2000)
    straight = (warps.perspective - torch.eye(3)).abs().amax(dim=(1, 2)) < 1e-5
    assert 1.0 - float(straight.float().mean()) == pytest.approx(0.8, abs=0.03)
    back = torch.linalg.inv(warps.perspective)
    corners = torch.einsum("aij,nj->ani", back, torch.cat([CORNERS[0], torch.ones(4, 1)], dim=1))
    place = (corners[..., :2] / corners[..., 2:]).abs()
    assert 0.499 < float(place.min()) < 0.52
    assert float(place.max()) < 1.0 + 1e-4


def test_the_generator_alone_decides():
    one, again, other = drawn(seed=1), drawn(seed=1), drawn(seed=2)
    assert all(torch.equal(a, b) for a, b in zip(one, again, strict=True))
    assert not torch.equal(one.centre, other.centre)


def test_all_views_share_a_map_and_every_augmentation_is_as_if_alone(views):
    warps = drawn(4)
    together = warped(views, warps)
    assert together.shape == (12, 3, SIZE, SIZE)
    for number in range(4):
        alone = Warps(*(part[number : number + 1] for part in warps))
        for view in range(3):
            assert torch.allclose(together[3 * number + view], warped(views[view : view + 1], alone)[0], atol=1e-6)


def test_gradients_reach_the_picture(views):
    images = views.double().requires_grad_()
    warps = Warps(*(part.double() for part in drawn(2)))
    weigh = torch.rand(6, 3, SIZE, SIZE, generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    (slope,) = torch.autograd.grad((warped(images, warps) * weigh).sum(), images)
    images = images.detach()
    nudge = torch.zeros_like(slope)
    nudge[1, 0, 16, 15] = 1e-4
    central = ((warped(images + nudge, warps) - warped(images - nudge, warps)) * weigh).sum() / 2e-4
    assert float(central) == pytest.approx(float(slope[1, 0, 16, 15]), rel=1e-6)
    assert float(slope.abs().max()) > 0.1
