"""A folder as `save_pretrained` of transformers writes it: which CLIP is in it, checked before any of it is believed.

The config says which tensors there must be, and the headers of the safetensors files say which there are; so nothing is allocated that
the files do not hold. Nothing is unpickled, no file outside the folder is opened, and what the config says besides sizes is left unread.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, TypeVar

import msgspec

from mechstyle.errors import BadInput

T = TypeVar("T")
Shape = tuple[int, ...]

CONFIG, WHOLE, INDEX = "config.json", "model.safetensors", "model.safetensors.index.json"
VARIANTS = ("model.safetensors.index.*.json", "model.*.safetensors")
"""Names of weights saved as a variant, such as fp16."""
TOKENIZER, VOCABULARY, MERGES = "tokenizer.json", "vocab.json", "merges.txt"
PICKLED = ("*.bin", "*.pt", "*.pth", "*.ckpt", "*.pkl")
BEGIN, END = "<|startoftext|>", "<|endoftext|>"
WORD_END = "</w>"
FLOATS = ("F64", "F32", "F16", "BF16")
LARGEST_TEXT = 32 << 20
"""Bytes of a config, vocabulary, index or header; the largest of the published CLIPs has 3.6 million."""

_Size = Annotated[int, msgspec.Meta(ge=1, le=1 << 20)]


class Tower(msgspec.Struct, frozen=True, kw_only=True):
    """Sizes of a transformer; here and below named as in config.json, where what is left out has these values."""

    hidden_size: _Size
    intermediate_size: _Size
    num_hidden_layers: _Size = 12
    num_attention_heads: _Size
    hidden_act: Literal["quick_gelu", "gelu"] = "quick_gelu"
    layer_norm_eps: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] = 1e-5


class TextTower(Tower, frozen=True, kw_only=True):
    """The transformer of words."""

    hidden_size: _Size = 512
    intermediate_size: _Size = 2048
    num_attention_heads: _Size = 8
    vocab_size: _Size = 49408
    max_position_embeddings: _Size = 77


class VisionTower(Tower, frozen=True, kw_only=True):
    """The transformer of pictures."""

    hidden_size: _Size = 768
    intermediate_size: _Size = 3072
    num_attention_heads: _Size = 12
    num_channels: Literal[3] = 3
    image_size: Annotated[int, msgspec.Meta(ge=1, le=4096)] = 224
    patch_size: _Size = 32


class Config(msgspec.Struct, frozen=True, kw_only=True):
    """Both transformers, and the length of the embeddings they share."""

    projection_dim: _Size = 512
    text_config: TextTower | None = None
    vision_config: VisionTower | None = None
    text_config_dict: TextTower | None = None
    vision_config_dict: VisionTower | None = None

    @property
    def text(self) -> TextTower:
        """The transformer of words; where an old version has written it twice, the second counts, as it did there."""
        return self.text_config_dict or self.text_config or TextTower()

    @property
    def vision(self) -> VisionTower:
        """The transformer of pictures, likewise."""
        return self.vision_config_dict or self.vision_config or VisionTower()


class Words(NamedTuple):
    """How a prompt becomes numbers: byte-pair encoding (Sennrich et al. 2016)."""

    vocabulary: dict[str, int]  # the number of every token
    merges: list[tuple[str, str]]  # pairs of tokens that become one, the most frequent first


class Pretrained(NamedTuple):
    """A folder with a whole CLIP."""

    folder: Path  # where it is
    config: Config  # its sizes
    words: Words  # its tokenizer
    tensors: dict[str, str]  # the file of every tensor it needs
    files: tuple[str, ...]  # names of the files it is made of, sorted


class _Type(msgspec.Struct):
    model_type: str = ""


class _Index(msgspec.Struct):
    weight_map: dict[str, str]


class _Model(msgspec.Struct):
    vocab: dict[str, int]
    merges: list[str | tuple[str, str]]
    type: Literal["BPE"] = "BPE"
    end_of_word_suffix: str | None = None


class _Tokenizer(msgspec.Struct):
    model: _Model


def opened(folder: Path) -> Pretrained:
    """The CLIP of a folder.

    Raises:
        BadInput: What is missing, damaged or of another kind, and what to do.
    """
    if not folder.is_dir():
        raise BadInput(f"{folder} is no folder: name the one that {CONFIG} and {WHOLE} are in")
    pickled = sorted(path.name for pattern in PICKLED for path in folder.glob(pattern))
    if pickled and not _weight_file(folder):
        way = f"save the model as {WHOLE} with CLIPModel.from_pretrained(FOLDER).save_pretrained(OTHER) of transformers"
        risk = "is pickled, and reading a pickled file can run programs"
        raise BadInput(f"{folder / pickled[0]} {risk}: where you trust it, {way}, and the tokenizer likewise")
    needed = [] if (folder / TOKENIZER).exists() else [MERGES, VOCABULARY]
    absent = sorted([*(name for name in (CONFIG, *needed) if not (folder / name).exists()), *([] if _weight_file(folder) else [WHOLE])])
    if absent:
        way = "save a CLIPModel and tokenizer there with transformers"
        raise BadInput(f"{folder} holds no CLIP weights: {', '.join(absent)} missing; {way}")
    config, (words, word_files), (found, weight_files) = _config(folder), _words(folder), _weights(folder)
    _fit(folder, config, words)
    tensors = {}  # the file of every tensor the model needs
    for tensor, shape in tensors_of(config):
        if tensor not in found:
            raise BadInput(f"{folder} holds no whole CLIP: the tensor {tensor} is missing; save a whole CLIPModel there with transformers")
        file, is_shape, kind = found[tensor]
        if is_shape != shape:
            what = f"the tensor {tensor} in {folder / file} has the shape {list(is_shape)}, but {CONFIG} asks for {list(shape)}"
            raise BadInput(f"{what}: the two belong to different models; get the folder again")
        if kind not in FLOATS:
            raise BadInput(f"the tensor {tensor} in {folder / file} is of the type {kind}: save the model in float32, float16 or bfloat16")
        tensors[tensor] = file
    for tensor in found:
        if tensor.startswith(("text_model.", "vision_model.")) and tensor not in tensors and not tensor.endswith(".position_ids"):
            raise BadInput(f"{CONFIG} in {folder} knows no tensor {tensor}: the two belong to different models; get the folder again")
    return Pretrained(folder, config, words, tensors, tuple(sorted({CONFIG, *word_files, *weight_files})))


def _config(folder: Path) -> Config:
    kind = _json(folder, CONFIG, _Type).model_type
    if kind != "clip":
        raise BadInput(f"{folder / CONFIG} is of a {kind!r} model, not of a whole 'clip': name the folder of a CLIPModel of transformers")
    config = _json(folder, CONFIG, Config)
    for tower in (config.text, config.vision):
        if tower.hidden_size % tower.num_attention_heads:
            heads = f"{tower.num_attention_heads} attention heads cannot share {tower.hidden_size} channels"
            raise BadInput(f"{folder / CONFIG} is damaged: {heads}; get the folder again")
    return config


def _words(folder: Path) -> tuple[Words, tuple[str, ...]]:
    """The tokenizer and its files: the vocabulary with its merges as older versions write them goes first, since it always did."""
    if (folder / VOCABULARY).exists() and (folder / MERGES).exists():
        lines = (line.rstrip("\r") for line in _text(folder, MERGES).split("\n"))
        merges = [line for line in lines if line and not line.startswith("#version")]
        return _paired(folder / MERGES, _json(folder, VOCABULARY, dict[str, int]), merges), (VOCABULARY, MERGES)
    model = _json(folder, TOKENIZER, _Tokenizer).model
    if model.end_of_word_suffix != WORD_END:
        raise BadInput(f"{folder / TOKENIZER} is not of CLIP, whose words end in {WORD_END!r}: save the CLIPTokenizer of the model there")
    return _paired(folder / TOKENIZER, model.vocab, model.merges), (TOKENIZER,)


def _paired(path: Path, vocabulary: dict[str, int], merges: Sequence[str | tuple[str, str]]) -> Words:
    """A tokenizer whose merges make tokens of its vocabulary out of others."""
    pairs: list[Any] = [tuple(merge.split(" ")) if isinstance(merge, str) else merge for merge in merges]
    wrong = next((pair for pair in pairs if len(pair) != 2 or not {*pair, "".join(pair)} <= vocabulary.keys()), None)
    if wrong is not None:
        raise BadInput(f"{path} is damaged: {' '.join(wrong)[:40]!r} makes no token of the vocabulary; get it again")
    return Words(vocabulary, pairs)


def _fit(folder: Path, config: Config, words: Words) -> None:
    """Refuse a tokenizer of another model."""
    numbers, size = words.vocabulary.values(), config.text.vocab_size
    absent = [token for token in (BEGIN, END) if token not in words.vocabulary]
    if absent:
        raise BadInput(f"the tokenizer in {folder} is not of CLIP: it knows no {absent[0]}; save the CLIPTokenizer of the model there")
    if not 0 <= min(numbers) <= max(numbers) < size:
        span = f"numbers its tokens {min(numbers)} to {max(numbers)}, but the model knows {size}"
        raise BadInput(f"the tokenizer in {folder} {span}: save the CLIPTokenizer of this very model there")


def _weight_file(folder: Path) -> str:
    """Name of the file of all weights, or of the index of several; "" for none."""
    variants = (path.name for pattern in VARIANTS for path in sorted(folder.glob(pattern)))
    return next((name for name in (WHOLE, INDEX) if (folder / name).exists()), "") or next(variants, "")


def _weights(folder: Path) -> tuple[dict[str, tuple[str, Shape, str]], tuple[str, ...]]:
    """File, shape and type of every tensor in the folder's weights, and the files that make them up."""
    name = _weight_file(folder)
    if not name.endswith(".json"):
        return {tensor: (name, *kind) for tensor, kind in _header(folder, name).items()}, (name,)
    places = _json(folder, name, _Index).weight_map
    headers = {file: _header(folder, file) for file in sorted(set(places.values()))}
    return {tensor: (file, *headers[file][tensor]) for tensor, file in places.items() if tensor in headers[file]}, (name, *headers)


def _header(folder: Path, name: str) -> dict[str, tuple[Shape, str]]:
    """Shape and type of every tensor of a safetensors file, from its header alone."""
    from safetensors import SafetensorError, safe_open  # noqa: PLC0415 — part of the optional libraries

    path = _path_within(folder, name)
    with path.open("rb") as begin:
        if int.from_bytes(begin.read(8), "little") > LARGEST_TEXT:
            raise BadInput(f"{folder / name} is no safetensors file: its header would be longer than any CLIP's; get it again")
    try:
        with safe_open(path, framework="numpy") as file:
            slices = {tensor: file.get_slice(tensor) for tensor in file.keys()}  # noqa: SIM118 — it is no dictionary
            return {tensor: (tuple(part.get_shape()), str(part.get_dtype())) for tensor, part in slices.items()}
    except (SafetensorError, OSError, ValueError) as error:
        raise BadInput(f"{folder / name} is damaged or was cut off ({_first_line(error)}): get it again") from error


def tensors_of(config: Config) -> Iterator[tuple[str, Shape]]:
    """Name and shape of every tensor of a CLIP (Radford et al. 2021) as transformers names them; one by one, since a config may lie."""
    text, vision = config.text, config.vision
    yield "logit_scale", ()
    yield "text_projection.weight", (config.projection_dim, text.hidden_size)
    yield "visual_projection.weight", (config.projection_dim, vision.hidden_size)
    yield "text_model.embeddings.token_embedding.weight", (text.vocab_size, text.hidden_size)
    yield "text_model.embeddings.position_embedding.weight", (text.max_position_embeddings, text.hidden_size)
    yield "vision_model.embeddings.class_embedding", (vision.hidden_size,)
    yield "vision_model.embeddings.patch_embedding.weight", (vision.hidden_size, vision.num_channels, vision.patch_size, vision.patch_size)
    yield "vision_model.embeddings.position_embedding.weight", ((vision.image_size // vision.patch_size) ** 2 + 1, vision.hidden_size)
    yield from _both("text_model.final_layer_norm", (text.hidden_size,))
    yield from _both("vision_model.pre_layrnorm", (vision.hidden_size,))
    yield from _both("vision_model.post_layernorm", (vision.hidden_size,))
    for name, tower in (("text_model", text), ("vision_model", vision)):
        for number in range(tower.num_hidden_layers):
            yield from _layer(f"{name}.encoder.layers.{number}", tower.hidden_size, tower.intermediate_size)


def _layer(name: str, width: int, inner: int) -> Iterator[tuple[str, Shape]]:
    for part in ("q_proj", "k_proj", "v_proj", "out_proj"):
        yield from _both(f"{name}.self_attn.{part}", (width, width))
    yield from _both(f"{name}.mlp.fc1", (inner, width))
    yield from _both(f"{name}.mlp.fc2", (width, inner))
    yield from _both(f"{name}.layer_norm1", (width,))
    yield from _both(f"{name}.layer_norm2", (width,))


def _both(name: str, shape: Shape) -> Iterator[tuple[str, Shape]]:
    yield f"{name}.weight", shape
    yield f"{name}.bias", shape[:1]


def _json(folder: Path, name: str, kind: type[T]) -> T:
    try:
        return msgspec.json.decode(_text(folder, name), type=kind)
    except (msgspec.MsgspecError, RecursionError) as error:
        raise BadInput(f"{folder / name} is damaged, or not what transformers saves ({_first_line(error)}): get it again") from error


def _text(folder: Path, name: str) -> str:
    path = _path_within(folder, name)
    if path.stat().st_size > LARGEST_TEXT:
        raise BadInput(f"{folder / name} has {path.stat().st_size >> 20} MiB, which no CLIP's has: name a folder that transformers saved")
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise BadInput(f"{folder / name} is damaged: it is no text; get it again") from error


def _path_within(folder: Path, name: str) -> Path:
    """The real path of a file in the folder. It may be a link within it, or to a blob of the hub's cache that the folder is part of."""
    home = folder.resolve()
    homes = {home, home.parents[1] / "blobs"} if home.parent.name == "snapshots" else {home}
    try:
        real = (home / name).resolve()
        there = Path(name).name == name and real.is_file()
    except (OSError, RuntimeError, ValueError):  # links in a circle, a name that no system allows
        real, there = home, False
    if Path(name).name != name or (there and real.parent not in homes):
        raise BadInput(f"{name!r} leads out of {folder}: put the file itself into the folder")
    if not there:
        raise BadInput(f"{folder} holds no whole CLIP: {name!r} is missing or no file; get the folder again")
    return real


def _first_line(error: Exception) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:200]
