"""Buttons with pictures on them, of which one is chosen."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

import ipywidgets
import traitlets

from mechstyle_widgets.jupyter.throttle import running_loop
from mechstyle_widgets.settings import thumbnails

WIDTH, HEIGHT, LABEL = 72, 68, 16  # of a button, and of the words under its picture [pixels]


class PictureChoice(ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """Names with small pictures, in rows; the pictures come in as they are drawn.

    Attributes:
        value: The name chosen, "" for none.
        pressed: Counts the presses of a button, so that choosing the same again can be told.
    """

    value = traitlets.Unicode("")
    pressed = traitlets.Int(0)

    def __init__(self, kind: str, names: Mapping[str, str], height: int = 156) -> None:
        """Offer names.

        Args:
            kind: What the pictures are of, a key of `thumbnails.DRAWN`.
            names: What can be chosen, with a sentence about each.
            height: Of the whole, which scrolls [pixels].
        """
        self._kind, self._pictures = kind, {name: thumbnails.cached(kind, name) for name in names}
        self._sheet = ipywidgets.HTML(layout={"display": "none"})
        self._buttons = {name: self._button(name, words) for name, words in names.items()}
        flow = {"display": "flex", "flex_flow": "row wrap", "overflow": "auto", "max_height": f"{height}px", "width": "auto"}
        super().__init__([self._sheet, ipywidgets.Box(list(self._buttons.values()), layout=flow)])
        self._paint()
        self._loop = running_loop()
        self._work = None if self._loop is None else thumbnails.draw_aside(kind, names, self._arrived)

    def close(self) -> None:
        """Close it and wait for no more pictures."""
        if self._work is not None:
            self._work.stop()
        super().close()

    def _button(self, name: str, words: str) -> ipywidgets.Button:
        size = {"width": f"{WIDTH}px", "height": f"{HEIGHT}px", "padding": "0", "margin": "1px"}
        button = ipywidgets.Button(description=name.replace("_", " "), tooltip=f"{name.replace('_', ' ')}: {words}", layout=size)
        button.add_class(self._class(name))
        button.on_click(lambda _: self._press(name))
        return button

    def _press(self, name: str) -> None:
        self.value = name
        self.pressed += 1

    @traitlets.observe("value")
    def _mark(self, change: dict[str, Any]) -> None:
        for name, marked in ((change["old"], False), (change["new"], True)):
            button = self._buttons.get(name) if isinstance(name, str) else None
            if button is not None:
                (button.add_class if marked else button.remove_class)("mechstyle-chosen")

    def _class(self, name: str) -> str:
        return f"mechstyle-{self._kind}-{name.replace('_', '-')}"

    def _arrived(self, name: str, picture: bytes) -> None:
        """In a thread: hand a picture over to the event loop."""
        assert self._loop is not None, "pictures are drawn aside only for a loop"
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._hang, name, picture)

    def _hang(self, name: str, picture: bytes) -> None:
        self._pictures[name] = picture
        if all(known is not None for known in self._pictures.values()) or len(self._shown) % 6 == 0:
            self._paint()
        self._shown.add(name)

    def _paint(self) -> None:
        self._shown = {name for name, picture in self._pictures.items() if picture is not None}
        base = f"""[class*="mechstyle-{self._kind}-"].widget-button {{ background-size: {WIDTH}px {HEIGHT - LABEL}px;
  background-repeat: no-repeat; background-position: top; padding-top: {HEIGHT - LABEL}px !important;
  line-height: {LABEL}px; font-size: 10px; overflow: hidden;
  text-overflow: ellipsis; white-space: nowrap; }}"""
        known = {name: base64.b64encode(picture).decode("ascii") for name, picture in self._pictures.items() if picture is not None}
        rules = [
            f".{self._class(name)}.widget-button {{ background-image: url(data:image/png;base64,{data}); }}" for name, data in known.items()
        ]
        self._sheet.value = f"<style>{base}{''.join(rules)}</style>"
