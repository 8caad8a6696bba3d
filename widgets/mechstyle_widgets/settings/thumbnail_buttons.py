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
FEW = 3
"""Pictures that are shown before all are asked for."""


class PictureChoice(ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """Names with small pictures, in rows; the pictures come in as they are drawn.

    Attributes:
        value: The name chosen, "" for none.
        pressed: Counts the presses of a button, so that choosing the same again can be told.
        all: Whether all are shown, or a few with the chosen one among them.
    """

    value = traitlets.Unicode("")
    pressed = traitlets.Int(0)
    all = traitlets.Bool(False)

    def __init__(self, kind: str, names: Mapping[str, str]) -> None:
        """Offer names.

        Args:
            kind: What the pictures are of, a key of `thumbnails.DRAWN`.
            names: What can be chosen, with a sentence about each.
        """
        self._kind, self._pictures = kind, {name: thumbnails.cached(kind, name) for name in names}
        self._sheet = ipywidgets.HTML(layout={"display": "none"})
        self._look = ipywidgets.ButtonStyle()  # one for all: a page that is loaded anew makes every model again before it shows any
        self._buttons = {name: self._button(name, words) for name, words in names.items()}
        grid = ipywidgets.Box(list(self._buttons.values()), layout={"display": "flex", "flex_flow": "row wrap", "width": "auto"})
        grid.add_class("mechstyle-pictures")
        self._more = ipywidgets.Button(tooltip="More to choose from, or fewer", layout={"width": "auto", "height": "24px"})
        self._more.on_click(lambda _: setattr(self, "all", not self.all))
        super().__init__([self._sheet, grid, self._more])
        self._fold()
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
        title = name.replace("_", " ")
        button = ipywidgets.Button(description=title, tooltip=f"{title}: {words}", layout=size, style=self._look)
        button.add_class(self._class(name))
        button.on_click(lambda _: self._press(name))
        return button

    def _press(self, name: str) -> None:
        self.value = name
        self.pressed += 1

    @traitlets.observe("value", "all")
    def _fold(self, _change: object = None) -> None:
        """Show all, or the chosen one among a few; the tab key stops at one of them, from which arrow keys lead on."""
        few = list(self._buttons)[:FEW]
        if self.value in self._buttons and self.value not in few:
            few = [self.value, *few[: FEW - 1]]
        stop = self.value if self.value in self._buttons else few[0]
        for name, button in self._buttons.items():
            button.layout.display = "" if self.all or name in few else "none"
            button.tabbable = name == stop
        self._more.description = "fewer" if self.all else f"all {len(self._buttons)} {self._kind}s"
        self._more.layout.display = "" if len(self._buttons) > FEW else "none"

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
