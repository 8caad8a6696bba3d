"""Protected regions: the base, the inside, and regions written or clicked."""

from __future__ import annotations

import textwrap
from typing import Any

import ipywidgets
import traitlets

from mechstyle.errors import BadInput
from mechstyle.records.recipe import DEFAULTS
from mechstyle.records.regions import KINDS, Point, Region, regions
from mechstyle_widgets.jupyter.frame import unseen
from mechstyle_widgets.jupyter.language import said, word
from mechstyle_widgets.jupyter.looks import lean
from mechstyle_widgets.settings.brush import dabbed
from mechstyle_widgets.settings.section import NARROW_LABEL, WIDE, Section, setting

UNDERSIDES = {"plain": "smooth underside", "level": "relief, standing level", "free": "relief as the style has it"}
"""What becomes of the base, one of `BASES`, in words."""
BRIEFS = {"plain": "underside smooth", "level": "underside level", "free": "underside styled"}
"""The same where nothing says that it is of the underside."""


class RegionsPicker(Section):
    """Protected regions.

    Attributes:
        base: Relief under the part, one of `BASES`.
        protect: The regions, as records.
        paint: Whether a click on the part protects a ball around it, or ends that where there is one.
        radius: Radius of that ball [mm].
        place: A point on the part that was clicked [mm], None for none; it can be protected with the smooth piece around it.
    """

    base = setting("base")
    protect = traitlets.Tuple()
    paint = traitlets.Bool(False)
    radius = traitlets.Float(5.0, min=0.1, max=1e3)
    place = traitlets.Tuple(None, allow_none=True)

    def __init__(self, protect: str | Region | list[str | Region] = (), *, base: str = DEFAULTS["base"]) -> None:  # type: ignore[assignment]
        """Protect regions, given as records or as people write them, and say what becomes of the base."""
        self._base = lean(
            ipywidgets.Dropdown,
            options=[(words, name) for name, words in UNDERSIDES.items()], description="underside", style=NARROW_LABEL, layout=WIDE,
            tooltip="Relief under the part",
        )  # fmt: skip
        self._inside = lean(ipywidgets.Checkbox, description="the inside of hollows", indent=False, layout=WIDE)
        self._clicked = lean(
            ipywidgets.Button,
            description="protect the piece clicked on", icon="mouse-pointer", disabled=True, layout=WIDE,
            tooltip="Click a place on the part, then protect the smooth piece of surface around it",
        )  # fmt: skip
        self._lines = unseen(lean(
            ipywidgets.Textarea,
            description="regions", placeholder="one region a line, for example\nbox 0 0 0 10 10 10 ramp 2\nbelow 5", rows=3,
            continuous_update=False, tooltip="\n".join(said(form) if " " in form else form for form in KINDS.values()), layout=WIDE,
        ))  # fmt: skip
        super().__init__([self._base, self._inside, self._brush(), self._clicked, self._lines])
        traitlets.link((self, "base"), (self._base, "value"))
        self.base, self.protect = base, regions(protect)
        self._show()
        self._inside.observe(self._write, "value")
        self._lines.observe(self._write, "value")
        self._clicked.on_click(lambda _: self._protect_clicked())

    @property
    def brief(self) -> str:
        """How many regions, or what becomes of the underside."""
        count = len(self.protect)
        return word(BRIEFS[self.base]) if not count else word("{} places").format(count)

    def click(self, place: Point) -> None:
        """Handle a click on the part at a position [mm]."""
        self.place = place
        if self.paint:
            self.protect = dabbed(self.protect, place, self.radius)

    def _brush(self) -> ipywidgets.HBox:
        """The switch and the radius, in one line."""
        switch = lean(
            ipywidgets.ToggleButton,
            description="paint", icon="paint-brush", layout={"width": "80px"},
            tooltip="Click on the part to protect a ball around the place; click in its middle to take it away",
        )  # fmt: skip
        look = {"style": {"description_width": "88px"}, "layout": {"width": "168px"}}
        radius = lean(ipywidgets.BoundedFloatText, description="radius [mm]", min=0.1, max=1e3, step=0.5, **look)
        traitlets.link((self, "paint"), (switch, "value"))
        traitlets.link((self, "radius"), (radius, "value"))
        return lean(ipywidgets.HBox, [switch, radius])

    @traitlets.validate("protect")
    def _as_records(self, proposal: dict[str, Any]) -> tuple[Region, ...]:
        return regions(proposal["value"])

    @traitlets.observe("protect")
    def _show(self, _change: object = None) -> None:
        """Bring the controls up to date."""
        words = [one.words for one in self.protect]
        self._inside.value = "inside" in words
        self._lines.value = "\n".join(line for line in words if line != "inside")
        self.note(textwrap.shorten("protected: " + "; ".join(words), 160, placeholder=" …") if words else "")
        self.complain("")

    @traitlets.observe("place")
    def _offer(self, _change: object) -> None:
        self._clicked.disabled = self.place is None

    def _write(self, _change: object) -> None:
        lines = [line for line in self._lines.value.splitlines() if line.strip()]
        try:
            self.protect = regions((["inside"] if self._inside.value else []) + lines)
        except BadInput as error:
            self.complain(str(error))

    def _protect_clicked(self) -> None:
        if self.place is not None:
            self.protect = (*self.protect, *regions("segment " + " ".join(f"{x:.2f}" for x in self.place)))
