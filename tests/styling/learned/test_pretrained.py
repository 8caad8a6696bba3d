"""Folders as versions of transformers write them are read, all others refused in a sentence that names what is wrong.

The folders hold random numbers under the real names; `Clip` is asked for embeddings, so that what is read is what was saved.
"""

from __future__ import annotations

import json
import re
import shutil
import struct
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

import pytest
import torch
import transformers
from safetensors.torch import load_file, save_file
from transformers.utils import logging

from mechstyle.errors import BadInput
from mechstyle.styling.learned.clip import Clip

PROMPT = "a mossy brick, 2 of 3"
WEIGHTS, INDEX, CONFIG = "model.safetensors", "model.safetensors.index.json", "config.json"
LAYER = "vision_model.encoder.layers.1.mlp.fc1.weight"
MERGES = [("b", "r"), ("i", "c"), ("ic", "k</w>"), ("br", "ick</w>")]


@pytest.fixture(autouse=True)
def _without_progress_bars():
    logging.disable_progress_bar()
    yield
    logging.enable_progress_bar()


@pytest.fixture
def folder(tiny_clip, tmp_path) -> Path:
    """A copy of the tiny CLIP that may be broken."""
    return Path(shutil.copytree(tiny_clip, tmp_path / "clip"))


@pytest.fixture(scope="module")
def model(tiny_clip) -> transformers.CLIPModel:
    return transformers.CLIPModel.from_pretrained(tiny_clip, local_files_only=True, dtype=torch.float32)


@pytest.fixture(scope="module")
def embedded(tiny_clip) -> Callable[[Path], torch.Tensor]:
    """Cosines between what a folder says of a prompt and a picture, and what the tiny CLIP says of them."""
    picture = torch.rand(1, 3, 32, 32, generator=torch.Generator().manual_seed(0))

    def both(folder: Path) -> torch.Tensor:
        clip = Clip.load(folder)
        return torch.stack([clip.text(PROMPT), clip.pictures(picture)[0]])

    true = both(tiny_clip)
    return lambda folder: torch.cosine_similarity(both(folder), true)


def edited(path: Path, change: Callable[[dict], object]) -> None:
    """Change a JSON file in place."""
    record = json.loads(path.read_text())
    change(record)
    path.write_text(json.dumps(record))


def refused(folder: Path, words: str) -> None:
    """The folder is refused, by this sentence and in one line."""
    with pytest.raises(BadInput, match=words) as caught:
        Clip.load(folder)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600


@pytest.mark.parametrize("sharded", [False, True])
@pytest.mark.parametrize(("kind", "least"), [(torch.float32, 1 - 1e-6), (torch.float16, 1 - 1e-3), (torch.bfloat16, 1 - 1e-2)])
def test_weights_are_read_whole_or_in_shards_in_any_precision(folder, model, embedded, kind, least, sharded):
    (folder / WEIGHTS).unlink()
    size = {"max_shard_size": "20KB"} if sharded else {}
    deepcopy(model).to(kind).save_pretrained(folder, **size)
    assert len(list(folder.glob("*.safetensors"))) == (1 if not sharded else len(set(map_of(folder).values())))
    if kind == torch.float32:
        shutil.copy(next(folder.glob("*.safetensors")), folder / "note.safetensors")  # what is not a model's is left alone
    assert (embedded(folder) > least).all()


def map_of(folder: Path) -> dict[str, str]:
    return json.loads((folder / INDEX).read_text())["weight_map"]


@pytest.mark.parametrize(
    "config",
    [
        lambda new: {**new, "text_config_dict": None, "vision_config_dict": None, "torch_dtype": "float32", "transformers_version": "4.16"},
        lambda new: {**new, "text_config": None, "text_config_dict": new["text_config"], "vision_config_dict": new["vision_config"]},
        lambda new: {**new, "text_config": {**new["text_config"], "eos_token_id": 2, "bos_token_id": 0, "num_beams": 1}},
        lambda new: {**new, "auto_map": {"AutoModel": "x--model.X"}, "architectures": ["X"], "quantization_config": {"quant_method": "x"}},
        lambda new: {key: new[key] for key in ("model_type", "projection_dim", "text_config", "vision_config")},
    ],
    ids=["nulls", "twice", "old ends", "what is none of its business", "least"],
)
def test_configs_of_all_versions_mean_the_same(folder, embedded, config):
    (folder / CONFIG).write_text(json.dumps(config(json.loads((folder / CONFIG).read_text()))))
    assert (embedded(folder) > 1 - 1e-6).all()


def merging(folder: Path) -> dict[str, int]:
    """A vocabulary with some of the words that the merges make, in place of tokens that no prompt here uses."""
    vocabulary = json.loads((folder / "vocab.json").read_text())
    rare = [token for token in vocabulary if not token.isascii()][: len(MERGES)]
    return {dict(zip(rare, map("".join, MERGES), strict=True)).get(token, token): number for token, number in vocabulary.items()}


@pytest.mark.parametrize("how", ["vocabulary and merges", "tokenizer.json", "merges as pairs", "merges as words", "windows", "both"])
def test_tokenizers_of_all_versions_give_the_numbers_that_transformers_gives(folder, how):
    vocabulary = merging(folder)
    theirs = transformers.CLIPTokenizer(vocabulary, MERGES)
    theirs.save_pretrained(folder)
    end = "\r\n" if how == "windows" else "\n"
    (folder / "vocab.json").write_text(json.dumps(vocabulary))
    (folder / "merges.txt").write_bytes(end.join(["#version: 0.2", *map(" ".join, MERGES), ""]).encode())
    if how in {"tokenizer.json", "merges as pairs", "merges as words"}:
        (folder / "merges.txt").unlink()
        (folder / "vocab.json").unlink()
        joined = {"merges as pairs": [list(pair) for pair in MERGES], "merges as words": [" ".join(pair) for pair in MERGES]}.get(how)
        edited(folder / "tokenizer.json", lambda saved: saved["model"].update(merges=joined) if joined else None)
    elif how != "both":
        (folder / "tokenizer.json").unlink()
    mine = Clip.load(folder)._tokenizer
    assert mine(PROMPT)["input_ids"] == theirs(PROMPT)["input_ids"]
    assert vocabulary["brick</w>"] in mine(PROMPT)["input_ids"]


def test_no_tensor_that_is_missing_is_filled_with_random_numbers(folder):
    tensors = load_file(folder / WEIGHTS)
    for name in list(tensors)[::7]:
        save_file({other: value for other, value in tensors.items() if other != name}, folder / WEIGHTS)
        refused(folder, f"the tensor {re.escape(name)} has the shape None")


def test_pickled_weights_are_not_read_and_their_user_is_told_what_to_do(folder, model):
    (folder / WEIGHTS).unlink()
    torch.save(model.state_dict(), folder / "pytorch_model.bin")
    refused(folder, r"pytorch_model\.bin is pickled, .* save the model as model\.safetensors with CLIPModel\.from_pretrained")


@pytest.mark.parametrize("kind", ["siglip", "clip_vision_model", ""])
def test_another_model_is_named(folder, kind):
    edited(folder / CONFIG, lambda config: config.update(model_type=kind))
    refused(folder, f"it is of a '{kind}' model, not of a 'clip'")


@pytest.mark.parametrize("outside", ["../secret.safetensors", "/etc/passwd", "sub/model.safetensors", "..", "", "a\0b"])
def test_an_index_that_leads_out_of_the_folder_is_refused(folder, outside):
    shutil.copy(folder / WEIGHTS, folder.parent / "secret.safetensors")
    (folder / "sub").mkdir()
    shutil.move(folder / WEIGHTS, folder / "sub" / WEIGHTS)
    (folder / INDEX).write_text(json.dumps({"weight_map": {"logit_scale": outside}}))
    refused(folder, "leads out of .*: put the file itself into the folder|is missing or no file")


@pytest.mark.parametrize("name", [CONFIG, WEIGHTS, "vocab.json"])
def test_a_link_out_of_the_folder_is_refused(folder, tmp_path, name):
    (folder / name).rename(tmp_path / "elsewhere")
    (folder / name).symlink_to(tmp_path / "elsewhere")
    refused(folder, f"'{name}' leads out of .*: put the file itself into the folder")


def header(entries: dict[str, object], length: int | None = None, data: int = 0) -> bytes:
    """A safetensors file with a header of one's own."""
    text = json.dumps(entries).encode()
    return struct.pack("<Q", len(text) if length is None else length) + text + bytes(data)


@pytest.mark.parametrize(
    "data",
    [
        header({}, length=2**63),
        header({}, length=16 << 20),
        header({LAYER: {"dtype": "F32", "shape": [10**6, 10**6], "data_offsets": [0, 4 * 10**12]}}, data=64),
        header({LAYER: {"dtype": "F32", "shape": [64, 32], "data_offsets": [0, 64]}}, data=64),
        header({name: {"dtype": "F32", "shape": [4], "data_offsets": [at, at + 16]} for name, at in (("a", 0), ("b", 8))}, data=24),
        b"[" * 100_000,
    ],
    ids=["longest", "longer than the file", "gigabytes", "too few bytes", "overlapping", "brackets"],
)
def test_headers_that_lie_are_refused_before_anything_is_allocated(folder, data):
    (folder / WEIGHTS).write_bytes(data)
    refused(folder, "is damaged, or is no whole CLIP")
