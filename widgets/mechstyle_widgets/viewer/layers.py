"""Layers of a part: its style, or a field over its surface with a scale, a unit and perhaps a limit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import BadInput
from mechstyle.pictures.colormap import Scale
from mechstyle.pictures.fields import STAYS_BENT, Quantity, known, most_bent
from mechstyle.records import Checkpoint, Simulation
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.run import Run

STYLE = "style"
"""Name of the layer that is always there: the part's own colours."""


@dataclass(frozen=True, eq=False)
class Layer:
    """A field over a surface and how it is to be read.

    Attributes:
        name: What it is called in code, and by which it is selected.
        values: The field [unit], shape [vertex_count]; not a number where it is not known.
        label: What the legend calls it; the name by default.
        unit: Its unit, "" for none.
        limits: Values at the pale and the dark end of the colours; None takes them from the values.
        threshold: Values beyond it are set apart by colour, hatch and outline; None for none.
        note: What a reader should know about it, "" for nothing.
        title: What the menu calls it; the name by default.
        said: How a value at one place is written; as a figure with its unit if None.
        edge: What the threshold is, as `Quantity.edge` has it.
        peak: Vertex at which the greatest value is marked, None for the first that has it.
        aged: Whether it was found on the surface of an earlier iteration, so that it is no answer on this one.
    """

    name: str
    values: NDArray[Any]
    label: str = ""
    unit: str = ""
    limits: tuple[float, float] | None = None
    threshold: float | None = None
    note: str = ""
    title: str = ""
    said: Callable[[float], str] | None = None
    edge: str = "limit"
    peak: int | None = None
    aged: bool = False

    def __post_init__(self) -> None:
        """Freeze the values and refuse a scale that is none."""
        values = np.array(self.values, dtype=np.float32)
        values.setflags(write=False)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "label", self.label or self.name)
        object.__setattr__(self, "title", self.title or self.name.replace("_", " "))
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
        words = f"{round(value, 2) + 0.0:g}" if self.unit == "mm" else f"{value:.4g}"  # a caliper reads no more
        return f"{words} {self.unit}".rstrip() if np.isfinite(value) else "not known"

    def text_at(self, vertex: int) -> str:
        """The value at a vertex as a person reads it."""
        value = float(self.values[vertex])
        return self.at(vertex) if self.said is None or not np.isfinite(value) else self.said(value)

    def extremes(self) -> tuple[int, int] | None:
        """Vertices of the greatest and of the least value; None where nothing is known or all is alike."""
        known = np.isfinite(self.values)
        if not known.any() or np.ptp(self.values[known]) == 0:
            return None
        return int(np.nanargmax(self.values)) if self.peak is None else self.peak, int(np.nanargmin(self.values))


@dataclass(frozen=True, eq=False)
class Subject:
    """Subject of the view: the part [mm], fields over its surface, and what stays bent of it.

    Attributes:
        mesh: The part.
        layers: The fields.
        bend: Displacement that stays in the test that decides [mm], shape [vertex_count, 3]; None where that is not known.
    """

    mesh: SurfaceMesh
    layers: tuple[Layer, ...] = ()
    bend: NDArray[np.float32] | None = None

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
        return replace(self, layers=tuple(kept if layer in kept else [*kept, layer]))

    def layer(self, name: str) -> Layer | None:
        """The layer of a name, None if there is none."""
        return next((layer for layer in self.layers if layer.name == name), None)

    @property
    def most_bent(self) -> float:
        """The largest displacement that stays [mm]."""
        return 0.0 if self.bend is None else float(np.linalg.norm(self.bend, axis=1).max())

    def bent(self, factor: float) -> Subject:
        """The same in the shape that stays, exaggerated by a factor, which its layer tells."""
        layer = self.layer(STAYS_BENT)
        if layer is None or self.bend is None:
            return self
        with_factor = replace(layer, note=f"{layer.note}, bend drawn × {factor:g}")
        return replace(self.with_layer(with_factor), mesh=self.mesh.moved(self.mesh.vertices + factor * self.bend))


def layer_of(quantity: Quantity, values: NDArray[Any], seen: NDArray[Any] | None = None, note: str = "") -> Layer:
    """A layer of a quantity with a field [unit], shape [vertex_count], and perhaps a note instead of the quantity's own.

    The colours show all of `seen`, of any shape; the values by default.
    """
    limits, text_at = quantity.limits(values if seen is None else seen), note or quantity.note
    words = (text_at, quantity.title, quantity.said, quantity.edge)
    return Layer(quantity.name, values, quantity.label, quantity.unit, limits, quantity.threshold, *words)


def subject_of(run: Run, state: Checkpoint) -> Subject:
    """A checkpoint of a run, styled and coloured, with every field that is known there."""
    mesh = run.part.surface.displaced(state.displacement).coloured(state.colour)
    simulation = run.store.objects.get_record(state.simulation, Simulation) if state.simulation else None
    recipe, newest, verdict = run.store.recipe(state.recipe), run.store.checkpoint(run.store.lane(run.lane).head), run.store.verdict(state)
    found = known(recipe, state, simulation, run.part.thickness, newest, verdict)
    layers = (replace(layer_of(field.quantity, field.values, field.seen, field.note), aged=field.aged) for field in found)
    subject = Subject(mesh, tuple(layers))
    row, bent = None if verdict is None else verdict.deciding, subject.layer(STAYS_BENT)
    if row is None or simulation is None:
        return subject
    if bent is not None:
        subject = subject.with_layer(replace(bent, peak=most_bent(mesh.vertices, row, simulation)))
    return replace(subject, bend=simulation.set_of(landing=row.landing, load=row.load))
