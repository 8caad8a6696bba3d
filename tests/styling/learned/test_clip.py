"""The wrapper around CLIP: what goes in, what comes out, and that only sound files are read."""

import os
from pathlib import Path

import pytest
import torch
import transformers

from mechstyle.errors import BadInput
from mechstyle.styling.learned.clip import Clip


@pytest.fixture(scope="module")
def clip(tiny_clip) -> Clip:
    return Clip.load(tiny_clip)


@pytest.fixture
def views(clip):
    return torch.rand(4, 3, clip.picture_size, clip.picture_size, generator=torch.Generator().manual_seed(0))


def test_embeddings_are_those_of_the_model_transformers_saved(clip, tiny_clip, views):
    model = transformers.CLIPModel.from_pretrained(tiny_clip, local_files_only=True)
    tokens = transformers.CLIPTokenizer.from_pretrained(tiny_clip, local_files_only=True)("a brick wall", return_tensors="pt")
    mean, deviation = torch.tensor(transformers.CLIPImageProcessor().image_mean), torch.tensor(transformers.CLIPImageProcessor().image_std)
    whole = model(**tokens, pixel_values=(views - mean.view(3, 1, 1)) / deviation.view(3, 1, 1))
    # transformers normalises what it gives out, and bfloat16 where it is used keeps two to three digits.
    for mine, theirs in ((clip.text("a brick wall")[None], whole.text_embeds), (clip.pictures(views), whole.image_embeds)):
        assert torch.allclose(torch.cosine_similarity(mine, theirs), torch.ones(len(mine)), atol=2e-4)


def test_the_model_is_frozen_and_gradients_reach_the_pictures(clip, views):
    images = views.clone().requires_grad_()
    clip.pictures(images).square().sum().backward()
    assert images.grad is not None
    assert images.grad.abs().amax(dim=(1, 2, 3)).all()
    assert all(not parameter.requires_grad and parameter.grad is None for parameter in clip._model.parameters())


def test_a_prompt_too_long_is_refused(clip):
    with pytest.raises(BadInput, match="the prompt has 100 tokens, but CLIP reads 75: make it shorter"):
        clip.text("b " * 100)


@pytest.mark.weights
def test_real_weights_tell_a_red_picture_from_a_blue_one():
    folder = os.environ.get("MECHSTYLE_CLIP")
    if not folder:
        pytest.skip("SKIPPED: no real CLIP weights; name a folder that holds them with $MECHSTYLE_CLIP")
    clip = Clip.load(Path(folder))
    pictures = torch.zeros(2, 3, clip.picture_size, clip.picture_size)
    pictures[0, 0] = pictures[1, 2] = 1.0
    words = torch.stack([clip.text(f"a plain {colour} picture") for colour in ("red", "blue")])
    likeness = torch.cosine_similarity(clip.pictures(pictures)[:, None], words[None], dim=2)
    assert likeness[0, 0] > likeness[0, 1]
    assert likeness[1, 1] > likeness[1, 0]
