"""The stylizer that descends a guidance: it gets there, goes on with the same bytes, and leaves frozen vertices alone."""

import numpy as np
import pytest
import torch

from mechstyle.styling.drawn import ProceduralStylizer, Target
from mechstyle.styling.learned.guidance import TargetGuidance
from mechstyle.styling.learned.style_field import StyleField
from mechstyle.styling.learned.stylizer import FIELD_RATE, VERTEX_RATE, NeuralStylizer, VertexField
from mechstyle.styling.learned.unit_shape import UnitShape

BOUND = 0.6


@pytest.fixture(scope="module", autouse=True)
def _one_thread():
    """Small tensors: more threads would only wait for each other."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture(scope="module")
def part(stand):
    return stand


@pytest.fixture(scope="module")
def target(part, free) -> Target:
    """Waves along the height, red in the crests and blue in the troughs, no relief where none is possible."""
    wave = np.sin(part.vertices[:, 2] / 8.0) * np.cos(part.vertices[:, 0] / 9.0)
    colour = np.stack([0.5 + 0.4 * wave, np.full_like(wave, 0.3), 0.5 - 0.4 * wave], axis=1)
    return Target((0.4 * wave * free).astype(np.float32), colour.astype(np.float32), ())


@pytest.fixture(scope="module")
def free(part):
    """Which vertices may move: not the lowest layers."""
    return part.vertices[:, 2] > 8.0


@pytest.fixture(scope="module")
def shape(part, free) -> UnitShape:
    bound = np.full(len(free), BOUND)
    return UnitShape.of(part, bound, bound, free)


def guided(part, target, shape, *, field="network", seed=0) -> NeuralStylizer:
    guidance = TargetGuidance(target, part.vertex_areas, "waves", text_size=16)
    if field == "vertex":
        return NeuralStylizer(shape, VertexField(len(shape.mask)), guidance, rate=VERTEX_RATE, seed=seed)
    return NeuralStylizer(shape, StyleField(16, seed=seed), guidance, rate=FIELD_RATE, seed=seed)


@pytest.fixture
def stylizer(part, target, shape) -> NeuralStylizer:
    return guided(part, target, shape)


def test_a_network_driven_by_a_drawn_target_approaches_it(stylizer, target, free):
    start = stylizer.proposal()
    before = stylizer.loss(start.displacement, start.colour)
    for _ in range(30):
        found = stylizer.step()
    assert stylizer.loss(found.displacement, found.colour) < 0.15 * before
    assert np.corrcoef(found.displacement[free], target.displacement[free])[0, 1] > 0.95
    assert np.sqrt(((found.colour - target.colour) ** 2).mean()) < 0.06


def test_the_loss_is_that_of_the_procedural_stylizer(part, target, stylizer):
    procedural = ProceduralStylizer(part, target)
    rng = np.random.default_rng(0)
    surface = rng.normal(size=len(part.vertices)).astype(np.float32), rng.uniform(size=(len(part.vertices), 3)).astype(np.float32)
    assert stylizer.loss(*surface) == pytest.approx(procedural.loss(*surface), rel=1e-5)
    assert stylizer.loss(target.displacement, target.colour) == pytest.approx(0.0, abs=1e-10)


def test_frozen_vertices_never_move_and_are_still_painted(stylizer, free):
    for _ in range(6):
        found = stylizer.step()
    assert not found.displacement[~free].any()
    assert np.abs(found.displacement[free]).max() > 0.05
    moved = np.abs(found.colour[~free] - 0.5).max(axis=1)
    assert moved.min() > 0.01


def test_what_is_wanted_of_frozen_vertices_teaches_the_field_nothing(part, target, shape, free):
    """The mask is in the graph: another target there gives the same displacement everywhere."""
    other = target._replace(displacement=np.where(free, target.displacement, 5.0).astype(np.float32))
    first = guided(part, target, shape)
    second = guided(part, other, shape)
    second._guidance._reference = first._guidance._reference
    for _ in range(3):
        one, two = first.step(), second.step()
    assert np.array_equal(one.displacement, two.displacement)


@pytest.mark.parametrize("field", ["network", "vertex"])
def test_a_restored_stylizer_goes_on_with_the_same_bytes(part, target, shape, field):
    first = guided(part, target, shape, field=field)
    for _ in range(4):
        first.step()
    state = first.state()
    kept = {name: value.copy() for name, value in state.items()}
    ahead = [first.step() for _ in range(3)]
    assert all(np.array_equal(state[name], kept[name]) for name in state)
    assert all(value.dtype == np.float32 for value in state.values())
    other = guided(part, target, shape, field=field, seed=0 if field == "vertex" else 5)  # B and the weights are in the state
    other.restore(state)
    for one in ahead:
        two = other.step()
        assert (one.displacement.tobytes(), one.colour.tobytes()) == (two.displacement.tobytes(), two.colour.tobytes())
