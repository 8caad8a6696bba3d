"""Material settings: one of the library, or its figures changed by hand."""

from __future__ import annotations

from functools import partial
from typing import Any

import ipywidgets
import msgspec
import traitlets

from mechstyle.errors import BadInput
from mechstyle.records.material import LIBRARY, Material, material_named
from mechstyle_widgets.jupyter.looks import lean, unheard
from mechstyle_widgets.settings.section import Figure, Section, control, linked

FIGURES = {
    "youngs_modulus": ("E [MPa]", 50.0),
    "poisson_ratio": ("ν", 0.01),
    "density": ("ρ [g/cm³]", 0.01),
    "yield_strength": ("yield [MPa]", 1.0),
}
"""What can be edited: the fields of `Material`, how they are called, by how much an arrow changes them."""
SHOWN_IN = {"density": 1000.0}
"""Factor to the unit people know, where it is not the program's own: a density of 1.24 g/cm³ is 1.24e-3 g/mm³."""
EDITED = "figures edited by hand"


class MaterialPicker(Section):
    """A material of the library with its figures, which may be changed.

    Attributes:
        material: The material chosen; setting one that is not in the library shows it as edited.
        price: What its filament costs per kg, in any currency.
    """

    OWN = ("price",)

    material = traitlets.Instance(Material)
    price = Figure(20.0, min=0.0)

    def __init__(self, material: str | Material = "PLA") -> None:
        """Offer the library; `material` is chosen at first."""
        self._choice = control(ipywidgets.Dropdown, "material")
        self._choice.observe(self._choose, "value")
        self._figures = {
            field: control(ipywidgets.FloatText, name, step=step, continuous_update=False) for field, (name, step) in FIGURES.items()
        }
        paid = {"min": 0.0, "max": 1e5, "step": 1.0, "tooltip": "What the filament costs, in your currency"}
        price = linked(self, "price", ipywidgets.BoundedFloatText, "price per kg", **paid)
        super().__init__([self._choice, lean(ipywidgets.VBox, [*self._figures.values(), price])])
        self.material = material_named(material)
        for field, widget in self._figures.items():
            widget.observe(partial(self._edit, field), "value")
        self._show()

    @property
    def brief(self) -> str:
        """Name and strength."""
        return f"{self.material.name}, {self.material.yield_strength:g} MPa"

    @traitlets.observe("material")
    def _show(self, _change: object = None) -> None:
        edited = [] if LIBRARY.get(self.material.name) == self.material else [(f"{self.material.name} (edited)", "")]
        with unheard(self._choice, self._choose):  # other options choose their first one, which nobody asked for
            self._choice.options = [*[(name, name) for name in LIBRARY], *edited]
            self._choice.value = "" if edited else self.material.name
        for field, widget in self._figures.items():
            widget.value = round(getattr(self.material, field) * SHOWN_IN.get(field, 1.0), 6)
        self.note(f"source: {self.material.source}")
        self.complain("")

    def _choose(self, change: dict[str, Any]) -> None:
        if change["new"]:
            self.material = LIBRARY[change["new"]]

    def _edit(self, field: str, change: dict[str, Any]) -> None:
        value = change["new"] / SHOWN_IN.get(field, 1.0)
        if abs(value - getattr(self.material, field)) <= 1e-9 * abs(value):
            return
        try:
            self.material = msgspec.structs.replace(self.material, source=EDITED, **{field: value})
        except BadInput as error:
            self.complain(str(error))
