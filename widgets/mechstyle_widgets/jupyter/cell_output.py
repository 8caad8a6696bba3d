"""What a cell shows: a widget, and a picture of it for pages without its kernel; what it showed when it was last run is closed.

Widgets live on in the kernel and in the browser when their cell's output is gone, a few megabytes each time. A notebook that is opened
without its kernel has no widgets at all, whether it is trusted or not.
"""

from __future__ import annotations

import weakref
from base64 import b64encode
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import ipywidgets

from mechstyle.errors import MechStyleError
from mechstyle_widgets.jupyter.language import language_of, speaking, word
from mechstyle_widgets.jupyter.throttle import LatestOnly, Timer, running_loop

_shown: dict[str, tuple[str, weakref.WeakSet[Any]]] = {}
"""By the id of a cell: the request that ran it last, and what it showed."""


class OncePerCell(ipywidgets.Widget):  # type: ignore[misc]  # ipywidgets has no types
    """Mixed into a widget: showing it closes what its cell showed when it was last run, and leaves a picture of it in the notebook."""

    _stills: tuple[Any, ...] = ()
    _drawing: LatestOnly[Callable[[], bytes], str] | None = None

    def _ipython_display_(self) -> None:
        """The widget, and below it a picture, which a page that has the widget does not show (`frame.css`)."""
        from IPython import display  # noqa: PLC0415 — there only if a notebook is

        put: Any = display.display
        shown, about = self._repr_mimebundle_()
        put(shown, metadata=about, raw=True)
        if in_a_notebook() and self.still() is not None:
            self._stills = (*self._stills, put({"image/png": NOTHING}, raw=True, display_id=True))
            loop = running_loop()
            if loop is None:
                self._first_still()
            else:
                Timer(loop, PAGE_FIRST, self._first_still)

    def _first_still(self) -> None:
        if self.comm is not None and self._drawing is None:  # it is still there, and nobody drew one meanwhile
            self.renew_still()

    def _repr_mimebundle_(self, **formats: Any) -> Any:
        """What the widget is shown as, by kind, and what is said about that: anywidget gives both, ipywidgets the first."""
        replace_last_run(self)
        with speaking(language_of(self)):
            bundle = super()._repr_mimebundle_(**formats)
            shown, about = bundle if isinstance(bundle, tuple) else (bundle, {})
            return {**shown, "text/plain": f"{self!r}\n{word(NO_WIDGETS)}"}, about

    def still(self) -> Callable[[], bytes] | None:
        """What draws the picture as it is now, as PNG, in any thread; None where there is none."""
        return None

    def renew_still(self) -> None:
        """Let the notebook have a picture of what is shown now; it is drawn beside the event loop."""
        with speaking(language_of(self)):
            drawn = self.still() if self._stills else None
        if drawn is not None:
            self._drawing = self._drawing or LatestOnly(_png, self._hang)
            self._drawing.ask(drawn)

    def _hang(self, _drawn: Callable[[], bytes], picture: str) -> None:
        for shown in self._stills if picture else ():
            shown.update({"image/png": picture, "text/plain": repr(self)}, raw=True)


NO_WIDGETS = (
    "This page shows no widgets: run the cell in JupyterLab 4, Notebook 7 or VS Code; in Colab call "
    "google.colab.output.enable_custom_widget_manager() first."
)
NOTHING = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
"""A picture of one pixel, until there is another."""
PAGE_FIRST = 2.0
"""How long a page has the kernel for itself, which draws the picture of it afterwards [s]."""


def _png(drawn: Callable[[], bytes]) -> str:
    with suppress(MechStyleError):  # a picture is not worth an error
        return b64encode(drawn()).decode()
    return ""


def _shell() -> Any:
    """What runs cells, None in plain Python."""
    with suppress(ModuleNotFoundError):
        from IPython import get_ipython  # noqa: PLC0415 — as above

        return get_ipython()
    return None


def in_a_notebook() -> bool:
    """Whether cells are run by a kernel, which may be gone one day while its notebook is still there."""
    return hasattr(_shell(), "kernel")


def replace_last_run(widget: ipywidgets.Widget) -> None:
    """Note that the running cell shows `widget`, and close what an earlier run of it showed; outside a notebook nothing happens."""
    shell = _shell()
    running = shell.get_parent() if hasattr(shell, "get_parent") else {}
    cell, request = running.get("metadata", {}).get("cellId", ""), running.get("header", {}).get("msg_id", "")
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
