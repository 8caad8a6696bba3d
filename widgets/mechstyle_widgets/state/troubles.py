"""Every error of a handler as one sentence with one thing to do: what ends in a log only, nobody in front of a page hears of."""

from __future__ import annotations

import errno
import logging
from pathlib import Path

from mechstyle.errors import MechStyleError

logger = logging.getLogger(__name__)
FULL = (errno.ENOSPC, errno.EDQUOT)


def sentence(error: BaseException | None, folder: Path | None = None) -> str:
    """An error in one sentence; once the folder of the run on show is gone, whatever is asked of it fails by that."""
    if folder is not None and not folder.is_dir():
        return gone(folder)
    if isinstance(error, MechStyleError):
        return str(error)
    if isinstance(error, OSError):
        return _of_the_machine(error)
    if isinstance(error, MemoryError):
        return "There is not enough memory: ask for fewer vertices."
    logger.error("unexpected", exc_info=error)
    return f"This did not work, by an unexpected {type(error).__name__}: {error}. What was made is kept."


def gone(folder: Path) -> str:
    """That the folder of a run is gone."""
    return f"The folder {folder.name} is gone: put it back, or press Run to make it again."


def _of_the_machine(error: OSError) -> str:
    name = Path(str(error.filename)).name if error.filename else "a file"
    if error.errno in FULL:
        return "The disk is full: make room and try again. What was made before is kept."
    if isinstance(error, FileNotFoundError):
        return f"{name} is gone: put it back, or choose another."
    if isinstance(error, PermissionError):
        return f"{name} may not be read or written here: choose another folder under Drop test."
    return f"{name} cannot be read or written: {error.strerror or error}."
