"""No more updates than a browser can draw: a call now and then, of which the latest counts."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable
from contextvars import copy_context
from functools import partial
from typing import Generic, TypeVar

T = TypeVar("T")

SHORTEST_WAIT = 0.1
"""Between two updates of a picture [s]."""


def running_loop() -> asyncio.AbstractEventLoop | None:
    """The event loop a cell runs in, None in plain Python."""
    try:
        return asyncio.get_running_loop()
    except RuntimeError:
        return None


def in_a_thread(
    loop: asyncio.AbstractEventLoop | None, work: Callable[[], T], bring: Callable[[T], object], failed: Callable[[Exception], object]
) -> None:
    """Work in a thread and bring what came of it, the answer or an error, to an event loop; at once where there is none."""

    def worked() -> None:
        try:
            tell: Callable[[], object] = partial(bring, work())
        except Exception as error:  # noqa: BLE001 — whoever waits hears of it
            tell = partial(failed, error)
        if loop is None:
            tell()
        elif not loop.is_closed():
            loop.call_soon_threadsafe(tell)

    if loop is None:
        worked()
    else:
        in_the_same_language = partial(copy_context().run, worked)
        threading.Thread(target=in_the_same_language, name="mechstyle", daemon=True).start()


class Timer:
    """Calls a function on an event loop after a while, from whichever thread it is asked to.

    JupyterLab lets widgets speak to a thread of the kernel's own; a loop of another thread that sleeps does not see what that thread
    plans on it.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, wait: float, act: Callable[[], None]) -> None:
        """Call `act` after `wait` seconds."""
        self._cancelled = False
        loop.call_soon_threadsafe(loop.call_later, wait, lambda: None if self._cancelled else act())

    def cancel(self) -> None:
        """Do not call it."""
        self._cancelled = True


class Throttled:
    """A function that may be called at any rate and acts at most ten times a second, after the last call at the latest.

    It acts at once where no event loop is running, as in plain Python. It must read what it needs when it acts: whatever
    was set by then counts, and what came in between is never drawn.
    """

    def __init__(self, act: Callable[[], None], failed: Callable[[Exception], None] | None = None) -> None:
        """Pace `act`; `failed` hears of its errors, which the event loop would keep to itself."""
        self._act, self._failed = act, failed
        self._acted = -SHORTEST_WAIT
        self._waiting: asyncio.TimerHandle | None = None

    def __call__(self) -> None:
        """Ask for `act`."""
        loop = running_loop()
        if loop is None:
            self._now()
        elif self._waiting is None:
            self._waiting = loop.call_later(max(0.0, self._acted + SHORTEST_WAIT - time.monotonic()), self._now)

    def cancel(self) -> None:
        """Forget what was asked for and has not happened yet."""
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None

    def _now(self) -> None:
        self._waiting = None
        try:
            self._act()
        except Exception as error:
            if self._failed is None:
                raise
            self._failed(error)
        self._acted = time.monotonic()  # what acts for long leaves the loop time for others all the same


Wish = TypeVar("Wish")
Answer = TypeVar("Answer")


class LatestOnly(Generic[Wish, Answer]):
    """A function at work in a thread, one wish at a time; of those that come meanwhile the last counts.

    Where no event loop is running, as in plain Python, it works at once.
    """

    def __init__(
        self, work: Callable[[Wish], Answer], bring: Callable[[Wish, Answer], None], failed: Callable[[Exception], None] | None = None
    ) -> None:
        """Work with `work`, which must touch no trait, and hand wish and answer to `bring` on the event loop.

        `failed` hears of the error of a wish that no newer one has taken the place of.
        """
        self._work, self._bring, self._failed = work, bring, failed
        self._next: Wish | None = None
        self._busy, self._cancelled = False, False

    def ask(self, wish: Wish) -> None:
        """Work on a wish, after the one in hand."""
        loop = running_loop()
        if loop is None:
            in_a_thread(None, partial(self._work, wish), partial(self._bring, wish), self._fail)
        elif self._busy:
            self._next = wish
        else:
            self._begin(loop, wish)

    def cancel(self) -> None:
        """Want nothing any more, from now on."""
        self._next, self._cancelled = None, True

    def _begin(self, loop: asyncio.AbstractEventLoop, wish: Wish) -> None:
        self._busy = True
        in_a_thread(
            loop, partial(self._work, wish), lambda answer: self._end(loop, partial(self._bring, wish, answer)),
            lambda error: self._end(loop, partial(self._fail, error)),
        )  # fmt: skip

    def _end(self, loop: asyncio.AbstractEventLoop, tell: Callable[[], None]) -> None:
        wish, self._next, self._busy = self._next, None, False
        if wish is not None:
            self._begin(loop, wish)
        if not self._cancelled:
            tell()

    def _fail(self, error: Exception) -> None:
        if self._failed is None:
            raise error
        if not self._busy:
            self._failed(error)
