"""CLIP weights: fetched once on request, kept with their checksums, verified whenever they are used.

Only safetensors files are read, never pickled ones. A folder of one's own, as transformers saves it, is named by $MECHSTYLE_CLIP.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

from mechstyle.errors import BadInput, MissingPiece, unknown

DEFAULT = "ViT-B-32"
KNOWN = {
    "ViT-B-32": "openai/clip-vit-base-patch32",
    "ViT-B-16": "openai/clip-vit-base-patch16",
    "ViT-L-14": "openai/clip-vit-large-patch14",
    "ViT-L-14-336": "openai/clip-vit-large-patch14-336",
}
"""Names and where they are on the Hugging Face hub."""
FILES = ("config.json", "merges.txt", "model.safetensors", "vocab.json")
SUMS = "SHA256SUMS"
OWN_FOLDER = "MECHSTYLE_CLIP"

Download = Callable[[str, str, Path], str]
"""(repository, file, folder) → the SHA-256 the hub publishes for it, "" if it publishes none."""


class Weights(NamedTuple):
    """A folder of verified weights.

    Attributes:
        folder: Where it is.
        identity: `NAME@DIGEST`, the same on every machine that has the same files; this is what a recipe records.
    """

    folder: Path
    identity: str


def located(wanted: str, store: Path) -> Weights:
    """The weights of a name, of a recipe's identity, or for "" those of $MECHSTYLE_CLIP or else the default, verified.

    Args:
        wanted: `NAME`, `NAME@DIGEST` or "".
        store: Folder of fetched weights.

    Raises:
        MissingPiece: If they are not on this machine.
        BadInput: If they are damaged, or are others than those of the recipe.
    """
    name, _, digest = wanted.partition("@")
    own = os.environ.get(OWN_FOLDER, "")
    use_own = own and name in {"", Path(own).name}
    folder = Path(own) if use_own else store / (name or DEFAULT)
    if not use_own:
        if not digest and name and name not in KNOWN:
            raise unknown("CLIP model", name, KNOWN)
        if not (folder / SUMS).is_file():
            raise _missing(name or DEFAULT)
    found = verified(folder)
    if digest and found.identity != wanted:
        raise BadInput(
            f"this run was made with the CLIP weights {wanted}, but {folder} holds {found.identity}: "
            f"name the right folder with ${OWN_FOLDER}"
        )
    return found


def _missing(name: str) -> MissingPiece:
    fetch = f"fetch them once with `mechstyle weights fetch {name}`" if name in KNOWN else f"name their folder with ${OWN_FOLDER}"
    return MissingPiece(
        f"the CLIP weights {name!r} are not on this machine: {fetch}, "
        "or take a style that needs none (guidance 'offline', see `mechstyle styles`)"
    )


def verified(folder: Path) -> Weights:
    """A folder whose files are all there and are those that were fetched."""
    absent = [name for name in FILES if not (folder / name).is_file()]
    if absent:
        raise BadInput(
            f"{folder} holds no CLIP weights: {', '.join(absent)} missing; save a CLIPModel and its tokenizer there with transformers"
        )
    found = listing(folder)
    if (folder / SUMS).is_file():
        fetched = (folder / SUMS).read_text().splitlines()
        for line in found.splitlines():
            if line not in fetched:
                name = line.split()[1]
                raise BadInput(f"{folder / name} is not the file that was fetched: run `mechstyle weights fetch {folder.name}` again")
    return Weights(folder, f"{folder.name}@{hashlib.sha256(found.encode()).hexdigest()}")


def listing(folder: Path) -> str:
    """The files and their checksums as `sha256sum` writes them."""
    return "".join(f"{_sha256(folder / name)}  {name}\n" for name in FILES)


def _sha256(path: Path) -> str:
    stat = path.stat()
    return _sha256_of_version(path, stat.st_size, stat.st_mtime_ns)


@cache
def _sha256_of_version(path: Path, _size: int, _changed: int) -> str:
    """Hashing half a gigabyte takes a second, and a run asks for it more than once."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def stored(store: Path) -> list[Path]:
    """Folders of fetched weights, by name."""
    return sorted(path.parent for path in store.glob(f"*/{SUMS}"))


def fetch(name: str, store: Path, download: Download | None = None) -> Weights:
    """Fetch weights by name into the store; what is there and sound is left as it is.

    Raises:
        BadInput: If the name is unknown, or what arrived is not what the hub published.
        MissingPiece: If the hub cannot be reached.
    """
    if name not in KNOWN:
        raise unknown("CLIP model", name, KNOWN)
    folder, aside = store / name, store / f"{name}.part"
    if (folder / SUMS).is_file() and listing(folder) == (folder / SUMS).read_text():
        return verified(folder)
    aside.mkdir(parents=True, exist_ok=True)
    for file in FILES:
        published = (download or _from_hub)(KNOWN[name], file, aside)
        if published and _sha256(aside / file) != published:
            (aside / file).unlink()
            raise BadInput(f"{file} of {KNOWN[name]} arrived damaged: fetch it again")
    (aside / SUMS).write_text(listing(aside))
    shutil.rmtree(folder, ignore_errors=True)
    aside.rename(folder)
    return verified(folder)


def _from_hub(repository: str, file: str, folder: Path) -> str:
    """Download one file; of large files the hub publishes the SHA-256."""
    from huggingface_hub import HfApi, hf_hub_download  # noqa: PLC0415 — part of the optional libraries
    from huggingface_hub.errors import HfHubHTTPError, LocalEntryNotFoundError  # noqa: PLC0415

    try:
        revision = _revision_with(file, repository)
        path = hf_hub_download(repository, file, revision=revision, local_dir=folder)
        (about,) = HfApi().get_paths_info(repository, [file], revision=revision)
    except (HfHubHTTPError, LocalEntryNotFoundError, OSError) as error:
        reason = str(error).strip().splitlines()[0]
        raise MissingPiece(f"{file} of {repository} could not be fetched ({reason}): check the connection and try again") from error
    assert Path(path) == folder / file
    large = getattr(about, "lfs", None)
    return large.sha256 if large is not None else ""


def _revision_with(file: str, repository: str) -> str:
    """The main revision, or where it lacks a safetensors file the hub's own conversion of it, which is kept as a pull request."""
    from huggingface_hub import HfApi  # noqa: PLC0415

    hub = HfApi()
    if hub.file_exists(repository, file):
        return "main"
    proposals = hub.get_repo_discussions(repository, author="SFconvertbot", discussion_type="pull_request")
    revisions = (each.git_reference for each in proposals if each.git_reference)
    found = next((revision for revision in revisions if hub.file_exists(repository, file, revision=revision)), None)
    if found is None:
        raise MissingPiece(f"{repository} has no {file}, and no other kind of file is read: name a folder of your own with ${OWN_FOLDER}")
    return found
