"""What can be painted on a part: its style, or a field over its surface with a scale, a unit and perhaps a limit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mechstyle.errors import BadInput
from mechstyle.pictures.colormap import Scale
from mechstyle.records import Checkpoint, Simulation
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.run import Run

STYLE = "style"
"""Name of the layer that is always there: the part's own colours."""


@dataclass(frozen=True, eq=False)
class Layer:
    """A field over a surface and how it is to be read.

    Attributes:
        name: What it is called in code and by which it is selected.
        values: The field [unit], shape [vertex_count]; not a number where it is not known.
        label: What it is called on screen; the name by default.
        unit: Its unit, "" for none.
        limits: Values at the two ends of the colours; None takes them from the values.
        threshold: Values above it are set apart by colour, hatch and outline; None for none.
        note: What a reader should know about it, "" for nothing.
    """

    name: str
    values: NDArray[Any]
    label: str = ""
    unit: str = ""
    limits: tuple[float, float] | None = None
    threshold: float | None = None
    note: str = ""

    def __post_init__(self) -> None:
        """Freeze the values and refuse a scale that is none."""
        values = np.array(self.values, dtype=np.float32)
        values.setflags(write=False)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "label", self.label or self.name)
        if self.name == STYLE:
            raise BadInput(f"a layer cannot be called {STYLE!r}, which is the part's own look; give it another name")
        if values.ndim != 1:
            raise BadInput(f"layer {self.name!r} needs one value for each vertex, but got an array of shape {values.shape}")
        _ = self.scale

    @property
    def scale(self) -> Scale:
        """Its colours."""
        if self.limits is not None:
            return Scale(*self.limits, self.threshold)
        known = self.values[np.isfinite(self.values)]
        low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
        return Scale(low, high if high > low else low + max(abs(low), 1.0), self.threshold)

    @property
    def caption(self) -> str:
        """Label and unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    def at(self, vertex: int) -> str:
        """The value at a vertex, with its unit."""
        value = float(self.values[vertex])
        return f"{value:.4g} {self.unit}".rstrip() if np.isfinite(value) else "not known"

    def extremes(self) -> tuple[int, int] | None:
        """Vertices of the greatest and of the least value; None where nothing is known or all is alike."""
        known = np.isfinite(self.values)
        if not known.any() or np.ptp(self.values[known]) == 0:
            return None
        return int(np.nanargmax(self.values)), int(np.nanargmin(self.values))


@dataclass(frozen=True, eq=False)
class Subject:
    """What is in view.

    Attributes:
        mesh: The part [mm].
        layers: Fields over its surface.
    """

    mesh: SurfaceMesh
    layers: tuple[Layer, ...] = ()

    def __post_init__(self) -> None:
        """Refuse a layer of another part, and two of one name."""
        names = [layer.name for layer in self.layers]
        for layer in self.layers:
            if len(layer.values) != len(self.mesh.vertices):
                count, given = len(self.mesh.vertices), len(layer.values)
                raise BadInput(f"layer {layer.name!r} has {given} values, but the part has {count} vertices: give one for each")
            if names.count(layer.name) > 1:
                raise BadInput(f"two layers are called {layer.name!r}: give each a name of its own")

    def with_layer(self, layer: Layer) -> Subject:
        """The same with a layer added, or put in the place of the one of its name."""
        kept = [layer if other.name == layer.name else other for other in self.layers]
        return Subject(self.mesh, tuple(kept if layer in kept else [*kept, layer]))

    def layer(self, name: str) -> Layer | None:
        """The layer of a name, None if there is none."""
        return next((layer for layer in self.layers if layer.name == name), None)


def subject_of(run: Run, state: Checkpoint) -> Subject:
    """A checkpoint of a run, styled and coloured, with every field that is known there."""
    mesh = run.part.surface.displaced(state.displacement).coloured(state.colour)
    simulation = run.store.objects.get_record(state.simulation, Simulation) if state.simulation else None
    simulated = () if simulation is None else simulation_layers(simulation, stress_limit(run, state))
    return Subject(mesh, (*checkpoint_layers(run, state), *simulated))


def stress_limit(run: Run, state: Checkpoint) -> float:
    """What the stress may at most be [MPa]: the verdict's limit, before the first verdict the material's strength."""
    verdict, parent = state.verdict, state.parent
    while verdict is None and parent:
        entry = run.store.entry(parent)
        verdict, parent = entry.verdict, entry.parent
    return run.recipe.material.yield_strength if verdict is None else verdict.deciding.limit


def checkpoint_layers(run: Run, state: Checkpoint) -> tuple[Layer, ...]:
    """The fields a checkpoint holds: stress, demand, mask, displacement; and the wall thickness."""
    limit, newest = stress_limit(run, state), run.store.checkpoint(run.store.lane(run.lane).head)
    reach = max(float(np.abs(one.displacement).max()) for one in (state, newest)) or 1.0
    threshold = run.store.recipe(state.recipe).threshold
    when = "" if state.simulated_at == state.iteration else f"simulated at iteration {state.simulated_at}"
    return (
        Layer("stress", state.stress, "von Mises stress", "MPa", _over(state.stress, limit), limit, when),
        Layer("demand", state.demand, "demand s_norm", "", _over(state.demand, threshold), threshold, when),
        Layer("mask", 1.0 - state.mask, "held back by the mask", "", (0.0, 1.0), None, "1 = may not move any further"),
        Layer("displacement", state.displacement, "displacement", "mm", (-reach, reach), None, "positive is outwards"),
        Layer("thickness", run.part.thickness, "wall thickness", "mm"),
    )


def simulation_layers(simulation: Simulation, limit: float) -> tuple[Layer, ...]:
    """The fields only a simulation holds: contact, and the worst of all orientations if they were run."""
    contact = Layer("contact", simulation.contact, "touched the floor", "", (0.0, 1.0), None, "1 = touched the floor as placed")
    if simulation.overall is None:
        return (contact,)
    worst = Layer("envelope", simulation.envelope, "worst of all orientations", "MPa", _over(simulation.envelope, limit), limit)
    chance = Layer(
        "probability", simulation.probability, "failure probability", "", (0.0, 1.0), None, "of random drops, to exceed the yield strength"
    )
    return (contact, worst, chance)


def _over(values: ArrayLike, threshold: float) -> tuple[float, float]:
    """Limits from 0 that show all values and the threshold."""
    return 0.0, max(float(np.nanmax(values)), 1.05 * threshold)
