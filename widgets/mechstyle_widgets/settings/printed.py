"""How the part is printed inside: solid, as it is usually printed, or as the figures say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import ipywidgets
import traitlets

from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show, unheard
from mechstyle_widgets.settings.section import Section, control, linked, setting

PRESETS: Mapping[str, Mapping[str, Any]] = {
    "solid": {"infill": 1.0},
    "3 walls, 15 % infill": {"infill": 0.15, "walls": 3},
    "4 walls, 30 % infill": {"infill": 0.3, "walls": 4},
}
"""Prints that are one click away, in words."""
OWN = "as below"
"""What a print is called that is none of these; offered where it is so."""
SOLID = "Few parts are printed solid: choose the walls and the infill of your slicer."
LIGHTER = "Walls and infill are lighter and softer than a solid part; seams and gaps are not in it."


class PrintedPicker(Section):
    """Walls, solid layers and infill.

    Attributes:
        infill: Share of the inside that is filled, 1 for a solid part.
        infill_pattern: How the infill runs.
        walls: Lines of plastic along every outline.
        top: Solid layers below what looks up.
        bottom: Solid layers above what looks down.
        layer_height: Height of a layer [mm].
        line_width: Width of a line of plastic [mm].
    """

    infill = setting("infill")
    infill_pattern = setting("infill_pattern")
    walls = setting("walls")
    top = setting("top")
    bottom = setting("bottom")
    layer_height = setting("layer_height")
    line_width = setting("line_width")

    def __init__(self) -> None:
        """Offer the presets, and every figure below those that are not solid."""
        self._preset = control(ipywidgets.Dropdown, "print", options=[(word(name), name) for name in PRESETS])
        self._preset.observe(self._choose, "value")
        whole, length = ipywidgets.BoundedIntText, ipywidgets.BoundedFloatText
        patterns = [(word(name), name) for name in self.traits()["infill_pattern"].values]
        self._figures = lean(ipywidgets.VBox, [
            linked(self, "walls", whole, "walls"),
            linked(self, "infill", ipywidgets.FloatSlider, "infill", step=0.05, readout_format=".0%", continuous_update=False),
            linked(self, "infill_pattern", ipywidgets.Dropdown, "infill pattern", options=patterns),
            linked(self, "top", whole, "top layers"),
            linked(self, "bottom", whole, "bottom layers"),
            linked(self, "layer_height", length, "layer height [mm]", step=0.05),
            linked(self, "line_width", length, "line width [mm]", step=0.02),
        ])  # fmt: skip
        super().__init__([self._preset, self._figures])
        self._tell()

    @property
    def brief(self) -> str:
        """Walls and infill."""
        if self.infill >= 1.0:
            return word("solid")
        return word("{} walls, {} infill").format(self.walls, f"{100.0 * self.infill:g} %")

    @property
    def chosen(self) -> str:
        """The preset that is chosen, OWN for none."""
        fits = (name for name, of in PRESETS.items() if all(getattr(self, field) == value for field, value in of.items()))
        return next(fits, OWN)

    @traitlets.observe("infill", "infill_pattern", "walls", "top", "bottom", "layer_height", "line_width")
    def _tell(self, _change: object = None) -> None:
        """Bring the choice up to date; a solid part has no figures."""
        chosen = self.chosen
        with unheard(self._preset, self._choose):
            self._preset.options = [(word(name), name) for name in dict.fromkeys((*PRESETS, chosen))]
            self._preset.value = chosen
        show(self._figures, chosen != "solid")
        self.note(SOLID if chosen == "solid" else LIGHTER)

    def _choose(self, change: dict[str, Any]) -> None:
        """A preset brings its figures."""
        with self.hold_trait_notifications():
            for field, value in PRESETS.get(change["new"], {}).items():
                setattr(self, field, value)
