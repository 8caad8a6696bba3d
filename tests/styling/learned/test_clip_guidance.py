"""Guidance by CLIP on a small ball with a tiny random CLIP: its parts, its gradients, and the stylizer that descends it."""

import numpy as np
import pytest
import torch
from scipy.spatial import ConvexHull

from mechstyle.records.mesh import SurfaceMesh
from mechstyle.styling.learned.clip import Clip
from mechstyle.styling.learned.guidance import VIEWS, ClipGuidance, Warps, warped
from mechstyle.styling.learned.renderer import Renderer
from mechstyle.styling.learned.style_field import StyleField
from mechstyle.styling.learned.stylizer import FIELD_RATE, VERTEX_RATE, NeuralStylizer, VertexField
from mechstyle.styling.learned.unit_shape import Logits, UnitShape


@pytest.fixture(scope="module", autouse=True)
def _one_thread():
    """Small tensors: more threads would only wait for each other."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture(scope="module")
def ball(sphere) -> SurfaceMesh:
    """The first 258 vertices of the sphere are the sphere quartered three times."""
    points = sphere.vertices[:258]
    faces = ConvexHull(points).simplices
    inside_out = np.linalg.det(points[faces]) < 0
    faces[inside_out] = faces[inside_out][:, ::-1]
    return SurfaceMesh(points, faces)


@pytest.fixture(scope="module")
def clip(tiny_clip) -> Clip:
    return Clip.load(tiny_clip)


@pytest.fixture(scope="module")
def shape(ball) -> UnitShape:
    bound = np.full(len(ball.vertices), 0.8)
    return UnitShape.of(ball, bound, bound, ball.vertices[:, 2] > -5.0)


@pytest.fixture(scope="module")
def guidance(clip, ball) -> ClipGuidance:
    return ClipGuidance(clip, "brick", Renderer(torch.tensor(ball.faces), clip.picture_size), crops=2)


def stylizer(shape, guidance, field="network") -> NeuralStylizer:
    if field == "vertex":
        return NeuralStylizer(shape, VertexField(len(shape.mask)), guidance, rate=VERTEX_RATE)
    return NeuralStylizer(shape, StyleField(len(guidance.text)), guidance, rate=FIELD_RATE)


def leaves(shape) -> Logits:
    generator = torch.Generator().manual_seed(0)
    count = len(shape.mask)
    return Logits(torch.randn(count, 3, generator=generator).requires_grad_(), torch.randn(count, generator=generator).requires_grad_())


def seeded(number: int) -> torch.Generator:
    return torch.Generator().manual_seed(number)


def test_the_loss_is_minus_the_cosines_of_mean_view_embeddings(guidance, clip, shape):
    """Written out loss by loss, as the paper does: one CLIP call an augmentation, embeddings averaged over views before the cosine."""
    with torch.no_grad():
        look, draws = shape.look(leaves(shape)), guidance.draw(seeded(2))
        coloured = guidance._render(look.positions, look.colour, draws.cameras).image
        grey = guidance._render(look.positions, torch.full_like(look.colour, 0.5), draws.grey_cameras).image
        expected = 0.0
        for images, warps in ((coloured, draws.warps), (grey, draws.grey_warps)):
            for number in range(len(warps.centre)):
                one = Warps(*(part[number : number + 1] for part in warps))
                mean = clip.pictures(warped(images, one)).mean(dim=0)
                expected -= float(mean @ guidance.text / (mean.norm() * guidance.text.norm()))
        assert float(guidance.loss(look, draws)) == pytest.approx(expected, abs=2e-3)  # bfloat16 where it is used


def test_draws_are_the_published_ones(guidance):
    draws = guidance.draw(seeded(3))
    assert len(draws.cameras.azimuth) == len(draws.grey_cameras.azimuth) == VIEWS
    assert float(draws.cameras.azimuth[0]) == float(draws.cameras.elevation[0]) == 0.0
    assert not torch.equal(draws.cameras.azimuth, draws.grey_cameras.azimuth)
    areas = draws.warps.half_sides.prod(dim=1)
    assert torch.allclose(areas, torch.tensor([1.0, 0.4, 0.4]))
    assert torch.allclose(draws.grey_warps.half_sides.prod(dim=1), torch.tensor([0.1, 0.1]))
    again = guidance.draw(seeded(3))
    assert torch.equal(again.warps.perspective, draws.warps.perspective)
    assert torch.equal(again.grey_cameras.azimuth, draws.grey_cameras.azimuth)


def test_colours_learn_from_the_coloured_views_alone_and_shape_from_both(guidance, shape):
    colour, displacement = leaves(shape)
    guidance.loss(shape.look(Logits(colour, displacement)), guidance.draw(seeded(4))).backward()
    assert colour.grad.any()
    assert displacement.grad[shape.mask > 0.0].abs().max() > 0.0
    assert not displacement.grad[shape.mask == 0.0].any()


@pytest.mark.parametrize("field", ["network", "vertex"])
def test_the_loss_falls_over_fifty_iterations(guidance, shape, field):
    made = stylizer(shape, guidance, field)
    start = made.proposal()
    before = made.loss(start.displacement, start.colour)
    for _ in range(50):
        found = made.step()
    # Random weights tell pictures apart only a little; the distance is the same whenever it is asked, so any fall is a fall.
    assert made.loss(found.displacement, found.colour) < before - 0.03
    assert not found.displacement[(shape.mask == 0.0).numpy()].any()
    assert found.displacement.any()


def test_a_restored_stylizer_goes_on_with_the_same_bytes(guidance, shape):
    first = stylizer(shape, guidance)
    for _ in range(3):
        first.step()
    other = stylizer(shape, guidance)
    other.restore(first.state())
    for _ in range(3):
        one, two = first.step(), other.step()
        assert (one.displacement.tobytes(), one.colour.tobytes()) == (two.displacement.tobytes(), two.colour.tobytes())
    assert first.loss(one.displacement, one.colour) == other.loss(two.displacement, two.colour)


def test_other_words_and_other_seeds_give_other_styles(guidance, clip, ball, shape):
    other_words = ClipGuidance(clip, "zebra", Renderer(torch.tensor(ball.faces), clip.picture_size), crops=2)
    other_seed = NeuralStylizer(shape, StyleField(len(guidance.text)), guidance, rate=FIELD_RATE, seed=1)
    found = []
    for made in (stylizer(shape, guidance), stylizer(shape, other_words), other_seed):
        for _ in range(3):
            proposal = made.step()
        found.append(proposal.colour)
    assert not np.array_equal(found[0], found[1])
    assert not np.array_equal(found[0], found[2])
