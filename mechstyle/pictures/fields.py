"""The table of what can be looked at on a part: how each quantity is called, measured, scaled and set apart above a threshold.

Figures, viewer, replay and report read it, so that a field has one label, one unit and one threshold wherever it is shown.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechstyle.records import Checkpoint, Recipe, Simulation, Verdict

ROOM_ABOVE = 1.05
"""Least end of the colours over the threshold, so that what lies above it can be seen on the bar."""

MOMENT = "moment"
"""Name of the stress at one moment of an impact."""

SPARE = 4.0
"""Safety factor at the pale end of its colours: what is above it is in no danger."""
AMPLE = 10.0
"""Safety factors are told up to here; more of it, up to that of no stress at all, is of no use to anybody."""

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
        threshold: Values beyond it are set apart, None for none.
        note: What a reader should know about it, "" for nothing.
        mirrored: Whether the colours reach as far below zero as above it.
        bounded: Whether the colours reach from and to `least` and no farther, whatever the values.
        stored: Name of the stored array it is made from; "" for that of its own name.
        formed: Makes it from that array, None if it is that array.
        said: How a value at one place is told; as a figure with its unit if None.
        each: Where the tests of a simulation have limits of their own, what each of them makes of its stress, by its load, "" for the drop;
            the least is told.
    """

    name: str
    label: str
    unit: str = ""
    least: tuple[float, float] | None = None
    threshold: float | None = None
    note: str = ""
    mirrored: bool = False
    bounded: bool = False
    stored: str = ""
    formed: Callable[[NDArray[Any]], NDArray[Any]] | None = None
    said: Callable[[float], str] | None = None
    each: tuple[tuple[str, Quantity], ...] = ()

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
        if self.each and isinstance(state, Simulation):
            return np.minimum.reduce([one.made(state.load_stress(load) if load else state.drop_stress) for load, one in self.each])
        return self.made(getattr(state, self.source))

    def known_best(self, state: Checkpoint, simulation: Simulation | None) -> NDArray[Any]:
        """Its values in a checkpoint, shape [vertex_count], from its last simulation where that knows more and did not break down."""
        return self.of(state if simulation is None or simulation.failure or not self.each else simulation)

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


def stress(limit: float) -> Quantity:
    """Stress against what it may at most be [MPa]."""
    return _against(limit, "stress", "von Mises stress at the surface", "MPa")


def envelope(limit: float) -> Quantity:
    """Largest stress of all orientations against what it may at most be [MPa]."""
    return _against(limit, "envelope", "worst stress of all landings", "MPa")


def moment(limit: float) -> Quantity:
    """Stress at one moment of an impact against what it may at most be [MPa]."""
    return _against(limit, MOMENT, "stress of the moment", "MPa")


def tilted(limit: float) -> Quantity:
    """Largest stress of the landings nearly as placed against what it may at most be [MPa]."""
    return _against(limit, "tilted_stress", "worst stress of the landings tilted by 3°", "MPa")


def safety_factor(limit: float, each: Sequence[tuple[str, float]] = ()) -> Quantity:
    """Limit [MPa] over the stress that decides, dropped as placed and under loads: its least is the factor of that rule.

    Args:
        limit: What the largest of all stress may at most be [MPa].
        each: The same of each test by itself, by the name of its load, "" for the drop; none where there is one test.
    """

    def factor(stress: NDArray[Any]) -> NDArray[Any]:
        return np.minimum(limit / np.maximum(stress, limit / AMPLE), AMPLE).astype(np.float32)

    return Quantity(
        "safety_factor", "safety factor as it stands: limit over stress", least=(SPARE, 0.0), threshold=1.0,
        note=f"{AMPLE:.0f} stands for that and more", bounded=True, stored="stress", formed=factor,
        each=tuple((load, safety_factor(own)) for load, own in each),
    )  # fmt: skip


def demand(recipe: Recipe) -> Quantity:
    """Demand as a recipe has it normalised, against its threshold."""
    return _against(recipe.threshold, "demand", DEMAND_LABELS[recipe.normalisation])


def probability(strength: float) -> Quantity:
    """Probability that a random drop exceeds a strength [MPa]."""
    label = f"probability to exceed {strength:.1f} MPa"
    return Quantity("probability", label, least=(0.0, 1.0), note="of a random drop", said=_per_cent)


def _per_cent(share: float) -> str:
    if 0.0 < share < 0.001:
        return "under 0.1 %"
    return f"{100.0 * share:.{1 if 0.0 < share < 0.1 else 0}f} %"


def _yes_or_no(value: float) -> str:
    return "yes" if value >= 0.5 else "no"


def _against(threshold: float, name: str, label: str, unit: str = "") -> Quantity:
    return Quantity(name, label, unit, (0.0, ROOM_ABOVE * threshold), threshold)


RESTRAINT = Quantity(
    "restraint", "share of movement held back", least=(0.0, 1.0), note="1 = may not move any further", stored="mask",
    formed=lambda mask: 1.0 - mask,
)  # fmt: skip
DISPLACEMENT = Quantity("displacement", "displacement along the normal", "mm", note="positive is outwards", mirrored=True)
ADDED = Quantity("added", "added along the normal", "mm", least=(0.0, 0.1), note="what strengthening put on")
THICKNESS = Quantity("thickness", "wall thickness", "mm")
CONTACT = Quantity("contact", "touched the floor", least=(0.0, 1.0), note="1 = touched the floor as placed", said=_yes_or_no)


TITLES = {
    "safety_factor": "safety factor",
    "thickness": "wall thickness",
    "contact": "touched the floor",
    "tilted_stress": "worst tilted landing",
    "envelope": "worst of all landings",
    MOMENT: "stress of the moment",
}
"""What a menu calls a quantity, where that is not its name."""


def quantities(recipe: Recipe, limit: float, each: Sequence[tuple[str, float]] = ()) -> tuple[Quantity, ...]:
    """The fields every checkpoint holds, in the order in which they are offered.

    Args:
        recipe: The recipe in force there.
        limit: What the stress may at most be [MPa].
        each: Of each test by itself, as for `safety_factor`.
    """
    return stress(limit), safety_factor(limit, each), RESTRAINT, demand(recipe), DISPLACEMENT


@dataclass(frozen=True, eq=False)
class Known:
    """A field of a checkpoint: a quantity with its values.

    Attributes:
        quantity: Its row of the table.
        values: The field [unit], shape [vertex_count].
        seen: What the colours have to show, of any shape.
        note: What a reader should know of these values, "" for nothing.
    """

    quantity: Quantity
    values: NDArray[Any]
    seen: NDArray[Any]
    note: str

    @classmethod
    def of(cls, quantity: Quantity, values: NDArray[Any], *more: NDArray[Any], note: str = "") -> Known:
        """Values, which the colours have to show together with `more`, and a note, the quantity's own by default."""
        return cls(quantity, values, np.stack([values, *more]) if more else values, note or quantity.note)


def known(
    recipe: Recipe,
    limit: float,
    state: Checkpoint,
    simulation: Simulation | None,
    thickness: NDArray[Any],
    newest: Checkpoint,
    verdict: Verdict | None,
) -> tuple[Known, ...]:
    """Every field that is known of a checkpoint, in the order in which they are offered.

    Args:
        recipe: The recipe in force there.
        limit: What the stress may at most be [MPa].
        state: The checkpoint.
        simulation: Its last simulation, None if there was none.
        thickness: Wall thickness of the part [mm], shape [vertex_count].
        newest: The last checkpoint of its lane, so that displacement keeps its colours from iteration to iteration.
        verdict: The newest verdict there, None before the first.
    """
    when = "" if state.simulated_at == state.iteration else f"simulated at iteration {state.simulated_at}"
    aged, seen = dict.fromkeys(("stress", "safety_factor", "demand"), when), {DISPLACEMENT.name: [newest.displacement]}
    held = [
        Known.of(quantity, quantity.known_best(state, simulation), *seen.get(quantity.name, ()), note=aged.get(quantity.name, ""))
        for quantity in quantities(recipe, limit, () if verdict is None else verdict.each)
    ]
    return (*held, Known.of(THICKNESS, thickness), *(() if simulation is None else _of_simulation(recipe, limit, simulation, verdict)))


def _of_simulation(recipe: Recipe, limit: float, simulation: Simulation, verdict: Verdict | None) -> list[Known]:
    """The fields only a simulation holds: contact, and the worst of tilted landings and of all if they were dropped."""
    found = [Known.of(CONTACT, CONTACT.of(simulation))]
    if simulation.tilted is not None and verdict is not None and verdict.tilted is not None:
        found.append(Known.of(tilted(verdict.tilted.limit), simulation.tilted_stress))
    if simulation.overall is None:
        return found
    worst = simulation.worst
    landing = "" if worst is None or not worst.name else f"most by the landing {worst.name}: {worst.measures.peak:.1f} MPa"
    found.append(Known.of(envelope(limit), simulation.envelope, note=landing))
    if recipe.random_drops:
        found.append(Known.of(probability(recipe.material.yield_strength), simulation.probability))
    return found
