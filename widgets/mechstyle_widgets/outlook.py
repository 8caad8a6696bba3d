"""How long the rest of a run will take, from what iterations and drop tests took so far."""

from __future__ import annotations


class Outlook:
    """Learns from every iteration."""

    def __init__(self) -> None:
        self._plain: list[float] = []
        self._simulated: list[float] = []

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
