"""Whether long work is still wanted: asked every so often, because native code cannot be interrupted from outside."""

from __future__ import annotations

from collections.abc import Callable

GoOn = Callable[[], object]
"""Called between stretches of work that take well under a second on the largest part that is accepted; what it raises ends the work."""


def regardless() -> None:
    """Go on, whatever happens."""
