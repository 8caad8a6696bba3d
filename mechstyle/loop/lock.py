"""A lock file that admits one process at a time, names its holder and ends with its process."""

from __future__ import annotations

import contextlib
import os
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

from mechstyle.errors import BadInput

if sys.platform != "win32":
    import fcntl


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
