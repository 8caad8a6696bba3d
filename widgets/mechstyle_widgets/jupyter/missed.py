"""What a page misses while it is loaded anew is said again.

Such a page asks for all models at once, then loads their scripts and makes them, for seconds if it is busy. What the kernel says of a model
meanwhile has nobody to hear it, and the page would show for good what was. So the kernel notes what it says from the list on, and says
it again once a page has made its models.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import wraps
from typing import Any

from ipywidgets.widgets import widget as library

LONGEST = 60.0
"""As long a page may take to make its models [s]."""


@dataclass
class _Said:
    """What was said since pages asked for models: names of traits, by the model they are of; and when one asked last [s]."""

    names: dict[str, set[str]] = field(default_factory=dict)
    asked: float = -LONGEST

    def ask(self) -> None:
        """A page asks for models: another that is being loaded has not heard what was said before either."""
        now = time.monotonic()
        if now - self.asked > LONGEST:
            self.names.clear()
        self.asked = now

    def say(self, model: str, names: Iterable[str]) -> None:
        """Note what is said of a model while a page may be loading."""
        if time.monotonic() - self.asked < LONGEST:
            self.names.setdefault(model, set()).update(names)


_said = _Said()
_answering: ContextVar[bool] = ContextVar("answering", default=False)
"""Whether what is said is what a page asked of one model."""


def note_what_is_said() -> None:
    """From now on note what pages may miss."""
    library.Widget._handle_control_comm_msg = classmethod(_noting(library.Widget._handle_control_comm_msg.__func__))  # noqa: SLF001 — as in one_thread
    library.Widget._handle_msg = _noting(library.Widget._handle_msg)  # noqa: SLF001 — as above
    library.Widget._send = _noted(library.Widget._send)  # noqa: SLF001 — as above


def say_again() -> None:
    """Say again, as it is now, what was said since pages asked for their models."""
    for model, names in list(_said.names.items()):
        widget = library._instances.get(model)  # noqa: SLF001 — as above
        if widget is not None and widget.comm is not None:
            widget.send_state(set(names))


def _noting(hear: Callable[[Any, Any], None]) -> Callable[[Any, Any], None]:
    """How a page's message is heard, which may ask for all models or for one."""

    @wraps(hear)
    def heard(widget: Any, message: Any) -> None:
        asked = message["content"]["data"].get("method")
        if asked in ("request_states", "request_state"):
            _said.ask()
        answering = _answering.set(asked == "request_state")
        try:
            hear(widget, message)
        finally:
            _answering.reset(answering)

    return heard


def _noted(send: Callable[..., None]) -> Callable[..., None]:
    """How a widget speaks to its page."""

    @wraps(send)
    def sent(widget: Any, msg: Any, buffers: Any = None) -> None:
        if widget.comm is not None and msg.get("method") == "update" and not _answering.get():
            _said.say(widget.model_id, msg["state"])
        send(widget, msg, buffers)

    return sent
