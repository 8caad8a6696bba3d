"""CLIP weights: fetched once on request, kept with their checksums, verified whenever they are used.

A folder of one's own, as transformers saves it, may also be used where it is; $MECHSTYLE_CLIP names one for every run.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import shutil
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import NamedTuple

from mechstyle._files import write_whole
from mechstyle.errors import BadInput, MissingPiece, unknown
from mechstyle.styling.learned.pretrained import CONFIG, MERGES, VOCABULARY, WHOLE, files_of

DEFAULT = "ViT-B-32"
KNOWN = {
    "ViT-B-32": "openai/clip-vit-base-patch32", "ViT-B-16": "openai/clip-vit-base-patch16", "ViT-L-14": "openai/clip-vit-large-patch14",
    "ViT-L-14-336": "openai/clip-vit-large-patch14-336",
}  # fmt: skip
"""Names and where they are on the Hugging Face hub."""
FILES = (CONFIG, MERGES, WHOLE, VOCABULARY)
"""What is fetched of each."""
SUMS = "SHA256SUMS"
OWN_FOLDER = "MECHSTYLE_CLIP"
PLACES = ".places"
"""Folder within the store: one small file for each folder of somebody's own that was used, so that its run goes on finding it."""
IDENTITY = re.compile(r"(.*)@([0-9a-f]{64})", re.DOTALL)

Download = Callable[[str, str, Path], str]
"""(repository, file, folder) → the SHA-256 the hub publishes for it, "" if it publishes none."""


class Weights(NamedTuple):
    """A folder of verified weights."""

    folder: Path  # where it is
    identity: str  # `NAME@DIGEST`, the same on every machine that has the same files; this is what a recipe records

    @property
    def digest(self) -> str:
        """What of the identity depends on the content alone."""
        return self.identity.rpartition("@")[2]


def located(wanted: str, store: Path) -> Weights:
    """The weights of a name, a folder, a recipe's identity, or for "" those of $MECHSTYLE_CLIP or else the default, verified.

    Args:
        wanted: `NAME`, a folder, `NAME@DIGEST` or "".
        store: Folder of fetched weights.

    Raises:
        MissingPiece: If they are not on this machine.
        BadInput: If they are damaged, no CLIP at all, or others than those of the recipe.
    """
    recorded = IDENTITY.fullmatch(wanted)
    if recorded:
        name, digest = recorded.groups()
        place, own = store / PLACES / digest, os.environ.get(OWN_FOLDER, "")
        here = [Path(place.read_text()) if place.is_file() else store / name, Path(own) if own else store / name]
        for folder in here:
            if folder.is_dir() and verified(folder).digest == digest:
                return Weights(folder, wanted)
        raise _missing(name, f" {wanted}, with which this run was made,")
    found = verified(_asked_for(wanted, store))
    if found.folder.parent != store:
        write_whole(store / PLACES / found.digest, str(found.folder.resolve()).encode())
    return found


def _asked_for(wanted: str, store: Path) -> Path:
    """The folder of what a user named: weights in the store go before a folder of that name, unless it is written as a path."""
    own = os.environ.get(OWN_FOLDER, "")
    if own and wanted in {"", Path(own).name}:
        return Path(own)
    name = wanted or DEFAULT
    for folder in stored(store):
        if folder.name == name:
            return folder
    path = Path(wanted).expanduser()
    if wanted and (path.is_dir() or "/" in wanted or os.sep in wanted):
        return path
    if name not in KNOWN:
        raise unknown("CLIP model", name, {*KNOWN, *(folder.name for folder in stored(store))})
    raise _missing(name)


def _missing(name: str, which: str = "") -> MissingPiece:
    once = f"fetch them once with `mechstyle weights fetch {name}`, " if name in KNOWN else ""
    return MissingPiece(
        f"the CLIP weights{which or f' {name!r}'} are not on this machine: {once}name their folder with --clip or ${OWN_FOLDER}, "
        "or take a style that needs none (guidance 'offline', see `mechstyle styles`)"
    )


def verified(folder: Path) -> Weights:
    """A folder with the files of a CLIP; one of the store, besides, with the very files that were fetched."""
    kept = folder / SUMS
    if kept.is_file():
        for line in kept.read_text(errors="replace").splitlines():
            digest, _, name = line.partition("  ")
            if (folder / name).is_file() and _sha256(folder / name) != digest:
                raise BadInput(f"{folder / name} is not the file listed in its {SUMS}: run `mechstyle weights fetch {folder.name}` again")
    found = listing(folder, files_of(folder))
    return Weights(folder, f"{folder.resolve().name}@{hashlib.sha256(found.encode()).hexdigest()}")


def listing(folder: Path, files: Sequence[str] = FILES) -> str:
    """Files and their checksums as `sha256sum` writes them."""
    return "".join(f"{_sha256(folder / name)}  {name}\n" for name in files)


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
    folder = store / name
    if folder in stored(store):
        with suppress(BadInput):
            return verified(folder)
    aside = folder.with_name(f"{name}.part")  # where they are put together before they appear whole
    aside.mkdir(parents=True, exist_ok=True)
    for file in FILES:
        published = (download or _from_hub)(KNOWN[name], file, aside)
        if published and _sha256(aside / file) != published:
            (aside / file).unlink()
            raise BadInput(f"{file} of {KNOWN[name]} arrived damaged: fetch it again")
    (aside / SUMS).write_text(listing(aside, FILES))
    shutil.rmtree(folder, ignore_errors=True)
    aside.rename(folder)
    return verified(folder)


def _from_hub(repository: str, file: str, folder: Path) -> str:
    """Download one file; of large files the hub publishes the SHA-256."""
    from huggingface_hub import HfApi, hf_hub_download  # noqa: PLC0415 — part of the optional libraries

    hub = HfApi()
    try:
        revision = "main"
        about: object = None
        if not hub.file_exists(repository, file):  # the hub keeps its own conversion to safetensors as a pull request
            proposals = hub.get_repo_discussions(repository, author="SFconvertbot", discussion_type="pull_request")
            revisions = (each.git_reference for each in proposals if each.git_reference)
            revision = next((one for one in revisions if hub.file_exists(repository, file, revision=one)), "")
        if revision:
            hf_hub_download(repository, file, revision=revision, local_dir=folder)
            (about,) = hub.get_paths_info(repository, [file], revision=revision)
    except Exception as error:  # what a lost connection raises depends on the HTTP library that the hub's client uses
        reason = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise MissingPiece(f"{file} of {repository} could not be fetched ({reason}): check the connection and try again") from error
    if not revision:
        raise MissingPiece(f"{repository} has no {file}, and no other kind of file is read: name a folder of your own with --clip")
    large = getattr(about, "lfs", None)
    return large.sha256 if large is not None else ""


LIBRARIES = ("torch", "transformers", "safetensors")


def need_clip_extra() -> None:
    """Refuse what needs torch where it is not installed.

    Raises:
        MissingPiece: With the command that installs it and what works without.
    """
    absent = [name for name in LIBRARIES if importlib.util.find_spec(name) is None]
    if absent:
        raise MissingPiece(
            f"the network and CLIP need {', '.join(absent)}: install with `pip install 'mechstyle[clip]'`, "
            "or use the offline styles on vertices (guidance 'offline', field 'vertex'), which need neither"
        )
