"""A folder as `save_pretrained` of transformers writes it: the files of the CLIP in it, looked at before transformers reads them.

Nothing is unpickled, and no file outside the folder is opened. What the files must hold is checked when they are loaded, by `Clip.load`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from mechstyle.errors import BadInput

CONFIG, WHOLE, INDEX = "config.json", "model.safetensors", "model.safetensors.index.json"
TOKENIZER, VOCABULARY, MERGES = "tokenizer.json", "vocab.json", "merges.txt"
PICKLED = ("*.bin", "*.pt", "*.pth", "*.ckpt", "*.pkl")
LARGEST_TEXT = 32 << 20
"""Bytes of a config, vocabulary or index; the largest of the published CLIPs has 3.6 million."""


def files_of(folder: Path) -> tuple[str, ...]:
    """Names of the files that the CLIP of a folder is made of, sorted.

    Raises:
        BadInput: What is missing, too large or elsewhere, and what to do.
    """
    if not folder.is_dir():
        raise BadInput(f"{folder} is no folder: name the one that {CONFIG} and {WHOLE} are in")
    weights = next((name for name in (WHOLE, INDEX) if (folder / name).exists()), "")
    pickled = sorted(path.name for pattern in PICKLED for path in folder.glob(pattern))
    if pickled and not weights:
        way = f"save the model as {WHOLE} with CLIPModel.from_pretrained(FOLDER).save_pretrained(OTHER) of transformers"
        risk = "is pickled, and reading a pickled file can run programs"
        raise BadInput(f"{folder / pickled[0]} {risk}: where you trust it, {way}, and the tokenizer likewise")
    alone = (folder / TOKENIZER).exists() and not ((folder / VOCABULARY).exists() and (folder / MERGES).exists())
    words = [TOKENIZER] if alone else [VOCABULARY, MERGES]
    needed = [CONFIG, *words, weights or WHOLE]
    absent = sorted(name for name in needed if not (folder / name).exists())
    if absent:
        way = "save a CLIPModel and tokenizer there with transformers"
        raise BadInput(f"{folder} holds no CLIP weights: {', '.join(absent)} missing; {way}")
    if weights == INDEX:
        needed += sorted(set(map(str, read_json(folder, INDEX)["weight_map"].values())))
    for name in needed:
        _path_within(folder, name)
    return tuple(sorted(needed))


def read_json(folder: Path, name: str) -> dict[str, Any]:
    """The record of a JSON file of a folder; BadInput if it is none."""
    path = _path_within(folder, name)
    try:
        record = json.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError) as error:
        raise damaged(folder / name, error) from error
    if not isinstance(record, dict) or not isinstance(record.get("weight_map", {}), dict):
        raise damaged(folder / name, "it is no record")
    return record


def damaged(path: Path, why: object) -> BadInput:
    """The refusal of a file or folder whose content is not what transformers saves."""
    reason = (str(why).strip().splitlines() or [type(why).__name__])[0][:200]
    return BadInput(f"{path} is damaged, or is no whole CLIP as transformers saves it ({reason}): get it again")


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
    if real.stat().st_size > LARGEST_TEXT and not name.endswith(".safetensors"):
        raise BadInput(f"{folder / name} has {real.stat().st_size >> 20} MiB, which no CLIP's has: name a folder that transformers saved")
    return real
