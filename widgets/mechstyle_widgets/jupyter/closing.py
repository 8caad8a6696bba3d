"""Closing a widget for good: with it goes every widget it is made of, in the kernel and in the browser."""

from __future__ import annotations

import logging
from typing import Any

import ipywidgets

from mechstyle_widgets.jupyter.looks import close_unused, shared


def family(widget: ipywidgets.Widget) -> list[ipywidgets.Widget]:
    """The widget and every widget its state refers to, however deep."""
    found: dict[int, ipywidgets.Widget] = {}
    waiting: list[Any] = [widget]
    while waiting:
        one = waiting.pop()
        if isinstance(one, dict):
            waiting.extend(one.values())
        elif isinstance(one, list | tuple):
            waiting.extend(one)
        elif isinstance(one, ipywidgets.Widget) and id(one) not in found:
            found[id(one)] = one
            waiting.extend(getattr(one, key) for key in one.keys)
    return list(found.values())


class _Late(logging.Filter):
    """What a page still says of widgets that were closed meanwhile is no news: JupyterLab put a red number on its log for it."""

    def __init__(self) -> None:
        super().__init__()
        self.closed: dict[str, None] = {}

    def note(self, widget: ipywidgets.Widget) -> None:
        """A widget is about to be closed."""
        self.closed[widget.model_id] = None
        while len(self.closed) > REMEMBERED:
            del self.closed[next(iter(self.closed))]

    def filter(self, record: logging.LogRecord) -> bool:
        *_, ident = record.getMessage().rpartition("No such comm: ")
        return ident not in self.closed


REMEMBERED = 20_000
"""Closed widgets that a page may still speak of."""
_late = _Late()
logging.getLogger("Comm").addFilter(_late)


def close_family(widget: ipywidgets.Widget, *more: ipywidgets.Widget) -> None:
    """Close everything a widget, and more it keeps out of sight, is made of; the widget itself is left to its owner.

    Of one that is closed nothing is touched: Python asks for that once more when it removes it, at any moment and in any thread.
    """
    if widget.comm is None:
        return
    parts = list({id(part): part for one in (widget, *more) for part in family(one)}.values())
    for part in parts:
        if part.comm is not None:
            _late.note(part)
        if part is not widget and not shared(part):
            part.close()
    close_unused(part for part in parts if shared(part))
