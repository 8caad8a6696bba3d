"""A disk that fails: the steps by which `mechstyle._files` puts a file in its place, each of which can be the last or be refused.

Every file of a run directory is written by `_files.write_aside`: a file is created beside its place, filled, and renamed. `failing_at`
counts these steps and
lets one of them go wrong: the process dies there (SIGKILL, half of the bytes written), or the system refuses (ENOSPC, EIO, EROFS).
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Self
from unittest import mock

KILLED = "killed"
REFUSALS = {"ENOSPC": errno.ENOSPC, "EIO": errno.EIO, "EROFS": errno.EROFS}
"""What a system may say instead of writing: the disk is full, is broken, cannot be written to."""
STEPS = ("create", "fill", "rename")


class Steps:
    """Counts the steps of writing and goes wrong at one of them."""

    def __init__(self, fault: str = "", at: int = -1, *, lasting: bool = False) -> None:
        """Go wrong with a fault at a step, counted from 0; `lasting` from there on."""
        self.fault, self.at, self.lasting, self.taken = fault, at, lasting, 0

    def here(self) -> bool:
        """Whether the step that is taken now goes wrong; it is counted."""
        number, self.taken = self.taken, self.taken + 1
        return bool(self.fault) and (number == self.at or (self.lasting and number > self.at >= 0))

    def go_wrong(self, path: str) -> None:
        """Die, or refuse."""
        if self.fault == KILLED:
            os.kill(os.getpid(), signal.SIGKILL)
        number = REFUSALS[self.fault]
        raise OSError(number, os.strerror(number), path)


class _Torn:
    """An open file of which a write that goes wrong leaves half."""

    def __init__(self, file: Any, steps: Steps) -> None:
        self._file, self._steps = file, steps

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def write(self, data: bytes) -> None:
        if self._steps.here():
            self._file.write(data[: len(data) // 2])
            self._file.flush()
            self._steps.go_wrong(str(self._file.name))
        self._file.write(data)


@contextlib.contextmanager
def failing_at(steps: Steps) -> Iterator[Steps]:
    """Let the writing of files go through `steps` while the block runs."""

    def opened(path: Path, mode: str = "r", *args: Any, **options: Any) -> Any:
        if mode != "xb":  # it is read
            return usual(path, mode, *args, **options)
        if steps.here():
            steps.go_wrong(str(path))
        return _Torn(usual(path, mode), steps)

    def replaced(path: Path, target: Path) -> Path:
        if steps.here():
            steps.go_wrong(str(target))
        return rename(path, target)

    usual, rename = Path.open, Path.replace
    with mock.patch.object(Path, "open", opened), mock.patch.object(Path, "replace", replaced):
        yield steps


@contextlib.contextmanager
def clocks_going_backwards() -> Iterator[None]:
    """Every clock a program may ask runs backwards, in leaps."""
    ticks = itertools.count(1)
    with contextlib.ExitStack() as patches:
        for name in ("time", "monotonic", "perf_counter", "process_time"):
            patches.enter_context(mock.patch.object(time, name, lambda: 2e9 - 3600.0 * next(ticks)))  # noqa: PT008 — each call another
        for name in ("time_ns", "monotonic_ns", "perf_counter_ns"):
            patches.enter_context(mock.patch.object(time, name, lambda: int(1e9) * (2_000_000_000 - 3600 * next(ticks))))  # noqa: PT008
        yield
