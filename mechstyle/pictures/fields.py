"""The table of what can be looked at on a part: how each quantity is called, measured, scaled and set apart above a threshold.

Figures, viewer, replay and report read it, so that a field has one label, one unit and one threshold wherever it is shown.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechstyle.records import Recipe

ROOM_ABOVE = 1.05
"""Least end of the colours over the threshold, so that what lies above it can be seen on the bar."""

MOMENT = "moment"
"""Name of the stress at one moment of an impact."""

DEMAND_LABELS = {
    "headroom": "demand: stress reserve used up",
    "own_max": "demand: stress over original's peak",
    "sigma_c": "demand: stress over λ × yield",
    "yield": "demand: stress over yield strength",
}
"""Label of demand for each of `records.NORMALISATIONS`."""


@dataclass(frozen=True)
class Quantity:
    """A field over a surface without its values: name, label, unit, limits and threshold.

    Attributes:
        name: What it is called in code and by which it is selected.
        label: What it is called on screen.
        unit: Its unit, "" for a pure number.
        least: Values the colours reach from and to at least; None if they span the values and no more.
        threshold: Values above it are set apart, None for none.
        note: What a reader should know about it, "" for nothing.
        mirrored: Whether the colours reach as far below zero as above it.
        complement_of: Name of the stored array of which it is the complement to 1; "" if the array of its own name holds it.
    """

    name: str
    label: str
    unit: str = ""
    least: tuple[float, float] | None = None
    threshold: float | None = None
    note: str = ""
    mirrored: bool = False
    complement_of: str = ""

    @property
    def source(self) -> str:
        """Name of the array it is made from, in a checkpoint or a simulation."""
        return self.complement_of or self.name

    def made(self, array: NDArray[Any]) -> NDArray[Any]:
        """Its values from that array, same shape."""
        return 1.0 - array if self.complement_of else array

    def of(self, state: object) -> NDArray[Any]:
        """Its values in a checkpoint or a simulation, shape [vertex_count]."""
        return self.made(getattr(state, self.source))

    def limits(self, values: ArrayLike) -> tuple[float, float] | None:
        """Ends of the colours that show all values, of any shape; None if they are to be those of the values."""
        given = np.asarray(values)
        known = given[np.isfinite(given)]
        low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
        if self.mirrored:
            reach = max(abs(low), abs(high)) or 1.0
            return -reach, reach
        return None if self.least is None else (min(low, self.least[0]), max(high, self.least[1]))


def stress(limit: float) -> Quantity:
    """Stress against what it may at most be [MPa]."""
    return _against(limit, "stress", "von Mises stress at the surface", "MPa")


def envelope(limit: float) -> Quantity:
    """Largest stress of all orientations against what it may at most be [MPa]."""
    return _against(limit, "envelope", "worst stress of all orientations", "MPa")


def moment(limit: float) -> Quantity:
    """Stress at one moment of an impact against what it may at most be [MPa]."""
    return _against(limit, MOMENT, "stress of the moment", "MPa")


def demand(recipe: Recipe) -> Quantity:
    """Demand as a recipe has it normalised, against its threshold."""
    return _against(recipe.threshold, "demand", DEMAND_LABELS[recipe.normalisation])


def probability(strength: float) -> Quantity:
    """Probability that a random drop exceeds a strength [MPa]."""
    return Quantity("probability", f"probability to exceed {strength:.1f} MPa", least=(0.0, 1.0), note="of a random drop")


def _against(threshold: float, name: str, label: str, unit: str = "") -> Quantity:
    return Quantity(name, label, unit, (0.0, ROOM_ABOVE * threshold), threshold)


RESTRAINT = Quantity(
    "restraint", "share of movement held back", least=(0.0, 1.0), note="1 = may not move any further", complement_of="mask"
)
DISPLACEMENT = Quantity("displacement", "displacement along the normal", "mm", note="positive is outwards", mirrored=True)
ADDED = Quantity("added", "added along the normal", "mm", least=(0.0, 0.1), note="what strengthening put on")
THICKNESS = Quantity("thickness", "wall thickness", "mm")
CONTACT = Quantity("contact", "touched the floor", least=(0.0, 1.0), note="1 = touched the floor as placed")


def quantities(recipe: Recipe, limit: float) -> tuple[Quantity, ...]:
    """The fields every checkpoint holds.

    Args:
        recipe: The recipe in force there.
        limit: What the stress may at most be [MPa].
    """
    return stress(limit), demand(recipe), RESTRAINT, DISPLACEMENT
