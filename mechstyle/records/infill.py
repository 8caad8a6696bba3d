"""Infill of a print: how stiff and strong a pattern is beside the solid plastic that it is made of.

Holes are smeared out: a volume of infill counts as one of a weaker material (Gibson and Ashby, Cellular Solids, 1997). Of that material
E/E_s = C ρⁿ with the relative density ρ, the share that a slicer calls infill.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

LEAST = 1e-3
"""Least relative density, stiffness and strength: tetrahedra of nothing at all would have no frequency to step by."""


class Pattern(NamedTuple):
    """A pattern of infill.

    Attributes:
        stiffness: C and n of E over that of the plastic.
        strength: The same of yield strength.
        source: Where the figures come from.
    """

    stiffness: tuple[float, float]
    strength: tuple[float, float]
    source: str

    def relative(self, density: float) -> tuple[float, float, float]:
        """Density, stiffness and yield strength over those of the plastic at a relative density, at most as by the rule of mixtures."""
        laws = (factor * density**exponent for factor, exponent in (self.stiffness, self.strength))
        density = max(density, LEAST)
        stiffness, strength = (min(max(value, LEAST), density) for value in laws)
        return density, stiffness, strength


PATTERNS: Mapping[str, Pattern] = {
    "gyroid": Pattern(
        (0.52, 1.23), (0.52, 1.23),
        "E of a periodic cell of one line of plastic, `benchmarks/validate.py --case infill`, alike in all directions as in Bean, "
        "Lopez-Anido and Vel, Appl. Sci. 12 (2022) 2180; strength in proportion, so that it yields at the strain at which the plastic does",
    ),
    "grid": Pattern(
        (0.5, 1.0), (0.5, 1.0),
        "square cells pressed or pulled along their walls, half of which bear (Gibson and Ashby 1997); upright they are twice as stiff, and"
        " across their corners much softer",
    ),
}  # fmt: skip
"""Patterns by the names that slicers have for them."""
