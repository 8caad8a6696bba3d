"""On a GPU: an iteration recorded as a graph is the one run step by step, and a restored stylizer goes on with the same bytes."""

import numpy as np
import pytest
import torch

from mechstyle.styling.learned.clip import Clip
from mechstyle.styling.learned.guidance import ClipGuidance
from mechstyle.styling.learned.renderer import Renderer
from mechstyle.styling.learned.style_field import StyleField
from mechstyle.styling.learned.stylizer import FIELD_RATE, WARM_UP, NeuralStylizer
from mechstyle.styling.learned.unit_shape import UnitShape

pytestmark = pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a CUDA device and a torch built for it")


@pytest.fixture
def stylizer(sphere, tiny_clip):
    def made() -> NeuralStylizer:
        clip, bound = Clip.load(tiny_clip, "cuda"), np.full(len(sphere.vertices), 0.8)
        shape = UnitShape.of(sphere, bound, bound, np.ones(len(bound)), "cuda")
        render = Renderer(torch.tensor(sphere.faces), clip.picture_size, device="cuda")
        guidance = ClipGuidance(clip, "brick", render, crops=2, device="cuda")
        return NeuralStylizer(shape, StyleField(clip.text_size), guidance, rate=FIELD_RATE)

    return made


def test_a_recorded_iteration_is_the_one_run_step_by_step(stylizer):
    recorded, eager = stylizer(), stylizer()
    eager._descend._calls = eager._look._calls = -1_000_000  # warms up for ever
    for _ in range(WARM_UP + 5):
        one, two = recorded.step(), eager.step()
        assert np.abs(one.displacement - two.displacement).max() < 1e-4
        assert np.abs(one.colour - two.colour).max() < 1e-3
    assert recorded._descend._graph is not None


def test_a_restored_stylizer_goes_on_with_the_same_bytes(stylizer):
    first, other = stylizer(), stylizer()
    for _ in range(WARM_UP + 2):
        first.step()
    other.restore(first.state())
    for _ in range(WARM_UP + 2):
        one, two = first.step(), other.step()
        assert (one.displacement.tobytes(), one.colour.tobytes()) == (two.displacement.tobytes(), two.colour.tobytes())
