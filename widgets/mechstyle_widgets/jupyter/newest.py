"""Work beside the event loop: it goes on answering while a thread reads and reckons, and only hears what came of it."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from functools import partial
from typing import Generic, TypeVar

from mechstyle_widgets.jupyter.throttle import running_loop

Wish = TypeVar("Wish")
Answer = TypeVar("Answer")


class Newest(Generic[Wish, Answer]):
    """A function at work in a thread, one wish at a time; of those that come meanwhile the last counts.

    Where no event loop is running, as in plain Python, it works at once.
    """

    def __init__(
        self, work: Callable[[Wish], Answer], bring: Callable[[Wish, Answer], None], failed: Callable[[Exception], None] | None = None
    ) -> None:
        """Work with `work`, which must touch no trait, and hand wish and answer to `bring` on the event loop, an error to `failed`."""
        self._work, self._bring, self._failed = work, bring, failed or _raise
        self._next: Wish | None = None
        self._busy, self._cancelled = False, False

    def ask(self, wish: Wish) -> None:
        """Work on a wish, after the one in hand."""
        loop = running_loop()
        if loop is None:
            self._bring(wish, self._work(wish))
        elif self._busy:
            self._next = wish
        else:
            self._begin(loop, wish)

    def cancel(self) -> None:
        """Want nothing any more, from now on."""
        self._next, self._cancelled = None, True

    def _begin(self, loop: asyncio.AbstractEventLoop, wish: Wish) -> None:
        self._busy = True
        threading.Thread(target=self._run, args=(loop, wish), name="mechstyle-newest", daemon=True).start()

    def _run(self, loop: asyncio.AbstractEventLoop, wish: Wish) -> None:
        """In the thread."""
        try:
            tell = partial(self._bring, wish, self._work(wish))
        except Exception as error:  # noqa: BLE001 — raised again where somebody hears of it
            tell = partial(self._failed, error)
        if not loop.is_closed():
            loop.call_soon_threadsafe(self._end, loop, tell)

    def _end(self, loop: asyncio.AbstractEventLoop, tell: Callable[[], None]) -> None:
        wish, self._next, self._busy = self._next, None, False
        if wish is not None:
            self._begin(loop, wish)
        if not self._cancelled:
            tell()


def _raise(error: Exception) -> None:
    raise error
