"""Buttons with pictures on them, of which one is chosen.

One widget for the whole grid: a page that is loaded anew makes every model again before it shows any, and ipywidgets has three for
each button.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from typing import Any

import traitlets

from mechstyle_widgets.jupyter.page_widget import PageWidget
from mechstyle_widgets.jupyter.throttle import running_loop
from mechstyle_widgets.settings import thumbnails

FEW = 3
"""Pictures that are shown before all are asked for."""
TOGETHER = 6
"""Pictures that are told the page at once while they are drawn."""


def _static(name: str) -> str:
    return files("mechstyle_widgets.settings").joinpath("static", name).read_text(encoding="utf-8")


class PictureChoice(PageWidget):
    """Names with small pictures, in rows; the pictures come in as they are drawn.

    Attributes:
        value: The name chosen, "" for none.
        pressed: Counts the presses of a button, so that choosing the same again can be told.
        all: Whether all are shown, or a few with the chosen one among them.
        few: The names of those few.
        names: What can be chosen, with a sentence about each.
        pictures: PNG of those that have been shown, by name.
        kind: What the pictures are of.
    """

    _esm, _css = _static("pictures.js"), _static("pictures.css")
    value = traitlets.Unicode("").tag(sync=True)
    pressed = traitlets.Int(0)
    all = traitlets.Bool(False).tag(sync=True)
    few = traitlets.List(traitlets.Unicode()).tag(sync=True)
    names = traitlets.Dict().tag(sync=True)
    pictures = traitlets.Dict().tag(sync=True)
    kind = traitlets.Unicode().tag(sync=True)

    def __init__(self, kind: str, names: Mapping[str, str]) -> None:
        """Offer names.

        Args:
            kind: What the pictures are of, a key of `thumbnails.DRAWN`.
            names: What can be chosen, with a sentence about each.
        """
        self._drawn = {name: picture for name in names if (picture := thumbnails.cached(kind, name)) is not None}
        super().__init__(kind=kind, names=dict(names), few=list(names)[:FEW])
        self.on_msg(self._hear)
        self._hang()
        self._loop = running_loop()
        self._work = None if self._loop is None else thumbnails.draw_aside(kind, names, self._arrived)

    def close(self) -> None:
        """Close it and wait for no more pictures."""
        if self._work is not None:
            self._work.stop()
        super().close()

    def press(self, name: str) -> None:
        """Choose a name as the mouse does."""
        self.value = name
        self.pressed += 1

    def _hear(self, _widget: Any, message: Any, _buffers: Any) -> None:
        if isinstance(message, dict) and message.get("kind") == "press" and message.get("name") in self.names:
            self.press(message["name"])

    @traitlets.observe("value")
    def _fold(self, _change: object) -> None:
        """The chosen one is among the few."""
        few = list(self.names)[:FEW]
        self.few = few if self.value not in self.names or self.value in few else [self.value, *few[: FEW - 1]]

    def _arrived(self, name: str, picture: bytes) -> None:
        """In a thread: hand a picture over to the event loop."""
        assert self._loop is not None, "pictures are drawn aside only for a loop"
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._keep, name, picture)

    def _keep(self, name: str, picture: bytes) -> None:
        self._drawn[name] = picture
        if name in self.few or len(self._drawn) in (len(self.names), *range(0, len(self.names), TOGETHER)):
            self._hang()

    @traitlets.observe("all", "few")
    def _hang(self, _change: object = None) -> None:
        """Tell the page the pictures it shows; those it was told stay."""
        shown = self.names if self.all else self.few
        self.pictures = {**self.pictures, **{name: self._drawn[name] for name in shown if name in self._drawn}}
