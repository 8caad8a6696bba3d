"""Protected regions: the base, the inside, and regions written or clicked."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import Any

import ipywidgets
import manifold3d
import numpy as np
import traitlets
from numpy.typing import NDArray

from mechstyle.errors import BadInput
from mechstyle.geometry.region_selection import selected
from mechstyle.geometry.remeshing.evening import manifold_of, surface_of
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.recipe import DEFAULTS
from mechstyle.records.regions import KINDS, Box, HalfSpace, Point, Region, Sphere, regions
from mechstyle_widgets.jupyter.frame import unseen
from mechstyle_widgets.jupyter.language import said, word
from mechstyle_widgets.jupyter.looks import lean
from mechstyle_widgets.settings.section import WIDE, Figure, Read, Section, linked, setting

UNDERSIDES = {"plain": "smooth", "level": "relief, standing level", "free": "relief as the style has it"}
"""What becomes of the base, one of `BASES`, in words."""
BRIEFS = {"plain": "underside smooth", "level": "underside level", "free": "underside styled"}
"""The same where nothing says that it is of the underside."""


FACES = 15_000
"""About as many triangles show where a ball ends, however few a flat wall needs."""
AGAIN = 0.5
"""A click this near to the middle of a ball, as a share of its radius, takes it away."""


def dabbed(regions: Sequence[Region], place: Point, radius: float) -> tuple[Region, ...]:
    """The regions with one more ball [mm], or without the one that was clicked on once more."""
    hit = [one for one in regions if isinstance(one, Sphere) and math.dist(one.centre, place) <= AGAIN * one.radius]
    if hit:
        return tuple(one for one in regions if one is not hit[-1])
    x, y, z = (round(float(value), 2) for value in place)
    return (*regions, Sphere((x, y, z), radius))


def covered(regions: Sequence[Region], mesh: SurfaceMesh) -> NDArray[np.bool_]:
    """Whether each vertex lies in a ball, a box or a half-space among the regions, shape [vertex_count].

    The others take seconds to find, and a click must be answered at once.

    Raises:
        BadInput: If one of them holds nothing of the part.
    """
    chosen = np.zeros(len(mesh.vertices), bool)
    for region in regions:
        if isinstance(region, Sphere | Box | HalfSpace):
            chosen |= selected(region, mesh, ())
    return chosen


def paintable(mesh: SurfaceMesh) -> SurfaceMesh:
    """The same surface in triangles small enough to show where a ball ends; as it is where it is coloured or not closed."""
    body = manifold_of(mesh)
    if mesh.colours is not None or body.status() != manifold3d.Error.NoError or body.is_empty():
        return mesh
    edge = math.sqrt(4.0 / math.sqrt(3.0) * float(mesh.face_areas.sum()) / FACES)  # of an equilateral triangle of the mean area
    return surface_of(body.refine_to_length(edge))


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
    protect: Any = Read(regions, ())
    paint = traitlets.Bool(False)
    radius = Figure(5.0, min=0.1, max=1e3)
    place = traitlets.Tuple(None, allow_none=True)

    def __init__(self, protect: str | Region | list[str | Region] = (), *, base: str = DEFAULTS["base"]) -> None:  # type: ignore[assignment]
        """Protect regions, given as records or as people write them, and say what becomes of the base."""
        undersides = [(words, name) for name, words in UNDERSIDES.items()]
        underside = linked(self, "base", ipywidgets.Dropdown, "underside", options=undersides, tooltip="Relief under the part")
        self._inside = lean(ipywidgets.Checkbox, description="the inside of hollows", indent=False, layout=WIDE)
        paint = linked(
            self, "paint", ipywidgets.ToggleButton, "paint", icon="paint-brush", style={}, layout={"width": "80px"},
            tooltip="Click on the part to protect a ball around the place; click in its middle to take it away",
        )  # fmt: skip
        look = {"style": {"description_width": "88px"}, "layout": {"width": "168px"}}
        radius = linked(self, "radius", ipywidgets.BoundedFloatText, "radius [mm]", min=0.1, max=1e3, step=0.5, **look)
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
        super().__init__([underside, self._inside, lean(ipywidgets.HBox, [paint, radius]), self._clicked, self._lines])
        self.base, self.protect = base, protect
        self._show()
        self._inside.observe(self._write, "value")
        self._lines.observe(self._write, "value")
        self._clicked.on_click(self._protect_clicked)
        traitlets.dlink((self, "place"), (self._clicked, "disabled"), lambda place: place is None)

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

    @traitlets.observe("protect")
    def _show(self, _change: object = None) -> None:
        words = [one.words for one in self.protect]
        self._inside.value = "inside" in words
        self._lines.value = "\n".join(line for line in words if line != "inside")
        self.note(textwrap.shorten("protected: " + "; ".join(words), 160, placeholder=" …") if words else "")
        self.complain("")

    def _write(self, _change: object) -> None:
        lines = [line for line in self._lines.value.splitlines() if line.strip()]
        try:
            self.protect = regions((["inside"] if self._inside.value else []) + lines)
        except BadInput as error:
            self.complain(str(error))

    def _protect_clicked(self, _button: object) -> None:
        if self.place is not None:
            self.protect = (*self.protect, *regions("segment " + " ".join(f"{x:.2f}" for x in self.place)))
