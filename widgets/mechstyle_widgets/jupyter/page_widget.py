"""Widgets with scripts of their own that a busy page does not make deaf."""

from __future__ import annotations

import re
import uuid
from importlib.resources import files
from typing import Any, ClassVar

import anywidget
import traitlets

from mechstyle_widgets.jupyter.language import in_page


def static(room: str, name: str) -> str:
    """The text of a file for pages."""
    return files(f"mechstyle_widgets.{room}").joinpath("static", name).read_text(encoding="utf-8")


_HEARING = static("jupyter", "hearing.js")


class PageWidget(anywidget.AnyWidget):
    """An anywidget that hears the kernel however busy the page is.

    anywidget gives the script of a widget two seconds. In a page that is busier, as one that is loaded anew, the script comes and draws,
    but nothing the kernel says from then on arrives. Here the script of a subclass exports `initialize: hears(initialize)`, or `hears()`,
    which mends it.

    Attributes:
        own: Id of its model, by which the page finds it.
        said: What the script says by itself in the language spoken, by the English of it.
    """

    own = traitlets.Unicode().tag(sync=True)
    said = traitlets.Dict().tag(sync=True)
    _quoted: ClassVar[tuple[str, ...]] = ()

    def __init_subclass__(cls, **given: Any) -> None:
        """Give the script its ears."""
        if isinstance(script := vars(cls).get("_esm"), str):  # a trait in the class that traitlets makes of each instance's
            cls._esm, cls._quoted = _HEARING + script, tuple(re.findall(r'"([^"\n]+)"', script))
        super().__init_subclass__(**given)

    def __init__(self, **traits: Any) -> None:
        """Open it in the page; traits as of a widget."""
        own = uuid.uuid4().hex
        super().__init__(model_id=own, own=own, said=in_page(self._quoted), **traits)
