"""Time left of a run: seconds worked, pauses left out, and what iterations and drop tests took so far."""

from __future__ import annotations

import time


class Outlook:
    """Mean time of plain and of simulated iterations so far."""

    def __init__(self) -> None:
        self._plain: list[float] = []
        self._simulated: list[float] = []

    @property
    def known(self) -> bool:
        """Whether there was a drop test."""
        return bool(self._simulated)

    def record(self, seconds: float, *, simulated: bool) -> None:
        """An iteration took so many seconds, with a drop test in it or without."""
        (self._simulated if simulated else self._plain).append(seconds)

    def seconds_left(self, iterations: int) -> float | None:
        """Time for so many more iterations [s], the last of which is simulated; None before there was a drop test.

        Drop tests are expected as often as they came so far.
        """
        if not self._simulated:
            return None
        drop = sum(self._simulated) / len(self._simulated)
        plain = sum(self._plain) / len(self._plain) if self._plain else 0.0
        rate = len(self._simulated) / (len(self._simulated) + len(self._plain))
        drops = min(max(rate * iterations, 1.0), float(iterations))
        return drops * drop + (iterations - drops) * plain


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
