"""What of a run directory no lane reaches: found by following every digest from its lanes, part and meshes."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import Any

import msgspec

from mechstyle._files import exclusive
from mechstyle.errors import DamagedStore
from mechstyle.loop.objects import MESHES, read_record
from mechstyle.loop.store import Store

DIGEST = re.compile("[0-9a-f]{64}")
NO_OBJECT = frozenset({"mesh", "name", "notes", "origin", "prompt", "surface", "tetrahedra"})
"""Fields of records that may hold a digest of something else than an object: a recipe names the meshes of its part by what they hold."""


class Garbage(msgspec.Struct, frozen=True, kw_only=True):
    """Files that can go: objects that nothing leads to, remembered results that belong to no checkpoint of a lane, and scraps.

    Scraps were being written when their process was killed. `size` are the bytes of all of them, `kept` those of what stays.
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
        BadInput: If something else than a file is in the place of a lane.
        DamagedStore: If something that a lane or the part needs is missing or cannot be read, so that nobody can say what it leads to.
    """
    store.check_lanes()
    root = store.objects.root.parent  # absolute, as are the paths of objects and memo
    held = root / "locks"
    files = [path for path in sorted(root.rglob("*")) if path.is_file() and not path.is_symlink() and path.parent != held]
    scraps = tuple(path for path in files if path.name.startswith(".new-"))
    lanes, part, start = [store.lane(name) for name in store.lanes()], store.root / "part.json", list[str]()
    for lane in lanes:
        start += filter(None, (lane.recipe, lane.head, lane.forked_from))
    if lanes or part.exists():  # it is written before the first lane
        start += _digests(read_record(part, dict[str, Any]), NO_OBJECT - {"surface"})
    reached = _reached(store, start, needed=True)
    memos = [store.memo.folder / key for key in store.memo.named()]
    unwanted = tuple(path for path in memos if not _is_kept(store, path, reached))
    for path in set(memos) - set(unwanted):
        reached |= _reached(store, _digests(path.read_text(encoding="ascii")), reached)
    stored = [path for path in files if path.is_relative_to(store.objects.root) and path not in scraps]
    objects = tuple(path for path in stored if path.parent.name + path.name not in reached)
    gone = {*scraps, *unwanted, *objects}
    size, kept = (sum(path.stat().st_size for path in some) for some in (gone, set(files) - gone))
    return Garbage(objects=objects, memo=unwanted, scraps=scraps, size=size, kept=kept)


def collect(store: Store) -> Garbage:
    """Remove what no lane reaches; what it was.

    Raises:
        BadInput: If a process is carrying a lane on or making one; as for `garbage`.
        DamagedStore: As for `garbage`; nothing is removed then.
    """
    with contextlib.ExitStack() as held:
        held.enter_context(store.branching(wait=False))  # before lanes are listed, or one could be made and carried on in between
        for lane in store.lanes():
            held.enter_context(exclusive(store.root / "locks" / f"{lane}.lock", f"lane {lane!r} of {store.root}"))
        found = garbage(store)
        for path in found.files:
            path.unlink(missing_ok=True)
        return found


def _is_kept(store: Store, path: Path, reached: set[str]) -> bool:
    """Whether a memo is of tetrahedra, of a checkpoint that is reached, a mere number, or leads to a record that is reached."""
    named = set(_digests(path.name.rpartition("-")[2])) - {path.name}
    if path.name.startswith(MESHES) or named & reached:
        return True
    objects, digests = store.objects, list(_digests(path.read_text(encoding="ascii", errors="replace")))
    return any(digest in reached or (objects.path(digest).is_file() and objects.get(digest)[:1].isdigit()) for digest in digests)


def _reached(store: Store, start: Iterable[str], known: Iterable[str] = (), *, needed: bool = False) -> set[str]:
    """Every object that can be reached from some.

    DamagedStore if one cannot be read; if one that is `needed` is missing. What is only remembered may be, as it can be made anew.
    """
    start = list(start)
    seen, ahead, missed, wanted = set(known), list(start), set(), set(start)
    while ahead:
        digest = ahead.pop()
        if digest in seen:
            continue
        seen.add(digest)
        if not store.objects.path(digest).is_file():
            missed.add(digest)
            continue
        content, record = store.objects.get(digest), None
        if content[:1] in (b"{", b'"', b"["):  # else it is an array
            try:
                record = msgspec.json.decode(content)
            except (msgspec.DecodeError, RecursionError) as error:
                raise DamagedStore(f"{store.objects.path(digest)} is no record: restore it from a copy, or start the run again") from error
        ahead += _digests(record)
        wanted.update(_digests(record, NO_OBJECT))
    for digest in sorted(missed & wanted) if needed else ():
        store.objects.get(digest)  # raises, and says which file is missing
    return seen


def _digests(value: Any, without: Collection[str] = ()) -> Iterator[str]:
    """Every digest in a record, at any depth; not those in the fields `without`."""
    if isinstance(value, str):
        if DIGEST.fullmatch(value):
            yield value
    elif isinstance(value, dict):
        for name, item in value.items():
            if name not in without:
                yield from _digests(item, without)
    elif isinstance(value, list):
        for item in value:
            yield from _digests(item, without)
