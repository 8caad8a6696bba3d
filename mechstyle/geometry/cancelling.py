"""Whether long work is still wanted: asked every so often, because native code cannot be interrupted from outside."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from threading import Event, Thread

from mechstyle.errors import MechStyleError

CancelCheck = Callable[[], object]
"""Called between stretches of work that take well under a second on the largest part that is accepted; what it raises ends the work."""


def never_cancel() -> None:
    """Null check: work is never cancelled."""


LOOK = 0.2
"""Time between two questions whether to go on, while one waits for another thread [s]."""


class _Cancelled(Exception):
    """Raised in the other thread where its result is of no use any more."""


@contextmanager
def meanwhile(work: Callable[[CancelCheck], object], go_on: CancelCheck = never_cancel) -> Iterator[None]:
    """Work in another thread during a block, whose end waits for it, asking `go_on`.

    The work is given a check of its own. Its result has to be kept by the work itself, as in a cache, and whoever asks for it again learns
    why there is none. If the block or `go_on` raises, the work is ended.
    """
    ended = Event()

    def asked() -> None:
        if ended.is_set():
            raise _Cancelled

    def done() -> None:
        with suppress(_Cancelled, MechStyleError):
            work(asked)

    thread = Thread(target=done, name="mechstyle-meanwhile", daemon=True)
    thread.start()
    try:
        yield
        while thread.is_alive():
            go_on()
            thread.join(LOOK)
    finally:
        ended.set()
        thread.join()
