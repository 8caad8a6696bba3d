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
"""What a print is called that is none of these."""


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
        """Offer the presets, and every figure below them."""
        self._preset = control(ipywidgets.Dropdown, "print", options=[(word(name), name) for name in (*PRESETS, OWN)])
        self._preset.observe(self._choose, "value")
        whole, length = ipywidgets.BoundedIntText, ipywidgets.BoundedFloatText
        patterns = [(word(name), name) for name in self.traits()["infill_pattern"].values]
        self._figures = lean(ipywidgets.VBox, [
            linked(self, "walls", whole, "walls"),
            linked(self, "infill", ipywidgets.FloatSlider, "infill", step=0.05, readout_format=".0%", continuous_update=False),
            linked(self, "infill_pattern", ipywidgets.Dropdown, "pattern", options=patterns),
            linked(self, "top", whole, "layers on top"),
            linked(self, "bottom", whole, "layers below"),
            linked(self, "layer_height", length, "layer [mm]", step=0.05),
            linked(self, "line_width", length, "line [mm]", step=0.02),
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
        with unheard(self._preset, self._choose):
            self._preset.value = self.chosen
        show(self._figures, self.chosen != "solid")
        self.note(
            "" if self.chosen == "solid" else "Walls and infill are lighter and softer than a solid part; seams and gaps are not in it."
        )

    def _choose(self, change: dict[str, Any]) -> None:
        """A preset brings its figures; a print of one's own begins with the last one's."""
        preset = change["new"]
        if preset == OWN:
            preset = "3 walls, 15 % infill" if self.infill >= 1.0 else ""
        with self.hold_trait_notifications():
            for field, value in PRESETS.get(preset, {}).items():
                setattr(self, field, value)
        self._tell()
