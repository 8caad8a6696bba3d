"""Files that appear whole or not at all, their names, locks, and the folder of what may be deleted: prepared parts, fetched weights."""

from __future__ import annotations

import atexit
import contextlib
import errno
import functools
import os
import re
import secrets
import shutil
import socket
import sys
import tempfile
import unicodedata
from collections.abc import Iterator
from pathlib import Path

from mechstyle.errors import BadInput, MechStyleError

if sys.platform != "win32":
    import fcntl

NO_FILE_NAME = re.compile(r'[<>:"/\\|?*]')
"""What Windows or any other system gives a meaning of its own in a path."""
DEVICES = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9])\s*(\.|$)", re.IGNORECASE)
"""Names that Windows keeps for devices, with any suffix."""
LONGEST_STEM = 120
"""Of the 255 bytes that most file systems give a name; the rest is for lane, iteration and suffix."""


def file_stem(name: str) -> str:
    """A name as the first part of the name of a file, on any system: no folder, no drive, no device, not empty, not too long.

    Names of parts come from people and from run folders that others made, so no name is used in a path without this.

    Args:
        name: Any text.
    """
    letters = (letter if unicodedata.category(letter)[0] != "C" else " " for letter in NO_FILE_NAME.sub("_", name))
    stem = "".join(letters).strip(" .")
    stem = f"_{stem}" if DEVICES.match(stem) else stem
    stem = stem.encode()[:LONGEST_STEM].decode(errors="ignore").strip(" .")
    return stem if stem.strip("_ .") else "part"


def write_whole(path: Path, data: bytes) -> None:
    """Write a file so that it appears whole or not at all; MechStyleError in one sentence if the disk refuses."""
    try:
        write_aside(path, data)
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        why = "the disk is full" if full else (error.strerror or str(error))
        remedy = "free some space" if full else "make the folder writable or choose another place"
        raise MechStyleError(f"could not write {path}: {why}; everything saved before is intact, {remedy} and run again") from error


def write_aside(path: Path, data: bytes) -> None:
    """As `write_whole`, for callers with a sentence of their own: written beside `path`, then renamed over it; OSError if refused."""
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(f".new-{secrets.token_hex(8)}")  # named before it exists, so that whoever is ended knows what to remove
    try:
        with aside.open("xb") as file:
            file.write(data)
        aside.chmod(0o644)  # whatever this process may keep to itself, what is written is for sharing
        aside.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            aside.unlink(missing_ok=True)
        raise


def cache_folder() -> Path:
    """Folder of prepared parts: $MECHSTYLE_CACHE, else the user's cache folder; safe to delete.

    Where it cannot be written to, a temporary one for as long as this process lasts: nothing that is asked for may fail for a cache.
    """
    wished = _wished_folder()
    with contextlib.suppress(OSError):
        wished.mkdir(parents=True, exist_ok=True)
    return wished if os.access(wished, os.W_OK) else _temporary_folder()


@functools.cache
def _temporary_folder() -> Path:
    folder = tempfile.mkdtemp(prefix="mechstyle-cache-")  # a new one: a name others can guess could be theirs already
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def _wished_folder() -> Path:
    given = os.environ.get("MECHSTYLE_CACHE")
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(given) if given else Path(base) / "mechstyle"


def clip_folder() -> Path:
    """Folder of fetched CLIP weights."""
    return _wished_folder() / "clip"


@contextlib.contextmanager
def exclusive(path: Path, what: str, *, wait: bool = False) -> Iterator[None]:
    """Hold the lock `path` on `what` while the block runs; if somebody else holds it, wait for the end of that or refuse.

    The lock is the system's (flock), so it ends with its process, however that ends: the file of a process that was killed is taken
    over. The file holds the process and the host for the sentence that others get, and is empty while nobody holds it. It is never
    removed, or one process could lock the file that another has just unlinked.

    Raises:
        BadInput: If somebody else holds it, another session of this process included, and this does not wait; or if `path` is a link.
    """
    if path.is_symlink():  # in a folder from somebody else it could lead to a file of the user's, which would be emptied
        raise BadInput(f"{path} is a link, which no lock is: remove it if you do not know what it is for")
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a+", encoding="utf-8") as file:
        _lock(file.fileno(), path, what, wait=wait)
        try:
            _write(file.fileno(), f"process {os.getpid()} on {socket.gethostname()}")
            yield
        finally:
            _write(file.fileno(), "")


def _lock(descriptor: int, path: Path, what: str, *, wait: bool) -> None:
    """Lock an open file; on Windows, or where the file system knows no locks, nobody is kept out."""
    if sys.platform == "win32":
        return
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        holder = path.read_text(encoding="utf-8") or "another process"
        raise BadInput(f"{what} is being carried on by {holder}: wait until it ends, or stop it there") from error
    except OSError:
        return


def _write(descriptor: int, holder: str) -> None:
    """Say in the file who holds the lock; a full disk does not matter here."""
    with contextlib.suppress(OSError):
        os.ftruncate(descriptor, 0)
        os.write(descriptor, holder.encode())
