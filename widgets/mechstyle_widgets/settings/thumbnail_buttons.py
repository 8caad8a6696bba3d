"""Buttons with pictures on them, of which one is chosen.

One widget for the whole grid: a page that is loaded anew makes every model again before it shows any, and ipywidgets has three for
each button.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import traitlets

from mechstyle_widgets.jupyter.language import spoken, word
from mechstyle_widgets.jupyter.page_widget import PageWidget, static
from mechstyle_widgets.jupyter.throttle import running_loop
from mechstyle_widgets.settings import thumbnails

NONE: Mapping[str, Any] = MappingProxyType({})
FEW = 3
"""Pictures that are shown before all are asked for."""
WORDS = {
    "model": {"all": "all {} parts", "few": "parts", "search": "search parts", "none": "No part is called so: choose a file."},
    "style": {"all": "all {} styles", "few": "styles", "search": "search styles", "none": "No style is called so: write it above."},
}
"""What a page says of what the pictures are of."""
TOGETHER = 6
"""Pictures that are sent to the page at once while they are drawn."""


class PictureChoice(PageWidget):
    """A few names with small pictures, and a sheet with all of them in groups, which can be searched; pictures come in as they are drawn.

    Attributes:
        value: The name chosen, "" for none.
        pressed: Counts the presses of a button, so that choosing the same again counts.
        all: Whether the sheet with all of them is open.
        few: The names of the few that are always shown.
        nearest: Names that are shown instead, none for the usual few.
        pictures: PNG of those that have been shown, by name.
    """

    _esm, _css = static("settings", "pictures.js"), static("settings", "pictures.css")
    value = traitlets.Unicode("").tag(sync=True)
    pressed = traitlets.Int(0)
    all = traitlets.Bool(False).tag(sync=True)
    few = traitlets.List(traitlets.Unicode()).tag(sync=True)
    nearest = traitlets.List(traitlets.Unicode())
    names = traitlets.Dict().tag(sync=True)
    groups = traitlets.Dict().tag(sync=True)
    found_by = traitlets.Dict().tag(sync=True)
    words = traitlets.Dict().tag(sync=True)
    pictures = traitlets.Dict().tag(sync=True)
    kind = traitlets.Unicode().tag(sync=True)

    def __init__(
        self, kind: str, names: Mapping[str, str], groups: Mapping[str, Sequence[str]] = NONE, found_by: Mapping[str, str] = NONE
    ) -> None:
        """Offer names of a kind of `thumbnails.DRAWN` with a sentence about each, under headings; `found_by` has words to find them."""
        self._drawn = {name: picture for name in names if (picture := thumbnails.cached(kind, name)) is not None}
        titles = {name: word(name.replace("_", " ")) for name in names}
        tips = {name: f"{titles[name]}: {about}" if spoken() == "en" else titles[name] for name, about in names.items()}
        shown = {name: {"title": titles[name], "tip": tips[name]} for name in names}
        found = {name: " ".join((name, *shown[name].values(), found_by.get(name, ""))).replace("_", " ").lower() for name in names}
        heads = {word(head): [name for name in members if name in names] for head, members in groups.items()}
        heads[word("others")] = [name for name in names if not any(name in members for members in groups.values())]
        heads = {head: members for head, members in heads.items() if members}
        words = {name: word(text).format(len(names)) for name, text in WORDS[kind].items()}
        super().__init__(kind=kind, names=shown, few=list(names)[:FEW], groups=heads, found_by=found, words=words)
        self.on_msg(self._hear)
        self._hang()
        self._loop = running_loop()
        self._work = None if self._loop is None else thumbnails.draw_in_worker(kind, names, self._arrived)

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

    @traitlets.observe("value", "nearest")
    def _fold(self, _change: object) -> None:
        """The chosen one is among the few."""
        few = (self.nearest or list(self.names))[:FEW]
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
        """Tell the page the pictures it shows; those it has stay."""
        shown = self.names if self.all else self.few
        self.pictures = {**self.pictures, **{name: self._drawn[name] for name in shown if name in self._drawn}}
