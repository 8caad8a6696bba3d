"""Part settings: a gallery model, a file by its path or uploaded, and its unit; the size is shown in millimetres."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import ipywidgets
import traitlets

from mechstyle import gallery
from mechstyle._files import file_stem, write_whole
from mechstyle.errors import BadInput, MechStyleError
from mechstyle.geometry.files import FORMATS, bodies
from mechstyle.geometry.one_body import Body
from mechstyle.geometry.pieces import size_words
from mechstyle.records.mesh import SurfaceMesh
from mechstyle_widgets.jupyter.frame import unseen
from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show, unheard
from mechstyle_widgets.settings.section import WIDE, Section, control
from mechstyle_widgets.settings.thumbnail_buttons import PictureChoice
from mechstyle_widgets.state.troubles import sentence

UNITS = {"as the file says": 0.0, "millimetres": 1.0, "centimetres": 10.0, "inches": 25.4, "metres": 1000.0}
"""Units a file may be in, and the factor that brings it to millimetres; 0 for its own, as None chooses nothing in a menu of ipywidgets."""
UPLOADS = Path("mechstyle-runs") / "uploads"
"""Where uploaded files are put, under the folder the notebook runs in."""


class PartPicker(Section):
    """A part, ready to be looked at.

    Attributes:
        model: `gallery:NAME` or the path of a file; "" for a part that came as a mesh or from a run.
        scale: Factor from the coordinates of the file to millimetres, None for its own unit.
        body: Number of the body that was chosen of several in a file, "" where there is one.
        mesh: The part [mm], None before there is one.
        name: What it is called.
    """

    model = traitlets.Unicode("")
    scale = traitlets.Float(None, allow_none=True)
    body = traitlets.Unicode("")
    mesh = traitlets.Instance(SurfaceMesh, None, allow_none=True)
    name = traitlets.Unicode("")

    def __init__(self, model: str | SurfaceMesh = "", *, scale: float | None = None, name: str = "part") -> None:
        """Offer the gallery; a surface given as `model` is called by `name`. BadInput if the part cannot be used."""
        groups: dict[str, list[str]] = {}
        for one in gallery.names():
            groups.setdefault(gallery.entry(one).module, []).append(one)
        self._gallery = PictureChoice("model", {one: gallery.describe(one) for one in gallery.names()}, groups)
        what = "A file where the notebook runs"
        self._path = unseen(lean(
            ipywidgets.Text,
            description="file", placeholder="or a path: part.stl", tooltip=what, continuous_update=False,
            layout={"flex": "1 1 auto", "width": "0"},
        ))  # fmt: skip
        kinds = ",".join(f".{suffix}" for suffix in FORMATS)
        what = "A file of this computer"
        self._upload = lean(ipywidgets.FileUpload, accept=kinds, description="your file", tooltip=what, layout={"width": "auto"})
        narrow = {"width": "138px"}
        self._unit = unseen(lean(ipywidgets.Dropdown, options=UNITS, description="unit", tooltip="Unit of the file", layout=narrow))
        what = "Which body of the file: a drop test is of one"
        self._body = control(ipywidgets.Dropdown, "body", options=[], tooltip=what)
        show(self._body, False)
        file = lean(ipywidgets.HBox, [self._upload, self._path], layout=WIDE)
        super().__init__([self._gallery, file, self._body, self._unit])
        self._gallery.observe(lambda _: self._wish(gallery.PREFIX + self._gallery.value, None), "pressed")
        self._path.observe(self._typed, "value")
        self._upload.observe(self._uploaded, "value")
        self._unit.observe(self._choose_unit, "value")
        self._body.observe(self._of_these, "value")
        if isinstance(model, SurfaceMesh):
            self.show(model, name)
        elif model:
            self.choose(model, scale)

    @property
    def brief(self) -> str:
        """Name of the part."""
        return self.name.replace("_", " ")

    def choose(self, model: str, scale: float | None = None, body: str = "") -> None:
        """Take a part by its address; BadInput if it cannot be used, and what was chosen before stays."""
        mesh = gallery.load(model, scale=scale, body=body)
        with self.hold_trait_notifications():
            self.model, self.scale, self.body, self.name, self.mesh = model, scale, body, mesh.name, mesh
        self._say(mesh.notes)

    def show(self, mesh: SurfaceMesh, name: str, origin: str = "") -> None:
        """Show a part that has no address; `origin` is where it once came from, which is marked if it is of the gallery."""
        with self.hold_trait_notifications():
            self.model, self.scale, self.body, self.name, self.mesh = "", None, "", name, mesh
        self._say(())
        if origin.startswith(gallery.PREFIX):
            self._gallery.value = origin.removeprefix(gallery.PREFIX)

    def take_file(self, name: str, content: bytes) -> None:
        """Take a file of the page; what is wrong with it is said here."""
        place = UPLOADS / f"{file_stem(Path(name).stem)}{Path(name).suffix}"
        try:
            write_whole(place, content)
        except (OSError, MechStyleError) as error:
            self.complain(sentence(error))
        else:
            self._wish(str(place), self._unit.value or None)

    def remark(self, found: tuple[str, ...]) -> None:
        """Warn of what was found when the part was measured, under what was said when it was read."""
        assert self.mesh is not None, "there is a part to speak of"
        notes = self._notes or (size_words(self.mesh.vertices),)  # of a file they begin with its size
        self.note(f"{self.brief}: {'; '.join(notes)}", found)

    def _say(self, notes: tuple[str, ...]) -> None:
        self._notes = notes
        self.remark(())
        self.complain("")
        from_gallery = self.model.startswith(gallery.PREFIX)
        self._gallery.value = self.model.removeprefix(gallery.PREFIX) if from_gallery else ""
        self._path.value = "" if from_gallery else self.model
        self._unit.value = next((factor for factor in UNITS.values() if factor == (self.scale or 0.0)), None)
        self._unit.disabled = from_gallery or not self.model
        show(self._unit, not self._unit.disabled)
        if not self.body:
            self._offer_bodies("", None)

    def _wish(self, model: str, scale: float | None, body: str = "") -> None:
        """Handle mouse and keyboard: as `choose`, with errors shown here; of several bodies one may be chosen."""
        if not model or (model, scale, body) == (self.model, self.scale, self.body):
            return
        try:
            self.choose(model, scale, body)
        except BadInput as error:
            several = not body and self._offer_bodies(model, scale)
            self.complain(word("{} holds several bodies: choose one.").format(Path(model).name) if several else str(error))

    def _offer_bodies(self, model: str, scale: float | None) -> bool:
        """Offer the bodies of a file, none for "" and for one that holds no two; whether there are several."""
        found: tuple[Body, ...] = ()
        with suppress(BadInput):  # what is wrong with the file is said
            found = bodies(model, scale=scale) if model and not model.startswith(gallery.PREFIX) else ()
        several = len(found) > 1
        with unheard(self._body, self._of_these):
            self._body.options = [(word("choose …"), ""), *((one.words, str(one.number)) for one in found)] if several else []
        self._asked_of = (model, scale)
        show(self._body, several)
        return several

    def _of_these(self, change: dict[str, Any]) -> None:
        if change["new"]:
            self._wish(*self._asked_of, change["new"])

    def _choose_unit(self, change: dict[str, Any]) -> None:
        if change["new"] is not None:  # a factor that no unit has
            self._wish(self.model, change["new"] or None, self.body)

    def _typed(self, change: dict[str, Any]) -> None:
        model = change["new"].strip()
        if model != self.model:
            self._wish(model, None if model.startswith(gallery.PREFIX) else self._unit.value or None)

    def _uploaded(self, change: dict[str, Any]) -> None:
        for file in change["new"]:
            self.take_file(file["name"], bytes(file["content"]))
        if change["new"]:
            self._upload.value = ()  # or the button counts what it has read
