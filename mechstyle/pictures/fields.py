"""The table of what can be looked at on a part: how each quantity is called, measured, scaled and set apart above a threshold.

Figures, viewer, replay and report read it, so that a field has one label, one unit and one threshold wherever it is shown.
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

BENT_ABOVE = 1.5
"""End of the colours of what stays bent over what is allowed: a part that gives way is hatched, and its neighbours still differ."""

MOMENT, STAYS_BENT = "moment", "stays_bent"
"""Names of the stress at one moment of an impact, and of what stays bent in the test that decides."""

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
    # reads it from a simulation, which holds it for several tests; None if it is an array of the simulation
    tested: Callable[[Simulation], NDArray[Any]] | None = None
    title: str = ""  # what a button or a menu calls it; "" for its name
    edge: str = "limit"  # what its threshold is

    def __post_init__(self) -> None:
        object.__setattr__(self, "title", self.title or self.name.replace("_", " "))

    @property
    def source(self) -> str:
        """Name of the array it is made from, in a checkpoint or a simulation."""
        return self.stored or self.name

    def made(self, array: NDArray[Any]) -> NDArray[Any]:
        """Its values from that array, same shape."""
        return array if self.formed is None else self.formed(array)

    def values_in(self, state: object) -> NDArray[Any]:
        """Its values in a checkpoint or a simulation, shape [vertex_count]."""
        if self.tested is not None and isinstance(state, Simulation):
            return self.tested(state)
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


def stress(strength: float, row: Row | None = None) -> Quantity:
    """Stress against the yield strength [MPa]: of a simulation in the test of a row, as placed and under loads without one."""
    quantity = replace(_against(strength, "stress", "von Mises stress at the surface", "MPa"), edge="yields at")
    if row is None or row.test == "published rule":
        return quantity
    landing, load = row.landing, row.load
    return replace(quantity, note=sentences.label(row), tested=lambda simulation: simulation.stress_of(landing=landing, load=load))


def stress_in(row: Row, strength: float) -> Quantity:
    """Stress in the landing or under the load of a row against the yield strength [MPa]."""
    test = row.load or row.landing
    named = f"stress_{re.sub('[^A-Za-z0-9]+', '_', test).strip('_')}"  # what any file can call it by
    return replace(stress(strength, row), name=named, title=f"stress, {test}", label=f"von Mises stress, {sentences.label(row)}")


def moment(strength: float) -> Quantity:
    """Stress at one moment of an impact against the yield strength [MPa]."""
    return replace(_against(strength, MOMENT, "stress of the moment", "MPa"), title="stress of the moment", edge="yields at")


def stays_bent(row: Row) -> Quantity:
    """What stays bent of the surface in the test of a row against what is allowed there [mm]; it ends at the figure that was judged."""

    def length(simulation: Simulation) -> NDArray[np.float32]:
        return judged(np.linalg.norm(simulation.set_of(landing=row.landing, load=row.load), axis=1), row)

    return Quantity(
        STAYS_BENT, "what stays bent", "mm", (0.0, BENT_ABOVE * row.allowed), row.allowed, sentences.label(row), bounded=True,
        tested=length, edge="allowed", said=lambda length: sentences.bend_in(row, length),
    )  # fmt: skip


def judged(lengths: ArrayLike, row: Row) -> NDArray[np.float32]:
    """What stays bent at the vertices as the verdict has it [mm], shape [vertex_count].

    A verdict takes what more than a small volume exceeds, of the tetrahedra. So the field ends there, and where the vertices miss it the
    one that is off most stands for it. Of a part that gives way there is no such figure: its last shape is shown as it was.
    """
    given = np.array(lengths, np.float32)
    if row.collapses or not given.any():
        return given
    clipped = np.minimum(given, np.float32(row.permanent_set))
    clipped[given.argmax()] = np.float32(row.permanent_set)
    return clipped


def most_bent(vertices: ArrayLike, row: Row, simulation: Simulation) -> int:
    """The vertex at which the part counts as most bent in the test of a row: of those that are, the nearest to the place judged.

    `vertices` are those of the displaced part [mm], shape [vertex_count, 3].
    """
    field = stays_bent(row).values_in(simulation)
    most = np.flatnonzero(field >= field.max())
    return int(most[np.linalg.norm(np.asarray(vertices)[most] - np.asarray(row.where), axis=1).argmin()])


def demand(recipe: Recipe) -> Quantity:
    """Demand as a recipe has it normalised, against its threshold."""
    return _against(recipe.restraint.threshold, "demand", DEMAND_LABELS[recipe.restraint.normalisation])


def _against(threshold: float, name: str, label: str, unit: str = "") -> Quantity:
    return Quantity(name, label, unit, (0.0, ROOM_ABOVE * threshold), threshold)


RESTRAINT = Quantity(
    "restraint", "share of movement held back", least=(0.0, 1.0), note="1 = may not move any further", stored="mask",
    formed=lambda mask: 1.0 - mask,
)  # fmt: skip
DISPLACEMENT = Quantity("displacement", "displacement along the normal", "mm", note="positive is outwards", mirrored=True)
THICKNESS = Quantity("thickness", "wall thickness", "mm", title="wall thickness")
CONTACT = Quantity(
    "contact", "touched the floor", least=(0.0, 1.0), note="1 = touched the floor as placed",
    said=lambda value: "yes" if value >= 0.5 else "no", title="touched the floor",
)  # fmt: skip


def quantities(recipe: Recipe, verdict: Verdict | None) -> tuple[Quantity, ...]:
    """The fields of a checkpoint and its last simulation, in the order in which they are offered.

    What stays bent is among them where the verdict knows a test of it; it alone is no array of a checkpoint.

    Args:
        recipe: The recipe in force there.
        verdict: The newest verdict there, None before the first.
    """
    row = None if verdict is None else verdict.deciding
    bent = () if row is None or row.test == "published rule" else (stays_bent(row),)
    return stress(recipe.test.material.yield_strength, row), *bent, RESTRAINT, demand(recipe), DISPLACEMENT


@dataclass(frozen=True, eq=False)
class Known:
    """A field of a checkpoint: a quantity with its values."""

    quantity: Quantity  # its row of the table
    values: NDArray[Any]  # the field [unit], shape [vertex_count]
    seen: NDArray[Any]  # what the colours have to show, of any shape
    note: str  # what a reader should know of these values, "" for nothing
    aged: bool = False  # whether they were found on the surface of an earlier iteration, so that they are no answer on this one

    @classmethod
    def of(cls, quantity: Quantity, values: NDArray[Any], *more: NDArray[Any], when: str = "") -> Known:
        """Values, which the colours have to show together with `more`, and since when they are known, "" for now."""
        note = ", ".join(filter(None, (quantity.note, when)))
        return cls(quantity, values, np.stack([values, *more]) if more else values, note, bool(when))


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
    found = list[Known]()
    for quantity in quantities(recipe, verdict):
        since = "" if quantity.name in (DISPLACEMENT.name, RESTRAINT.name) else when
        more = [newest.displacement] if quantity.name == DISPLACEMENT.name else []
        if quantity.name != STAYS_BENT:
            found.append(Known.of(quantity, quantity.values_in(state), *more, when=since))
        elif simulation is not None:
            found.append(Known.of(quantity, quantity.values_in(simulation), when=since))
    found.append(Known.of(THICKNESS, thickness))
    if simulation is not None:  # which alone knows contact, and the stress of each test that has a row
        rows = () if verdict is None or simulation.failure else verdict.rows
        strength = recipe.test.material.yield_strength
        of_tests = [CONTACT, *(stress_in(row, strength) for row in rows if row.test != "published rule")]
        found += [Known.of(one, one.values_in(simulation), when=when) for one in of_tests]
    return tuple(found)
