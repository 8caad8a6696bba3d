"""Restraint settings: strategy, normalisation and threshold, with the resulting mask drawn as they change."""

from __future__ import annotations

import math
from typing import Any

import ipywidgets
import msgspec
import numpy as np
import traitlets

from mechstyle.fea.drop import DropTest
from mechstyle.loop.control import mask, normalised
from mechstyle.records import CONTROLS, NORMALISATIONS, Recipe
from mechstyle.records.material import LIBRARY, Material
from mechstyle.records.recipe import DEFAULTS
from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import lean, show
from mechstyle_widgets.jupyter.svg import Frame, drawing
from mechstyle_widgets.settings.section import WIDE, Section, control, linked, setting

STRATEGIES = {"linear": "evenly", "exponential": "faster than evenly", "frozen": "only at the limit"}
"""How demand becomes a mask, in words."""
MEASURES = {"headroom": "spare strength", "own_max": "the part's own peak", "sigma_c": "a share of its strength", "yield": "the strength"}
"""What stress is compared with, in words."""
MEANS = {
    "headroom": "the share of each vertex's own headroom that the style has used up",
    "own_max": "stress over the largest stress of the unstylized part",
    "sigma_c": "stress over λ times the yield strength",
}
"""What each normalisation compares."""


class ControlSelector(Section):
    """Strategy, normalisation and threshold, or Freestyle, which has none of them.

    Attributes:
        freestyle: Whether nothing restrains the style.
        control: How demand becomes a mask: `linear`, `exponential` or `frozen`.
        normalisation: How stress becomes demand, one of NORMALISATIONS.
        threshold: Demand at which a vertex may move no further.
        material: Gives yield strength and, for `sigma_c`, λ, which is its safety coefficient and changes with the slider.
        typical_stress: Stress of the unstylized vertex the curve is drawn for [MPa].
        peak_stress: Largest stress of the unstylized part [MPa].
    """

    SEEN = ("material",)
    OWN = ("freestyle",)

    freestyle = traitlets.Bool(False)
    control = traitlets.Enum(tuple(name for name in CONTROLS if name != "none"), DEFAULTS["control"])
    normalisation = setting("normalisation")
    threshold = setting("threshold")
    material = traitlets.Instance(Material)
    typical_stress = traitlets.Float(min=0.0)
    peak_stress = traitlets.Float(min=0.0)

    def __init__(self, material: Material = LIBRARY["PLA"], **traits: Any) -> None:
        """Offer the strategies for a material; `traits` are any of the attributes."""
        self._mode = linked(
            self, "freestyle", ipywidgets.ToggleButtons, "",
            options=[("MechStyle", False), ("Freestyle", True)], style={"button_width": "112px"}, layout={},
            tooltips=["Drop tests on the way hold the style back where the part needs its strength", "The whole style, tested at the end"],
        )  # fmt: skip
        strategies = [(STRATEGIES[name], name) for name in self.traits()["control"].values]
        self._strategy = linked(self, "control", ipywidgets.Dropdown, "holds back", options=strategies)
        measures = [(MEASURES[name], name) for name in NORMALISATIONS]
        compared_with = linked(self, "normalisation", ipywidgets.Dropdown, "measured against", options=measures)
        self._threshold = linked(
            self, "threshold", ipywidgets.FloatLogSlider, "stops at",
            base=10, min=-1.0, max=1.0, step=0.02, readout_format=".2f", continuous_update=True,
            tooltip="Strength used at which a place may move no further; less is more careful",
        )  # fmt: skip
        what = "Safety coefficient of the material"
        self._lambda = control(ipywidgets.FloatSlider, "λ (σ_c / yield)", min=0.05, max=1.0, step=0.01, tooltip=what)
        self._plot = lean(ipywidgets.HTML, layout=WIDE)
        self._restraint = lean(ipywidgets.VBox, [self._strategy, compared_with, self._threshold, self._lambda, self._plot])
        super().__init__([self._mode, self._restraint])
        # a flat landing has the stress ρ c v, for which the curve is drawn at first
        wave = material.density * material.bar_wave_speed * DropTest(height=DEFAULTS["height"]).speed
        for name, value in {"material": material, "typical_stress": wave, "peak_stress": material.yield_strength, **traits}.items():
            setattr(self, name, value)
        self._lambda.value = self.material.safety_coefficient
        self._lambda.observe(self._other_lambda, "value")
        self.observe(self._redraw, ("freestyle", "control", "normalisation", "threshold", "material", "typical_stress", "peak_stress"))
        self._redraw()

    def take(self, recipe: Recipe) -> None:
        """Choose what a recipe has."""
        self.freestyle = not recipe.restraint.feedback
        self.material = recipe.test.material
        if recipe.restraint.feedback:
            super().take(recipe)

    @property
    def brief(self) -> str:
        """The strategy and its threshold."""
        return "Freestyle" if self.freestyle else f"{word(STRATEGIES[self.control])}, {word('stops at')} {self.threshold:.2g}"

    def _other_lambda(self, change: dict[str, Any]) -> None:
        if not math.isclose(change["new"], self.material.safety_coefficient):
            self.material = msgspec.structs.replace(self.material, safety_coefficient=round(change["new"], 4))

    def curve(self, count: int = 121) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Stress [MPa], demand and mask along the plot, each of shape [count]."""
        top = 1.35 * max(self.material.yield_strength, self.peak_stress, 1.25 * self.typical_stress)
        stress = np.linspace(0.0, top, count, dtype=np.float32)
        baseline = np.full(count, self.typical_stress, np.float32)
        limit = np.float32(max(self.material.yield_strength, self.peak_stress))
        demand = normalised(stress, baseline, limit, self.peak_stress, self.material, self.normalisation)
        return stress, demand, mask(demand, self.control, self.threshold)

    def _redraw(self, _change: object = None) -> None:
        self._lambda.value = self.material.safety_coefficient
        show(self._lambda, self.normalisation == "sigma_c")
        show(self._mode, self.freestyle)  # the way back: the button Both leads there
        show(self._restraint, not self.freestyle)
        self.note("one drop test, at the end" if self.freestyle else f"demand is {MEANS[self.normalisation]}")
        stress, demand, left = self.curve()
        frame = Frame(0.0, float(stress[-1]), width=264, height=118)
        stops = float(np.interp(self.threshold, demand, stress)) if demand[-1] >= self.threshold else None
        end = "never stops" if stops is None else f"stops at {stops:.0f} MPa"
        strength = self.material.yield_strength
        parts = [frame.axes("stress at a vertex [MPa]", (0.0, strength / 2, strength), ((1.0, "1"), (0.0, "0"))), frame.curve(stress, left)]
        if stops is not None:
            parts.append(frame.mark(stops, f"{end}, demand {self.threshold:.2g}"))
        how = f"{STRATEGIES[self.control]}, measured against {MEASURES[self.normalisation]}"
        self._plot.value = drawing(frame, parts, f"mask against stress, {how}: 1 at rest, {end}")
