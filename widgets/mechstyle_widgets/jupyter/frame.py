"""What only a page knows or can do: the room there is, the theme, keys, the full window, handing over a file."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ipywidgets
import traitlets

from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.missed import say_again
from mechstyle_widgets.jupyter.page_widget import PageWidget, static
from mechstyle_widgets.jupyter.terms import terms


class Frame(PageWidget):
    """Somewhere in a box of the class `mechstyle-studio`: a button for the full window, and eyes and ears for the kernel.

    Attributes:
        size: Width of the element of the class `mechstyle-view` and the height for a view in it [pixels]; empty until they are known.
        dark: Whether the notebook's theme is dark.
        calm: Whether the system asks that nothing moves by itself.
        filled: Whether the page shows nothing else from the beginning on.
        was: What is said once the kernel is gone.
        terms: Words that explain themselves, in the language spoken.
    """

    _esm, _css = static("jupyter", "terms.js") + static("jupyter", "frame.js"), static("jupyter", "frame.css")
    size = traitlets.List(traitlets.Int(), []).tag(sync=True)
    dark = traitlets.Bool(False).tag(sync=True)
    calm = traitlets.Bool(False).tag(sync=True)
    filled = traitlets.Bool(False).tag(sync=True)
    was = traitlets.Unicode().tag(sync=True)
    terms = traitlets.Dict().tag(sync=True)

    def __init__(self, *, filled: bool = False) -> None:
        """Say so in the language spoken."""
        super().__init__(filled=filled, was=word("This is a picture of what was. Run the cell to go on."), terms=terms())
        self.on_msg(lambda _widget, message, _buffers: say_again() if message == {"kind": "made"} else None)

    def on_key(self, place: str, call: Callable[..., None]) -> None:
        """Call back with the name of every key pressed in a place, `view` or `studio`; for a view, with `shift` and `ctrl`, too."""

        def hear(_widget: Any, message: Any, _buffers: Any) -> None:
            if isinstance(message, dict) and message.get("kind") == place:
                call(str(message.get("key", "")), **{name: bool(message[name]) for name in ("shift", "ctrl") if name in message})

        self.on_msg(hear)

    def on_file(self, call: Callable[[str, bytes], None]) -> None:
        """Call back with name and content of every file that is dropped on the view."""

        def hear(_widget: Any, message: Any, buffers: Any) -> None:
            if isinstance(message, dict) and message.get("kind") == "dropped" and buffers:
                call(str(message.get("name", "")), bytes(buffers[0]))

        self.on_msg(hear)

    def tell(self, text: str) -> None:
        """Let the browser say something if nobody looks at the page, and it may."""
        self.send({"kind": "news", "text": text})

    def copy(self, text: str) -> None:
        """Put a text where the page keeps what was copied, if the browser lets it."""
        self.send({"kind": "text", "text": text})

    def hand_over(self, name: str, data: bytes, media_type: str = "application/octet-stream") -> None:
        """Let the page save a file."""
        self.send({"kind": "file", "name": name, "type": media_type}, [data])


class Framed(ipywidgets.Widget):  # type: ignore[misc]  # ipywidgets has no types
    """Mixed into a box: displayed by itself, outside of a Studio, it brings a frame, for names of its controls, and for keys."""

    children: tuple[Any, ...]

    def _repr_mimebundle_(self, **formats: Any) -> Any:
        if not any(isinstance(child, Frame) for child in self.children):
            frame = Frame()
            for place in ("view", "studio"):
                frame.on_key(place, self.key)
            self.children = (*self.children, frame)
            self.add_class("mechstyle-alone")
        return super()._repr_mimebundle_(**formats)

    def key(self, name: str, *, shift: bool = False, ctrl: bool = False) -> None:
        """What a key does that was pressed in it: here nothing, but the notebook does not get it either."""


def unseen(control: Any) -> Any:
    """A control whose description only screen readers tell."""
    control.add_class("mechstyle-unseen")
    return control
