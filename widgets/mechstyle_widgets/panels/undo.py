"""Undo and redo of settings: each change leaves what was asked for before."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import ipywidgets

from mechstyle_widgets.jupyter.looks import lean

TOGETHER = 1.0
"""Changes of one setting that follow each other so fast are one, as where a slider is dragged [s]."""
MOST = 100
"""Steps that are kept."""


class Undo(ipywidgets.HBox):  # type: ignore[misc]  # ipywidgets has no types
    """Two buttons, and what they bring back."""

    def __init__(self, taken: Callable[[], dict[str, Any]], give: Callable[[dict[str, Any]], None]) -> None:
        """Step through settings: `taken` gives all as they are, by name, `give` sets all."""
        self._taken, self._give = taken, give
        self._past: list[dict[str, Any]] = []
        self._future: list[dict[str, Any]] = []
        self._now, self._last, self._giving = taken(), (frozenset[str](), -TOGETHER), False
        look = {"width": "36px"}
        self._back = lean(ipywidgets.Button, icon="undo", tooltip="Undo the last setting (Z)", layout=look)
        self._again = lean(ipywidgets.Button, icon="repeat", tooltip="Redo it (Y)", layout=look)
        super().__init__([self._back, self._again])
        self._back.on_click(lambda _: self.undo())
        self._again.on_click(lambda _: self.redo())
        self._offer()

    def note(self, _change: object = None) -> None:
        """Settings have changed."""
        if self._giving:
            return
        now = self._taken()
        changed = frozenset(name for name in now if now[name] is not self._now.get(name) and now[name] != self._now.get(name))
        if not changed:
            return
        names, at = self._last
        if changed != names or time.monotonic() - at > TOGETHER:
            self._past = [*self._past, self._now][-MOST:]
        self._future, self._now, self._last = [], now, (changed, time.monotonic())
        self._offer()

    def begin(self) -> None:
        """Begin here: what was set before is not undone."""
        self._past, self._future, self._now = [], [], self._taken()
        self._offer()

    @contextmanager
    def as_one(self) -> Iterator[None]:
        """All changes in here are one step, or part of the one around it."""
        around, self._giving = self._giving, True
        try:
            yield
        finally:
            self._giving = around
            self.note()

    def undo(self) -> None:
        """Go back by one change."""
        self._step(self._past, self._future)

    def redo(self) -> None:
        """Go forward by one change that was undone."""
        self._step(self._future, self._past)

    def _step(self, source: list[dict[str, Any]], other: list[dict[str, Any]]) -> None:
        if not source:
            return
        other.append(self._now)
        self._giving = True
        try:
            self._give(source.pop())
        finally:
            self._giving, self._now, self._last = False, self._taken(), (frozenset(), -TOGETHER)
            self._offer()

    def _offer(self) -> None:
        self._back.disabled, self._again.disabled = not self._past, not self._future
