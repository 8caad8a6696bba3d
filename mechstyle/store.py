"""The run on disk: objects named by the SHA-256 of their content, one movable reference per lane, and a memo of simulations.

Layout of a run directory:

    objects/ab/cdef…    arrays (.npy bytes) and records (JSON), each zlib-compressed, never changed once written
    lanes/main.json     where a lane stands: its recipe, its newest checkpoint, where it was forked
    memo/0123…          digest of the result of a computation, named by the digest of its inputs
    locks/main.lock     which process carries the lane on

Everything is written aside and renamed, so a process killed at any moment loses at most the iteration in flight.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import io
import math
import os
import re
import tempfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import BadInput, DamagedStore, MechStyleError, unknown
from mechstyle.mesh import SurfaceMesh, TetMesh
from mechstyle.records import Checkpoint, Recipe, Verdict

T = TypeVar("T")
M = TypeVar("M", SurfaceMesh, TetMesh)


class Lane(msgspec.Struct, frozen=True, kw_only=True):
    """Where one line of iterations stands.

    Attributes:
        recipe: Digest of the recipe its new iterations follow.
        head: Digest of its newest checkpoint, "" before the first.
        forked_from: Digest of the checkpoint it was branched at, "" for an original line.
    """

    recipe: str
    head: str = ""
    forked_from: str = ""


class Entry(msgspec.Struct, frozen=True, kw_only=True):
    """A checkpoint without its arrays: what a log needs. Fields as in `Checkpoint`."""

    iteration: int
    parent: str
    recipe: str
    simulated_at: int
    style_loss: float
    reason: str
    verdict: Verdict | None
    final: bool
    digest: str = ""


def write_aside(path: Path, data: bytes) -> None:
    """Write `data` beside `path`, then rename over it; MechStyleError in one sentence if the disk refuses."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=".new-")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            Path(name).chmod(0o644)  # temporary files are private, runs are for sharing
            Path(name).replace(path)
        except BaseException:
            with contextlib.suppress(OSError):
                Path(name).unlink(missing_ok=True)
            raise
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        why = "the disk is full" if full else (error.strerror or str(error))
        remedy = "free some space" if full else "make the folder writable"
        raise MechStyleError(f"could not write {path}: {why}; everything saved before is intact, {remedy} and run again") from error


def to_json(record: object, enc_hook: Callable[[Any], Any] | None = None) -> bytes:
    """A record as JSON. NaN and the infinities, for which JSON has no number, become words that `from_json` reads back.

    Args:
        record: A msgspec Struct, a dataclass or plain values.
        enc_hook: Turns what is none of these into something that is.
    """
    return msgspec.json.encode(_spelled(msgspec.to_builtins(record, enc_hook=enc_hook, order="deterministic")))


def from_json(data: bytes, kind: type[T], dec_hook: Callable[[type, Any], Any] | None = None) -> T:
    """What `to_json` wrote; msgspec.DecodeError if it is no such record."""
    return msgspec.json.decode(data, type=kind, dec_hook=dec_hook, strict=False)


def _spelled(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _spelled(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_spelled(item) for item in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


class Objects:
    """A folder of immutable objects named by the SHA-256 of their uncompressed content."""

    def __init__(self, root: Path) -> None:
        """Use `root`, which need not exist yet."""
        self.root = root

    def path(self, digest: str) -> Path:
        """Where an object lies or would lie."""
        return self.root / digest[:2] / digest[2:]

    def put(self, content: bytes) -> str:
        """Store bytes, once; return their digest. A damaged object of the same name is mended."""
        digest = hashlib.sha256(content).hexdigest()
        try:
            self.get(digest)
        except DamagedStore:
            write_aside(self.path(digest), zlib.compress(content, 1))
        return digest

    def get(self, digest: str) -> bytes:
        """The bytes of an object, verified; DamagedStore if it is missing or does not match its name."""
        try:
            content = zlib.decompress(self.path(digest).read_bytes())
        except (OSError, zlib.error) as error:
            raise DamagedStore(f"{self.path(digest)} is missing or unreadable: restore it from a copy, or start the run again") from error
        if hashlib.sha256(content).hexdigest() != digest:
            raise DamagedStore(
                f"{self.path(digest)} does not have the content its name promises: restore it from a copy, or start the run again"
            )
        return content

    def put_array(self, array: NDArray[Any]) -> str:
        """Store an array with its type and shape."""
        buffer = io.BytesIO()
        np.save(buffer, np.ascontiguousarray(array), allow_pickle=False)
        return self.put(buffer.getvalue())

    def get_array(self, digest: str) -> NDArray[Any]:
        """An array as it was stored."""
        array: NDArray[Any] = np.load(io.BytesIO(self.get(digest)), allow_pickle=False)
        return array

    def put_record(self, record: object) -> str:
        """Store a record; arrays inside become objects of their own, so equal arrays are kept once."""
        return self.put(to_json(record, self._array_to_digest))

    def get_record(self, digest: str, kind: type[T]) -> T:
        """A record of the given type; DamagedStore if it is not one."""
        try:
            return from_json(self.get(digest), kind, lambda _, name: self.get_array(name))
        except msgspec.DecodeError as error:
            raise DamagedStore(f"{self.path(digest)} is not a {kind.__name__}: {error}") from error

    def _array_to_digest(self, value: object) -> str:
        if isinstance(value, np.ndarray):
            return self.put_array(value)
        raise TypeError(f"cannot store a {type(value).__name__}")

    def put_mesh(self, mesh: SurfaceMesh | TetMesh) -> str:
        """Store a mesh as its two arrays; colours are kept by checkpoints, not here."""
        cells = mesh.faces if isinstance(mesh, SurfaceMesh) else mesh.tets
        return self.put_record({"vertices": mesh.vertices, "cells": cells})

    def get_mesh(self, digest: str, kind: type[M]) -> M:
        """A mesh as it was stored."""
        table = self.get_record(digest, dict[str, str])
        return kind(self.get_array(table["vertices"]), self.get_array(table["cells"]))


class Memo:
    """Results of deterministic computations by the digest of their inputs, kept beside their objects."""

    def __init__(self, folder: Path, objects: Objects) -> None:
        """Keep the index in `folder`, results in `objects`."""
        self.folder = folder
        self.objects = objects

    def recall(self, key: str, kind: type[T]) -> T | None:
        """The stored result for `key`, or None if there is none that can be read."""
        with contextlib.suppress(OSError, ValueError, DamagedStore):  # ValueError: the index is neither ASCII nor a path
            return self.objects.get_record((self.folder / key).read_text(encoding="ascii"), kind)
        return None

    def remember(self, key: str, result: object) -> None:
        """Store the result of the inputs named by `key`, unless it is there already and can be read."""
        if self.recall(key, type(result)) is None:
            write_aside(self.folder / key, self.objects.put_record(result).encode("ascii"))


class Store:
    """One run directory: checkpoints, lanes, recipes, meshes and the memo of its simulations."""

    def __init__(self, root: str | Path) -> None:
        """Use `root`, which is created by the first write."""
        self.root = Path(root)
        self.objects = Objects(self.root / "objects")
        self.memo = Memo(self.root / "memo", self.objects)

    @classmethod
    def open(cls, root: str | Path) -> Store:
        """An existing run directory, or BadInput."""
        store = cls(root)
        if not store.lanes():
            raise BadInput(f"{root} is not a run directory: it holds no lanes/*.json; give the folder that `mechstyle run --out` wrote")
        return store

    def lanes(self) -> tuple[str, ...]:
        """Names of the lanes, `main` first, then in order of name."""
        names = sorted(path.stem for path in (self.root / "lanes").glob("*.json"))
        return tuple(sorted(names, key=lambda name: name != "main"))

    def lane(self, name: str = "main") -> Lane:
        """Where a lane stands; BadInput for a lane that is not there."""
        path = self.root / "lanes" / f"{name}.json"
        if not path.is_file():
            raise unknown(f"lane in {self.root}", name, self.lanes())
        try:
            return msgspec.json.decode(path.read_bytes(), type=Lane)
        except msgspec.DecodeError as error:
            raise DamagedStore(f"{path} cannot be read: {error}") from error

    def move(self, name: str, lane: Lane) -> None:
        """Point a lane somewhere; names are letters, digits, dots, dashes and underscores, but no number: `DIR@120` is an iteration."""
        if name.isdigit() or not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]*", name):
            rest = "hold only letters, digits, '.', '-' and '_', and not be a number"
            raise BadInput(f"lane name {name!r} must begin with a letter or digit, {rest}")
        write_aside(self.root / "lanes" / f"{name}.json", msgspec.json.encode(lane))

    def put_recipe(self, recipe: Recipe) -> str:
        """Store a recipe; its digest is the recipe's own."""
        return self.objects.put(msgspec.json.encode(recipe, order="deterministic"))

    def recipe(self, digest: str) -> Recipe:
        """A stored recipe."""
        return self.objects.get_record(digest, Recipe)

    def put_checkpoint(self, checkpoint: Checkpoint) -> str:
        """Store a checkpoint; return its digest, which is the same for the same state and past."""
        return self.objects.put_record(checkpoint)

    def checkpoint(self, digest: str) -> Checkpoint:
        """A stored checkpoint with its arrays."""
        return self.objects.get_record(digest, Checkpoint)

    def entry(self, digest: str) -> Entry:
        """A stored checkpoint without its arrays."""
        return msgspec.structs.replace(self.objects.get_record(digest, Entry), digest=digest)

    def is_finished(self, name: str = "main") -> bool:
        """Whether a lane's newest checkpoint is the end of the recipe in force."""
        lane = self.lane(name)
        if not lane.head:
            return False
        entry = self.entry(lane.head)
        return entry.final and entry.recipe == lane.recipe

    def history(self, lane: str = "main") -> list[Entry]:
        """All checkpoints of a lane, its inherited past included, oldest first."""
        return list(self._past(self.lane(lane).head))[::-1]

    def _past(self, digest: str) -> Iterator[Entry]:
        while digest:
            entry = self.entry(digest)
            yield entry
            digest = entry.parent

    def find(self, iteration: int | None, lane: str = "main") -> Entry:
        """The newest checkpoint of an iteration in a lane (None: its head); BadInput says which iterations there are."""
        history = self.history(lane)
        if not history:
            raise BadInput(f"lane {lane!r} in {self.root} has no checkpoint yet")
        if iteration is None:
            return history[-1]
        for entry in reversed(history):
            if entry.iteration == iteration:
                return entry
        raise BadInput(
            f"iteration {iteration} is not in lane {lane!r} of {self.root}: it holds {history[0].iteration} to {history[-1].iteration}"
        )


def parse_address(address: str) -> tuple[Path, str, int | None]:
    """Split `DIR`, `DIR@ITERATION`, `DIR@LANE` or `DIR@LANE:ITERATION` into directory, lane and iteration; a folder of that name is DIR."""
    root, at, place = address.rpartition("@")
    if not at or "/" in place or "\\" in place or Path(address).is_dir():  # an @ in the name of a folder is no address
        return Path(address), "main", None
    lane, colon, number = place.rpartition(":")
    if not (colon or re.fullmatch("[0-9]+", number)):
        lane, number = number, ""
    if not re.fullmatch("[0-9]*", number):
        raise BadInput(f"{address!r}: {number!r} is not an iteration; write DIR@120 or DIR@lane:120")
    return Path(root), lane or "main", int(number) if number else None
