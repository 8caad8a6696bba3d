"""No more updates than a browser can draw: a call now and then, of which the latest counts."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

SHORTEST_WAIT = 0.1
"""Between two updates of a picture [s]."""


def running_loop() -> asyncio.AbstractEventLoop | None:
    """The event loop a cell runs in, None in plain Python."""
    try:
        return asyncio.get_running_loop()
    except RuntimeError:
        return None


class Timer:
    """Calls a function on an event loop after a while, from whichever thread it is asked to.

    JupyterLab lets widgets speak to a thread of the kernel's own; a loop of another thread that sleeps does not see what that thread
    plans on it.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, wait: float, act: Callable[[], None]) -> None:
        """Call `act` after `wait` seconds."""
        self._act, self._cancelled = act, False
        loop.call_soon_threadsafe(loop.call_later, wait, self._fire)

    def cancel(self) -> None:
        """Do not call it."""
        self._cancelled = True

    def _fire(self) -> None:
        if not self._cancelled:
            self._act()


class Paced:
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
