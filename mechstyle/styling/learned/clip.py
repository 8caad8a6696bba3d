"""CLIP (Radford et al. 2021): how well a picture fits words, through the public model classes of transformers, frozen."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import msgspec
import torch
from safetensors import safe_open
from torch import nn
from torch.nn import functional
from torch.nn.attention import SDPBackend, sdpa_kernel
from transformers import CLIPConfig, CLIPModel, CLIPTokenizer
from transformers.activations import QuickGELUActivation
from transformers.utils import logging

from mechstyle.errors import BadInput
from mechstyle.styling.learned.pretrained import BEGIN, END, Pretrained, opened

MEAN = (0.48145466, 0.4578275, 0.40821073)
DEVIATION = (0.26862954, 0.26130258, 0.27577711)
"""Of the pictures CLIP was trained on, per channel."""
STEEPNESS = 1.702
"""CLIP's quick GELU of x is silu(1.702 x) / 1.702."""
_ATTENTION = [SDPBackend.EFFICIENT_ATTENTION, SDPBackend.MATH]  # on a GPU: the fastest whose gradients are repeatable


class Clip:
    """Frozen CLIP weights on a device. The model it is given is its own from then on: it is changed to compute faster.

    Attributes:
        picture_size: Side of the pictures it reads [pixels].
        text_size: Length of its embeddings.
    """

    def __init__(self, model: CLIPModel, tokenizer: CLIPTokenizer, device: str = "cpu") -> None:
        # The same sums in fewer passes: patches by a product of matrices, and the factors of quick GELU within the weights around it.
        model.vision_model.embeddings.patch_embedding = Patches(model.vision_model.embeddings.patch_embedding)
        steep = [layer.mlp for layer in model.vision_model.encoder.layers if isinstance(layer.mlp.activation_fn, QuickGELUActivation)]
        with torch.no_grad():
            for perceptron in steep:
                perceptron.activation_fn = nn.SiLU()
                perceptron.fc1.weight *= STEEPNESS
                perceptron.fc1.bias *= STEEPNESS
                perceptron.fc2.weight /= STEEPNESS
        self._model = model.to(device=device, dtype=precision(device)).eval().requires_grad_(requires_grad=False)
        self._tokenizer = tokenizer
        self._device = device
        self._mean, self._deviation = (torch.tensor(value, device=device).view(3, 1, 1) for value in (MEAN, DEVIATION))
        self.picture_size = int(model.config.vision_config.image_size)
        self.text_size = int(model.config.projection_dim)

    @classmethod
    def load(cls, folder: Path, device: str = "cpu") -> Clip:
        """The model and tokenizer saved in a folder.

        Raises:
            BadInput: If they cannot be read.
        """
        found = opened(folder)
        shown = logging.is_progress_bar_enabled()
        logging.disable_progress_bar()
        try:
            tensors: dict[str, torch.Tensor] = {}
            for name in sorted(set(found.tensors.values())):
                with safe_open(found.folder / name, framework="pt") as file:
                    tensors |= {tensor: file.get_tensor(tensor).float() for tensor, place in found.tensors.items() if place == name}
            for tensor, values in tensors.items():
                if not values.isfinite().all():
                    place = found.folder / found.tensors[tensor]
                    raise BadInput(f"the tensor {tensor} in {place} holds what is no number: get the folder again")
            model = CLIPModel.from_pretrained(None, config=_config(found), state_dict=tensors, dtype=torch.float32)
        finally:
            if shown:
                logging.enable_progress_bar()
        return cls(model, CLIPTokenizer(found.words.vocabulary, found.words.merges), device)

    def text(self, prompt: str) -> torch.Tensor:
        """Embedding of a prompt, not normalised, shape [text_size]."""
        tokens = self._tokenizer(prompt, return_tensors="pt")
        longest = self._model.config.text_config.max_position_embeddings
        if tokens["input_ids"].shape[1] > longest:
            raise BadInput(f"the prompt has {tokens['input_ids'].shape[1] - 2} tokens, but CLIP reads {longest - 2}: make it shorter")
        with torch.no_grad():
            pooled = self._model.text_model(**tokens.to(self._device)).pooler_output
            return self._model.text_projection(pooled)[0].float()

    def pictures(self, images: torch.Tensor) -> torch.Tensor:
        """Embeddings, not normalised, shape [b, text_size].

        Args:
            images: Pictures with values from 0 to 1, shape [b, 3, picture_size, picture_size].
        """
        normalised = ((images - self._mean) / self._deviation).to(self._model.dtype)
        with sdpa_kernel(_ATTENTION) if normalised.is_cuda else nullcontext():
            pooled = self._model.vision_model(pixel_values=normalised).pooler_output
        return self._model.visual_projection(pooled).float()


def _config(found: Pretrained) -> CLIPConfig:
    """Its sizes, and the end of a prompt as its own tokenizer numbers it: what config.json says of that changed between versions."""
    text, vision = msgspec.structs.asdict(found.config.text), msgspec.structs.asdict(found.config.vision)
    ends = {"bos_token_id": found.words.vocabulary[BEGIN], "eos_token_id": found.words.vocabulary[END]}
    return CLIPConfig(text_config={**text, **ends}, vision_config=vision, projection_dim=found.config.projection_dim)


class Patches(nn.Module):
    """The convolution that cuts pictures into patches, as a product of matrices: for its gradient cuDNN takes fifty times as long.

    Args:
        cutter: A convolution without bias whose stride is the side of its kernel.
    """

    def __init__(self, cutter: nn.Conv2d) -> None:
        super().__init__()
        self.weight = cutter.weight

    def forward(self, pictures: torch.Tensor) -> torch.Tensor:
        """Patches embedded, shape [b, width, grid, grid], of pictures, shape [b, 3, grid · side, grid · side]."""
        side = self.weight.shape[-1]
        apart = pictures.unfold(2, side, side).unfold(3, side, side)
        rows = functional.linear(apart.permute(0, 2, 3, 1, 4, 5).flatten(3), self.weight.flatten(1))
        return rows.permute(0, 3, 1, 2)


def precision(device: str) -> torch.dtype:
    """bfloat16 where the processor multiplies it directly, two to three times faster; embeddings agree to a cosine of 0.9999."""
    if device.startswith("cuda"):
        return torch.bfloat16
    able = torch.cpu.get_capabilities()
    return torch.bfloat16 if able.get("avx512_bf16") or able.get("amx_bf16") else torch.float32
