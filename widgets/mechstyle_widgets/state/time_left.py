"""Seconds worked on a run, pauses left out."""

from __future__ import annotations

import time


class Stopwatch:
    """Counts while it runs."""

    def __init__(self) -> None:
        self._counted, self._lap_began_at = 0.0, 0.0
        self._since: float | None = None

    @property
    def total(self) -> float:
        """Time counted so far [s]."""
        running = 0.0 if self._since is None else time.monotonic() - self._since
        return self._counted + running

    def run(self) -> None:
        """Count from now on."""
        if self._since is None:
            self._since = time.monotonic()

    def pause(self) -> None:
        """Stop counting."""
        self._counted, self._since = self.total, None

    def lap(self) -> float:
        """End a lap; the time counted in it [s]."""
        total = self.total
        lap, self._lap_began_at = total - self._lap_began_at, total
        return lap
