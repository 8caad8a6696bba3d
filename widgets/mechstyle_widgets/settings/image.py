"""A picture of the user's as the style: chosen from their files, laid out in millimetres."""

from __future__ import annotations

from typing import Any

import ipywidgets
import traitlets

from mechstyle.errors import MechStyleError
from mechstyle.runs.images import digest_of, thumbnail
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.settings.millimetres import Millimetres
from mechstyle_widgets.settings.section import NARROW_LABEL, WIDE, setting

WIDTHS = (5.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 80.0, 100.0, 150.0, 200.0)
"""Widths of a picture that the slider offers [mm]."""


class ImageChoice(ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """A button for a picture and, once there is one, how it is to lie on the part.

    Attributes:
        image: Digest of its pixels, "" for none; a file, its bytes or an array may be set.
        image_size: Its width [mm], None for what fits the part.
        image_as: What is taken of it.
        image_layout: Whether it is repeated.
        projection: How it lies on the part.
        trouble: Why a file could not be taken, in one sentence; "" if it could.
    """

    FIELDS = ("image", "image_size", "image_as", "image_layout", "projection")

    image: Any = traitlets.Any("")
    image_size = setting("image_size")
    image_as = setting("image_as")
    image_layout = setting("image_layout")
    projection = setting("projection")
    trouble: Any = traitlets.Unicode("")

    def __init__(self) -> None:
        """Offer to choose a file."""
        look = {"style": NARROW_LABEL, "layout": WIDE}
        what = "A PNG or JPEG file: light stands out, dark is cut in, what is transparent stays plain"
        kinds, own = ".png,.jpg,.jpeg", {"width": "auto"}
        self._upload = lean(ipywidgets.FileUpload, accept=kinds, description="your picture", tooltip=what, layout=own)
        self._remove = lean(ipywidgets.Button, description="without it", tooltip="Go on without the picture", layout=WIDE)
        self._shown = lean(ipywidgets.Image, width=56, layout={"border": "1px solid var(--jp-border-color2, #ccc)"})
        self._size = lean(Millimetres, WIDTHS, description="wide", tooltip="Width of the picture, or of one of its tiles", **look)
        uses = [("relief and colours", "both"), ("relief", "height"), ("colours", "colour")]
        self._use = lean(ipywidgets.Dropdown, options=uses, description="gives", tooltip="What is taken of the picture", **look)
        layouts = [("repeated", "tiled"), ("once a side", "placed")]
        self._layout = lean(ipywidgets.Dropdown, options=layouts, description="is", tooltip="How often it is laid out", **look)
        ways = [("from six sides", "box"), ("from one side", "planar"), ("around the part", "around")]
        where = "A prompt such as `front: picture` names it"
        self._way = lean(ipywidgets.Dropdown, options=ways, description="lies", tooltip=where, **look)
        self._details = lean(ipywidgets.VBox, [self._size, self._use, self._layout, self._way])
        super().__init__([lean(ipywidgets.HBox, [self._shown, lean(ipywidgets.VBox, [self._upload, self._remove])]), self._details])
        traitlets.link((self, "image_size"), (self._size, "length"))
        for name, widget in {"image_as": self._use, "image_layout": self._layout, "projection": self._way}.items():
            traitlets.link((self, name), (widget, "value"))
        self._upload.observe(self._take, "value")
        self._remove.on_click(lambda _button: setattr(self, "image", ""))
        self._show(None)

    @traitlets.validate("image")
    def _known(self, proposal: dict[str, Any]) -> str:
        return digest_of(proposal["value"])

    def _take(self, _change: object) -> None:
        """A file was chosen: its content is here already."""
        chosen = self._upload.value
        if not chosen:
            return
        try:
            self.image = bytes(chosen[0]["content"])
        except MechStyleError as error:
            self.trouble = str(error).replace("the picture", chosen[0]["name"], 1)
        else:
            self.trouble = ""
        self._upload.value = ()

    @traitlets.observe("image")
    def _show(self, _change: object) -> None:
        for widget in (self._shown, self._remove, self._details):
            show(widget, self.image)
        self._shown.value = thumbnail(self.image) if self.image else b""
