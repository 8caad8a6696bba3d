"""CLIP (Radford et al. 2021): how well a picture fits words, through the public model classes of transformers, frozen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path

import torch
import transformers  # by its attributes: each takes seconds to import, and much here needs no CLIP
from safetensors import safe_open
from torch import nn
from torch.nn import functional
from torch.nn.attention import SDPBackend, sdpa_kernel
from transformers.utils import logging

from mechstyle.errors import BadInput
from mechstyle.styling.learned.pretrained import CONFIG, MERGES, TOKENIZER, VOCABULARY, damaged, files_of, read_json

MEAN = (0.48145466, 0.4578275, 0.40821073)
DEVIATION = (0.26862954, 0.26130258, 0.27577711)
"""Of the pictures CLIP was trained on, per channel."""
BEGIN, END, WORD_END = "<|startoftext|>", "<|endoftext|>", "</w>"
FLOATS = ("F64", "F32", "F16", "BF16")
SIZES = ("projection_dim", "text_config", "vision_config", "text_config_dict", "vision_config_dict")
"""What is read of config.json."""
MOST_LAYERS, LARGEST_PICTURE = 128, 4096
"""Layers of a transformer, and the side of what it looks at [pixels]; the largest of the published CLIPs have 48 and 378."""
STEEPNESS = 1.702
"""CLIP's quick GELU of x is silu(1.702 x) / 1.702."""
_ATTENTION = [SDPBackend.EFFICIENT_ATTENTION, SDPBackend.MATH]  # on a GPU: the fastest whose gradients are repeatable


class Clip:
    """Frozen CLIP weights on a device. The model it is given is its own from then on: it is changed to compute faster.

    Attributes:
        picture_size: Side of the pictures it reads [pixels].
        text_size: Length of its embeddings.
    """

    def __init__(self, model: transformers.CLIPModel, tokenizer: transformers.CLIPTokenizer, device: str = "cpu") -> None:
        # The same sums in fewer passes: patches by a product of matrices, and the factors of quick GELU within the weights around it.
        model.vision_model.embeddings.patch_embedding = Patches(model.vision_model.embeddings.patch_embedding)
        quick_gelu = transformers.activations.QuickGELUActivation
        steep = [layer.mlp for layer in model.vision_model.encoder.layers if isinstance(layer.mlp.activation_fn, quick_gelu)]
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
        files = files_of(folder)
        shown = logging.is_progress_bar_enabled()
        logging.disable_progress_bar()
        try:
            vocabulary, merges = _words(folder, files)
            tokenizer = transformers.CLIPTokenizer(vocabulary, merges)
            config = _config(folder, vocabulary)
            _check_tensors(folder, files, config)
            read = {"local_files_only": True, "use_safetensors": True, "dtype": torch.float32}
            model = transformers.CLIPModel.from_pretrained(folder, config=config, **read)
        except BadInput:
            raise
        except Exception as error:  # whatever the libraries say of what somebody else wrote
            raise damaged(folder, error) from error
        finally:
            if shown:
                logging.enable_progress_bar()
        for tensor, values in model.state_dict().items():
            if not values.isfinite().all():
                raise BadInput(f"the tensor {tensor} in {folder} holds what is no number: get the folder again")
        return cls(model, tokenizer, device)

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


def _words(folder: Path, files: Sequence[str]) -> tuple[dict[str, int], list[tuple[str, ...]]]:
    """How a prompt becomes numbers: the number of every token, and the pairs of tokens that become one (Sennrich et al. 2016)."""
    if VOCABULARY in files:
        lines = (folder / MERGES).read_text("utf-8").splitlines()
        return read_json(folder, VOCABULARY), [tuple(line.split(" ")) for line in lines if line and not line.startswith("#version")]
    model = read_json(folder, TOKENIZER)["model"]
    if (model["type"], model["end_of_word_suffix"]) != ("BPE", WORD_END):
        raise damaged(folder / TOKENIZER, f"CLIP's words end in {WORD_END!r}")
    return model["vocab"], [tuple(merge.split(" ") if isinstance(merge, str) else merge) for merge in model["merges"]]


def _config(folder: Path, vocabulary: Mapping[str, int]) -> transformers.CLIPConfig:
    """Sizes of the CLIP of a folder, with the ends of a prompt as its tokenizer numbers them: versions disagree on those in config.json."""
    given = read_json(folder, CONFIG)
    if given.get("model_type") != "clip":
        raise damaged(folder / CONFIG, f"it is of a {given.get('model_type')!r} model, not of a 'clip'")
    config = transformers.CLIPConfig(**{key: given[key] for key in SIZES if key in given})
    config.text_config.bos_token_id, config.text_config.eos_token_id = vocabulary[BEGIN], vocabulary[END]
    if not 0 <= min(vocabulary.values()) <= max(vocabulary.values()) < config.text_config.vocab_size:
        raise damaged(folder, "its tokenizer is of another model")
    layers, side = max(config.text_config.num_hidden_layers, config.vision_config.num_hidden_layers), config.vision_config.image_size
    if layers > MOST_LAYERS or not 1 <= side <= LARGEST_PICTURE:
        raise damaged(folder / CONFIG, f"no CLIP has {layers} layers and reads pictures of {side} pixels")
    return config


def _check_tensors(folder: Path, files: Sequence[str], config: transformers.CLIPConfig) -> None:
    """Refuse files that hold other tensors than a config asks for, before anything is allocated: what is missing is never made up."""
    with torch.device("meta"):
        asked = {name: tuple(value.shape) for name, value in transformers.CLIPModel(config).state_dict().items()}
    there: dict[str, tuple[int, ...]] = {}
    for name in files:
        if name.endswith(".safetensors"):
            with safe_open(folder / name, framework="pt") as file:
                slices = {tensor: file.get_slice(tensor) for tensor in file.keys()}  # noqa: SIM118 — it is no dictionary
                there |= {tensor: tuple(part.get_shape()) for tensor, part in slices.items() if part.get_dtype() in FLOATS}
    odd = next((name for name in [*asked, *there] if asked.get(name) != there.get(name)), None)
    if odd is not None:
        raise damaged(folder, f"the tensor {odd} has the shape {there.get(odd)}, but {CONFIG} asks for {asked.get(odd)}")


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
