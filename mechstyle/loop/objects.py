"""Immutable objects named by the SHA-256 of their content, records as JSON, and a memo of deterministic computations.

Arrays are kept as `.npy` bytes and records as JSON, each zlib-compressed; nothing is ever unpickled.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import math
import re
import stat
import threading
import tokenize
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle._files import write_whole
from mechstyle.errors import DamagedStore
from mechstyle.records.mesh import SurfaceMesh, TetMesh

T = TypeVar("T")
M = TypeVar("M", SurfaceMesh, TetMesh)

MOST_BYTES = 256_000_000
"""Of an object once it is unpacked, and of a record in a file of its own: a small file can unpack to a thousand times its size."""

MESHES = UNDEFORMED, MESH_FOR, MESH, LAST_MESH, TESTED_ON = "rest-", "mesh-for-", "mesh-", "mesh-of-", "mesh-carrying-"
"""What a memo calls tetrahedra, which cannot be made the same again, before a digest: of an unstylized surface by its own, made for a
relief by that, by their own, last made for a recipe by that, and those a relief is tested on by the question."""


def to_json(record: object, enc_hook: Callable[[Any], Any] | None = None) -> bytes:
    """A Struct, a dataclass or plain values as JSON; `enc_hook` turns others into these.

    NaN and the infinities, for which JSON has no number, become words that `from_json` reads back.
    """
    return msgspec.json.encode(_spelled(msgspec.to_builtins(record, enc_hook=enc_hook, order="deterministic")))


_KNOWN: set[Any] = set()
_LEARNING = threading.Lock()


def from_json(data: bytes, kind: type[T], dec_hook: Callable[[type, Any], Any] | None = None) -> T:
    """Read a record that `to_json` wrote; msgspec.DecodeError if it is no such record.

    msgspec (0.22) learns what a kind of record is made of when it first reads one, and ends the whole process if another thread reads one
    meanwhile. So each kind is learnt by one thread, before any reads it.
    """
    if kind not in _KNOWN:
        with _LEARNING:
            msgspec.json.Decoder(kind)
            _KNOWN.add(kind)
    return msgspec.json.decode(data, type=kind, dec_hook=dec_hook, strict=False)


UNREADABLE = (
    msgspec.DecodeError, ValueError, KeyError, EOFError, OverflowError, MemoryError, RecursionError, SyntaxError, tokenize.TokenError,
)  # fmt: skip
"""What reading JSON, an array or a mesh raises if the bytes are no such thing, or are one that somebody forged."""


@contextlib.contextmanager
def _read_as(what: str, path: Path) -> Iterator[None]:
    """Turn what reading raises into DamagedStore, which names the file."""
    try:
        yield
    except UNREADABLE as error:
        why = str(error) or type(error).__name__
        raise DamagedStore(f"{path} is not {what}: {why}; restore it from a copy, or start the run again") from error


def read_record(path: Path, kind: type[T]) -> T:
    """A record in a file of its own; DamagedStore if the file is missing or is no such record."""
    try:
        _check_is_a_file(path)
        if path.stat().st_size > MOST_BYTES:
            raise DamagedStore(f"{path} is larger than any record is: restore it from a copy, or start the run again")
        data = path.read_bytes()
    except OSError as error:
        raise DamagedStore(f"{path} is missing or unreadable: restore it from a copy, or start the run again") from error
    with _read_as(f"a {kind.__name__}", path):
        return from_json(data, kind)


def _check_is_a_file(path: Path) -> None:
    """Refuse a folder, and a pipe, which would be read for ever, in the place of a file; OSError if nothing is there."""
    if not stat.S_ISREG(path.stat().st_mode):
        raise DamagedStore(f"{path} is not a file: restore it from a copy, or start the run again")


def _spelled(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _spelled(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_spelled(item) for item in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def _array(content: bytes) -> NDArray[Any]:
    """The array of `.npy` bytes; ValueError if they claim more, or less, than they hold."""
    buffer = io.BytesIO(content)
    header = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    shape, _, kind = header[np.lib.format.read_magic(buffer)](buffer)
    if kind.hasobject or math.prod(shape) * kind.itemsize != len(content) - buffer.tell():
        raise ValueError("it claims to hold other numbers than it does")
    buffer.seek(0)
    array: NDArray[Any] = np.load(buffer, allow_pickle=False)
    return array


@dataclass(eq=False)
class Objects:
    """A folder, which need not exist yet, of immutable objects named by the SHA-256 of their uncompressed content."""

    root: Path

    def path(self, digest: str) -> Path:
        """Path of an object, whether it exists or not."""
        return self.root / digest[:2] / digest[2:]

    def put(self, content: bytes) -> str:
        """Store bytes, once; return their digest. A damaged object of the same name is mended."""
        digest = hashlib.sha256(content).hexdigest()
        try:
            self.get(digest)
        except DamagedStore:
            write_whole(self.path(digest), zlib.compress(content, 1))
        return digest

    def get(self, digest: str) -> bytes:
        """The bytes of an object, verified; DamagedStore if it is missing or does not match its name."""
        if not re.fullmatch("[0-9a-f]{64}", digest):  # or it could be a path
            raise DamagedStore(f"{self.root.parent} names an object {digest[:80]!r}, which is no SHA-256: start the run again")
        stream, lost = zlib.decompressobj(), f"{self.path(digest)} is missing or unreadable: restore it from a copy, or start the run again"
        try:
            _check_is_a_file(self.path(digest))
            with self.path(digest).open("rb") as file:
                content = stream.decompress(file.read(MOST_BYTES), MOST_BYTES)
        except (OSError, zlib.error) as error:
            raise DamagedStore(lost) from error
        if not stream.eof:  # cut off, or larger than any object is
            raise DamagedStore(lost)
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
        content = self.get(digest)
        with _read_as("an array", self.path(digest)):
            return _array(content)

    def put_record(self, record: object) -> str:
        """Store a record; arrays inside become objects of their own, so equal arrays are kept once."""

        def stored(value: object) -> str:
            if isinstance(value, np.ndarray):
                return self.put_array(value)
            raise TypeError(f"cannot store a {type(value).__name__}")

        return self.put(to_json(record, stored))

    def get_record(self, digest: str, kind: type[T]) -> T:
        """A record of the given type; DamagedStore if it is not one."""
        content = self.get(digest)
        with _read_as(f"a {kind.__name__}", self.path(digest)):
            return from_json(content, kind, lambda _, name: self.get_array(name))

    def put_mesh(self, mesh: SurfaceMesh | TetMesh) -> str:
        """Store a mesh as its two arrays; colours are kept by checkpoints, not here."""
        cells = mesh.faces if isinstance(mesh, SurfaceMesh) else mesh.tets
        return self.put_record({"vertices": mesh.vertices, "cells": cells})

    def get_mesh(self, digest: str, kind: type[M]) -> M:
        """A mesh as it was stored."""
        table = self.get_record(digest, dict[str, str])
        with _read_as(f"a {kind.__name__}", self.path(digest)):
            return kind(self.get_array(table["vertices"]), self.get_array(table["cells"]))


@dataclass(eq=False)
class Memo:
    """Results of deterministic computations by the digest of their inputs: the index in a folder, the results among objects."""

    folder: Path
    objects: Objects

    def named(self, beginning: str = "") -> list[str]:
        """Names of what is remembered that begin so, in order."""
        return sorted(path.name for path in self.folder.glob(f"{beginning}*") if not path.name.startswith(".") and path.is_file())

    def recall(self, key: str, kind: type[T]) -> T | None:
        """The stored result for `key`, or None if there is none that can be read."""
        with contextlib.suppress(OSError, ValueError, DamagedStore):  # ValueError: the index is neither ASCII nor a path
            _check_is_a_file(self.folder / key)
            return self.objects.get_record((self.folder / key).read_text(encoding="ascii"), kind)
        return None

    def remember(self, key: str, result: object, *, anew: bool = False) -> None:
        """Store the result of the inputs named by `key`, unless it is there already and can be read; `anew` even then."""
        if anew or self.recall(key, type(result)) is None:
            write_whole(self.folder / key, self.objects.put_record(result).encode("ascii"))


class Memos(NamedTuple):
    """Several memos, the most trusted first: others may have written a run folder, so only what is computed here is for all of them."""

    all: tuple[Memo, ...]

    def recall(self, key: str, kind: type[T]) -> T | None:
        """As that of the first memo that knows; the last then knows, too."""
        found = next((one for memo in self.all if (one := memo.recall(key, kind)) is not None), None)
        if found is not None:
            self.all[-1].remember(key, found)
        return found

    def remember(self, key: str, result: object) -> None:
        """Store what was computed here in all of them."""
        for memo in self.all:
            memo.remember(key, result)
