"""The table of what can be looked at on a part: how each quantity is called, measured, scaled and set apart above a threshold.

Figures, viewer, replay and report read it, so that a field has one label, one unit and one threshold wherever it is shown.

What is shown is what is judged: stress above σ_V is shown as σ_V. What exceeds it has less than the volume V0, and how much is read there
hangs on the mesh.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechstyle.records import Checkpoint, Recipe, Row, Simulation, Verdict, sentences

ROOM_ABOVE = 1.05
"""Least end of the colours over the threshold, so that what lies above it can be seen on the bar."""

MOMENT = "moment"
"""Name of the stress at one moment of an impact."""

SPARE = 4.0
"""Safety factor at the pale end of its colours: what is above it is in no danger."""
AMPLE = 10.0
"""Greatest safety factor that is given; more of it, up to that of no stress at all, is of no use to anybody."""

DEMAND_LABELS = {
    "headroom": "demand: stress reserve used up", "own_max": "demand: stress over original's peak",
    "sigma_c": "demand: stress over λ × yield",
}  # fmt: skip
"""Label of demand for each of `records.NORMALISATIONS`."""


@dataclass(frozen=True)
class Quantity:
    """A field over a surface without its values: name, label, unit, limits and threshold."""

    name: str  # what it is called in code and by which it is selected
    label: str  # what it is called on screen
    unit: str = ""  # its unit, "" for a pure number
    least: tuple[float, float] | None = None  # values the colours reach from and to at least; None if they span the values and no more
    threshold: float | None = None  # values beyond it are set apart, None for none
    note: str = ""  # what a reader should know about it, "" for nothing
    mirrored: bool = False  # whether the colours reach as far below zero as above it
    bounded: bool = False  # whether the colours reach from and to `least` and no farther, whatever the values
    stored: str = ""  # name of the stored array it is made from; "" for that of its own name
    formed: Callable[[NDArray[Any]], NDArray[Any]] | None = None  # makes it from that array, None if it is that array
    said: Callable[[float], str] | None = None  # how a value at one place is put in words; as a figure with its unit if None
    # reads the array from a simulation, where that holds it for several tests; None if it is an array of the simulation
    tested: Callable[[Simulation], NDArray[Any]] | None = None
    # what is judged of it; values above are shown as this, and it stands for them on the bar; None if all are shown
    judged: float | None = None
    most: str = ""  # words beside the greatest value, "" for that value

    @property
    def title(self) -> str:
        """What a button or a menu calls it."""
        return TITLES.get(self.name, self.name.replace("_", " "))

    @property
    def source(self) -> str:
        """Name of the array it is made from, in a checkpoint or a simulation."""
        return self.stored or self.name

    def made(self, array: NDArray[Any]) -> NDArray[Any]:
        """Its values from that array, same shape."""
        return array if self.formed is None else self.formed(array)

    def of(self, state: object) -> NDArray[Any]:
        """Its values in a checkpoint or a simulation, shape [vertex_count]."""
        if self.tested is not None and isinstance(state, Simulation):
            return self.made(self.tested(state))
        return self.made(getattr(state, self.source))

    def limits(self, values: ArrayLike) -> tuple[float, float] | None:
        """Ends of the colours that show all values, of any shape; None if they are to be those of the values."""
        if self.bounded:
            return self.least
        given = np.asarray(values)
        known = given[np.isfinite(given)]
        low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
        if self.mirrored:
            reach = max(abs(low), abs(high)) or 1.0
            return -reach, reach
        return None if self.least is None else (min(low, self.least[0]), max(high, self.least[1]))


def stress(limit: float, row: Row | None = None) -> Quantity:
    """Stress against what it may at most be [MPa], as far as the row of its test judges it; all of it without one."""
    return _against(limit, "stress", "von Mises stress at the surface", "MPa", row)


def moment(limit: float, row: Row | None = None) -> Quantity:
    """Stress at one moment of an impact against what it may at most be [MPa], as far as the row of its landing judges it."""
    return _against(limit, MOMENT, "stress of the moment", "MPa", row)


def safety_factor(strength: float, row: Row | None = None) -> Quantity:
    """Yield strength [MPa] over stress, in the test that decides, as far as its row judges it."""
    most = np.inf if row is None else _judged(row) or np.inf

    def factor(stress: NDArray[Any]) -> NDArray[Any]:
        return np.minimum(strength / np.clip(stress, strength / AMPLE, most), AMPLE).astype(np.float32)

    return Quantity(
        "safety_factor", "safety factor: yield strength over stress", least=(SPARE, 0.0), threshold=1.0,
        note=f"{AMPLE:.0f} stands for that and more", bounded=True, stored="stress", formed=factor,
    )  # fmt: skip


def demand(recipe: Recipe) -> Quantity:
    """Demand as a recipe has it normalised, against its threshold."""
    return _against(recipe.restraint.threshold, "demand", DEMAND_LABELS[recipe.restraint.normalisation])


def _against(threshold: float, name: str, label: str, unit: str = "", row: Row | None = None) -> Quantity:
    """A quantity with a threshold, cut off at what its row judges."""
    judged = None if row is None else _judged(row)
    if row is None or judged is None:
        return Quantity(name, label, unit, (0.0, ROOM_ABOVE * threshold), threshold)

    def cut_off(values: NDArray[Any]) -> NDArray[Any]:
        return np.minimum(values, np.float32(judged))

    least = (0.0, max(ROOM_ABOVE * threshold, judged))
    return Quantity(name, label, unit, least, threshold, formed=cut_off, judged=judged, most=sentences.most(row))


def _judged(row: Row) -> float | None:
    """The stress that a row judges [MPa]; None for a mean of several landings, of which none has it."""
    return None if row.test == "any landing" else row.stress


def flat_stress(row: Row) -> Quantity:
    """Stress of the flat landing against the limit of its row [MPa]."""
    quantity = _against(row.limit, "flat_stress", "stress of the flat landing", "MPa", row)
    return replace(quantity, note=row.landing, tested=lambda simulation: simulation.stress_of(landing=row.landing))


def nearly_flat_stress(row: Row) -> Quantity:
    """Largest stress of the nearly flat landings against the limit of their row [MPa]."""

    def largest(simulation: Simulation) -> NDArray[np.float32]:
        fields = [simulation.stress_of(landing=landing.name) for landing in simulation.of("nearly flat")]
        return np.maximum.reduce(fields) if fields else np.zeros(len(simulation.displacement), np.float32)

    quantity = _against(row.limit, "nearly_flat_stress", "largest stress of the nearly flat landings", "MPa", row)
    return replace(quantity, note=f"all of them; {row.landing} decides", tested=largest)


def load_stress(row: Row) -> Quantity:
    """Stress under a load against the limit of its row [MPa]; what no file could call it by becomes `_` in its name."""
    name = f"load_{re.sub('[^A-Za-z0-9]+', '_', row.load)}"
    quantity = _against(row.limit, name, f"stress under the load {row.load!r}", "MPa", row)
    return replace(quantity, tested=lambda simulation: simulation.stress_of(load=row.load))


TESTS: dict[str, Callable[[Row], Quantity]] = {"flat": flat_stress, "nearly flat": nearly_flat_stress, "load": load_stress}
"""What makes the field of a row, by its test."""

RESTRAINT = Quantity(
    "restraint", "share of movement held back", least=(0.0, 1.0), note="1 = may not move any further", stored="mask",
    formed=lambda mask: 1.0 - mask,
)  # fmt: skip
DISPLACEMENT = Quantity("displacement", "displacement along the normal", "mm", note="positive is outwards", mirrored=True)
ADDED = Quantity("added", "added along the normal", "mm", least=(0.0, 0.1), note="what strengthening put on")
THICKNESS = Quantity("thickness", "wall thickness", "mm")
CONTACT = Quantity(
    "contact", "touched the floor", least=(0.0, 1.0), note="1 = touched the floor as placed",
    said=lambda value: "yes" if value >= 0.5 else "no",
)  # fmt: skip


TITLES = {
    "safety_factor": "safety factor", "thickness": "wall thickness", "contact": "touched the floor", "flat_stress": "stress, flat",
    "nearly_flat_stress": "stress, nearly flat", MOMENT: "stress of the moment",
}  # fmt: skip
"""What a menu calls a quantity, where that is not its name."""


def quantities(recipe: Recipe, verdict: Verdict | None) -> tuple[Quantity, ...]:
    """The fields every checkpoint holds, in the order in which they are offered.

    Args:
        recipe: The recipe in force there.
        verdict: The newest verdict there, None before the first.
    """
    strength, row = recipe.test.material.yield_strength, None if verdict is None else verdict.deciding
    against = stress(strength if row is None else row.limit, row)
    return against, safety_factor(strength, row), RESTRAINT, demand(recipe), DISPLACEMENT


@dataclass(frozen=True, eq=False)
class Known:
    """A field of a checkpoint: a quantity with its values."""

    quantity: Quantity  # its row of the table
    values: NDArray[Any]  # the field [unit], shape [vertex_count]
    seen: NDArray[Any]  # what the colours have to show, of any shape
    note: str  # what a reader should know of these values, "" for nothing

    @classmethod
    def of(cls, quantity: Quantity, values: NDArray[Any], *more: NDArray[Any], note: str = "") -> Known:
        """Values, which the colours have to show together with `more`, and a note, the quantity's own by default."""
        return cls(quantity, values, np.stack([values, *more]) if more else values, note or quantity.note)


def known(
    recipe: Recipe, state: Checkpoint, simulation: Simulation | None, thickness: NDArray[Any], newest: Checkpoint, verdict: Verdict | None
) -> tuple[Known, ...]:
    """Every field that is known of a checkpoint, in the order in which they are offered.

    Args:
        recipe: The recipe in force there.
        state: The checkpoint.
        simulation: Its last simulation, None if there was none.
        thickness: Wall thickness of the part [mm], shape [vertex_count].
        newest: The last checkpoint of its lane, so that displacement keeps its colours from iteration to iteration.
        verdict: The newest verdict there, None before the first.
    """
    when = "" if state.simulated_at == state.iteration else f"simulated at iteration {state.simulated_at}"
    row = None if verdict is None else verdict.deciding
    aged = {DISPLACEMENT.name: "", RESTRAINT.name: "", "demand": when}
    seen = {DISPLACEMENT.name: [newest.displacement]}
    decides = _joined(None if row is None else sentences.named(row), when)
    held = [
        Known.of(quantity, quantity.of(state), *seen.get(quantity.name, ()), note=aged.get(quantity.name, decides))
        for quantity in (in_the_test(one, row) for one in quantities(recipe, verdict))
    ]
    held.append(Known.of(THICKNESS, thickness))
    if simulation is not None:  # which alone knows contact, and the stress of each test that has a row
        rows = () if verdict is None or simulation.failure else verdict.rows
        found = [CONTACT, *(TESTS[row.test](row) for row in rows if row.test in TESTS)]
        held += [Known.of(quantity, quantity.of(simulation), note=_joined(quantity.note, when)) for quantity in found]
    return tuple(held)


def in_the_test(quantity: Quantity, row: Row | None) -> Quantity:
    """A quantity made from the stress of a checkpoint, as it is read from a simulation: in the test that decides."""
    if quantity.source != "stress" or row is None or row.test == "published rule":
        return quantity
    return replace(quantity, tested=lambda simulation: simulation.stress_of(landing=row.landing, load=row.load))


def _joined(*notes: str | None) -> str:
    return ", ".join(filter(None, notes))
