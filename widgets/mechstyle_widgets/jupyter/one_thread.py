"""What a page says to widgets is heard on the thread that runs cells, one message after the other.

JupyterLab sends it to a thread of the kernel's own, and ipykernel (7.4) some of it to one thread and some to the other. Traits, links, and
all that draws know of one thread only: two at once broke links and lost what was set. As everywhere but in JupyterLab, a page is heard
between two cells; what it asks for when it is loaded again, all models at once, is answered at any time.

What a widget does when it hears, of a page or of a cell, it does in the language in which it was made.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextvars import copy_context
from functools import wraps
from typing import Any

from ipywidgets.widgets import widget as library

from mechstyle_widgets.jupyter.language import language_of, speaking, spoken
from mechstyle_widgets.jupyter.missed import note_what_is_said
from mechstyle_widgets.jupyter.throttle import running_loop

LONGEST = 1.0
"""As long a message is waited for, so that a page says no more than can be heard; it may have to wait behind a long cell [s]."""

_of_cells: list[asyncio.AbstractEventLoop] = []
"""The event loop of the main thread, once something was drawn in a cell."""


class _Models(dict[str, Any]):
    """Models by id, each with the language of its making, listed as they were when they were asked for: a drawing may add one meanwhile."""

    def __setitem__(self, key: str, model: Any) -> None:
        model.spoken_here = spoken()
        super().__setitem__(key, model)

    def values(self) -> Any:
        return list(super().values())

    def items(self) -> Any:
        return list(super().items())


def hear_on_one_thread() -> None:
    """Let all widgets of this kernel hear of their pages on the thread of the cells, in one of which this is called."""
    loop = running_loop()
    if loop is not None and threading.current_thread() is threading.main_thread():
        _of_cells[:] = [loop]
    if not isinstance(library._instances, _Models):  # noqa: SLF001 — the library has no other door
        library._instances = _Models(library._instances)  # noqa: SLF001 — as above
        library.Widget._handle_msg = _in_turn(_in_its_language(library.Widget._handle_msg))  # noqa: SLF001 — as above
        library.Widget.notify_change = _in_its_language(library.Widget.notify_change)
        note_what_is_said()


def _in_its_language(act: Callable[[Any, Any], None]) -> Callable[[Any, Any], None]:
    """What a widget does, in the language of its making."""

    @wraps(act)
    def acted(widget: Any, given: Any) -> None:
        with speaking(language_of(widget) or spoken()):
            act(widget, given)

    return acted


def _in_turn(hear: Callable[[Any, Any], None]) -> Callable[[Any, Any], None]:
    """How a widget hears of a message, on the thread of the cells."""

    @wraps(hear)
    def handed_over(widget: Any, message: Any) -> None:
        loop = _of_cells[0] if _of_cells else None
        if loop is None or loop.is_closed() or threading.current_thread() is threading.main_thread():
            hear(widget, message)
            return
        heard = threading.Event()

        def now() -> None:
            try:
                if widget.comm is not None:  # it may have been closed meanwhile, with all that the message names
                    hear(widget, message)
            finally:
                heard.set()

        loop.call_soon_threadsafe(now, context=copy_context())  # which knows what message is answered
        heard.wait(LONGEST)

    return handed_over
