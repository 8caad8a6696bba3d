"""No leaks when a cell is run again: what it showed the last time is closed.

Widgets live on in the kernel and in the browser when their cell's output is gone, a few megabytes each time.
"""

from __future__ import annotations

import weakref
from typing import Any

import ipywidgets

_shown: dict[str, tuple[str, weakref.WeakSet[Any]]] = {}
"""By the id of a cell: the request that ran it last, and what it showed."""


class OncePerCell(ipywidgets.Widget):  # type: ignore[misc]  # ipywidgets has no types
    """Mixed into a widget: showing it closes what its cell showed when it was last run."""

    def _repr_mimebundle_(self, **formats: Any) -> Any:
        replace_last_run(self)
        return super()._repr_mimebundle_(**formats)


def replace_last_run(widget: ipywidgets.Widget) -> None:
    """Note that the running cell shows `widget`, and close what an earlier run of it showed; outside a notebook nothing happens."""
    cell, request = _here()
    if not cell:
        return
    last, shown = _shown.get(cell, ("", weakref.WeakSet()))
    if last != request:
        for old in tuple(shown):
            if old is not widget:
                old.close()
        shown = weakref.WeakSet()
    shown.add(widget)
    _shown[cell] = (request, shown)


def _here() -> tuple[str, str]:
    """The ids of the running cell and of the request that runs it, both "" outside a notebook."""
    try:
        from IPython import get_ipython  # noqa: PLC0415 — there only if a notebook is
    except ModuleNotFoundError:
        return "", ""
    shell = get_ipython()
    parent = shell.get_parent() if hasattr(shell, "get_parent") else {}
    return parent.get("metadata", {}).get("cellId", ""), parent.get("header", {}).get("msg_id", "")
