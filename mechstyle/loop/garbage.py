"""What of a run directory no lane reaches: found by following every digest from its lanes, part and meshes."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import msgspec

from mechstyle.errors import DamagedStore
from mechstyle.loop.lock import exclusive
from mechstyle.loop.objects import MESHES, read_record
from mechstyle.loop.store import Store

DIGEST = re.compile("[0-9a-f]{64}")


class Garbage(msgspec.Struct, frozen=True, kw_only=True):
    """Files that can go.

    Attributes:
        objects: Objects that nothing leads to.
        memo: Remembered results that belong to no checkpoint of a lane.
        scraps: Files that were being written when their process was killed.
        size: Bytes of all of them.
        kept: Bytes of what stays.
    """

    objects: tuple[Path, ...]
    memo: tuple[Path, ...]
    scraps: tuple[Path, ...]
    size: int
    kept: int

    @property
    def files(self) -> tuple[Path, ...]:
        """All of them, in an order in which what is left is whole at any moment: names go before what they name."""
        return (*self.memo, *self.objects, *self.scraps)


def garbage(store: Store) -> Garbage:
    """What can go.

    Raises:
        DamagedStore: If a record that a lane needs cannot be read, so that nobody can say what it leads to.
    """
    held = store.root / "locks"
    files = [path for path in sorted(store.root.rglob("*")) if path.is_file() and not path.is_symlink() and path.parent != held]
    scraps = tuple(path for path in files if path.name.startswith(".new-"))
    reached = _reached(store, _roots(store))
    unwanted = tuple(path for path in _memos(store) if not _is_kept(store, path, reached))
    for path in set(_memos(store)) - set(unwanted):
        reached |= _reached(store, _digests(path.read_text(encoding="ascii")), reached)
    stored = [path for path in files if path.is_relative_to(store.objects.root) and path not in scraps]
    objects = tuple(path for path in stored if path.parent.name + path.name not in reached)
    gone = {*scraps, *unwanted, *objects}
    size, kept = (sum(path.stat().st_size for path in some) for some in (gone, set(files) - gone))
    return Garbage(objects=objects, memo=unwanted, scraps=scraps, size=size, kept=kept)


def collect(store: Store) -> Garbage:
    """Remove what no lane reaches; what it was.

    Raises:
        BadInput: If a process is carrying a lane on.
        DamagedStore: As for `garbage`; nothing is removed then.
    """
    with contextlib.ExitStack() as held:
        for lane in (".branches", *store.lanes()):
            held.enter_context(exclusive(store.root / "locks" / f"{lane}.lock", f"lane {lane!r} of {store.root}"))
        found = garbage(store)
        for path in found.files:
            path.unlink(missing_ok=True)
        return found


def _roots(store: Store) -> Iterator[str]:
    """Digests that lanes and the part name."""
    for name in store.lanes():
        lane = store.lane(name)
        yield from filter(None, (lane.recipe, lane.head, lane.forked_from))
    part = store.root / "part.json"
    if part.exists():
        yield from _digests(read_record(part, dict[str, Any]))


def _memos(store: Store) -> list[Path]:
    return [store.memo.folder / key for key in store.memo.named()]


def _is_kept(store: Store, path: Path, reached: set[str]) -> bool:
    """Whether a memo is of tetrahedra, of a checkpoint that is reached, a mere number, or leads to a record that is reached."""
    named = set(_digests(path.name.rpartition("-")[2])) - {path.name}
    if path.name.startswith(MESHES) or named & reached:
        return True
    digests = list(_digests(path.read_text(encoding="ascii", errors="replace")))
    return any(digest in reached or _is_number(store, digest) for digest in digests)


def _is_number(store: Store, digest: str) -> bool:
    return store.objects.path(digest).is_file() and store.objects.get(digest)[:1].isdigit()


def _reached(store: Store, start: Iterable[str], known: Iterable[str] = ()) -> set[str]:
    """Every object that can be reached from some."""
    seen, ahead = set(known), list(start)
    while ahead:
        digest = ahead.pop()
        if digest in seen:
            continue
        seen.add(digest)
        if not store.objects.path(digest).is_file():
            continue  # the digest of a surface, which names no object, or a loss that gc neither made nor mends
        content = store.objects.get(digest)
        if content[:1] in (b"{", b'"', b"["):
            try:
                ahead += _digests(msgspec.json.decode(content))
            except (msgspec.DecodeError, RecursionError) as error:
                raise DamagedStore(f"{store.objects.path(digest)} is no record: restore it from a copy, or start the run again") from error
    return seen


def _digests(value: Any) -> Iterator[str]:
    """Every digest in a record, at any depth."""
    if isinstance(value, str):
        if DIGEST.fullmatch(value):
            yield value
    elif isinstance(value, dict | list):
        for item in value.values() if isinstance(value, dict) else value:
            yield from _digests(item)
