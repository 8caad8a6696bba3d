"""Places that are kept: a numbered list with what is known of each, to save as a table."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from importlib.resources import files
from typing import Any

import anywidget
import numpy as np
import traitlets

from mechstyle_widgets.viewer.layers import Subject

COLUMNS = (("stress", "stress [MPa]"), ("safety_factor", "safety factor"), ("thickness", "wall [mm]"))
"""Layers the list shows, and what it calls them."""


def _static(name: str) -> str:
    return files("mechstyle_widgets.viewer").joinpath("static", name).read_text(encoding="utf-8")


class Places(anywidget.AnyWidget):
    """The list under the view.

    Attributes:
        head: Titles of the columns.
        rows: Text of each cell, a row for each place.
        table: All that is known of the places, as CSV.
    """

    _esm, _css = _static("places.js"), _static("places.css")
    head = traitlets.List().tag(sync=True)
    rows = traitlets.List().tag(sync=True)
    table = traitlets.Unicode("").tag(sync=True)

    def __init__(self, fly: Callable[[int], None], remove: Callable[[int | None], None]) -> None:
        """An empty list; `fly` is told which place, counted from 0, to look at, `remove` which to take away, None for all."""
        super().__init__(head=["", "place [mm]", *(title for _, title in COLUMNS)])
        self._fly, self._remove = fly, remove
        self.on_msg(self._hear)

    def show(self, subject: Subject, vertices: Sequence[int]) -> None:
        """List vertices of a subject with their values in it."""
        self.rows = [[_place(subject, vertex), *(_value(subject, name, vertex) for name, _ in COLUMNS)] for vertex in vertices]
        self.table = as_csv(subject, vertices) if vertices else ""

    def _hear(self, _widget: Any, message: Any, _buffers: Any) -> None:
        number = message.get("number")
        if number is not None and not 0 <= number < len(self.rows):  # a click on a row that is gone by now
            return
        if message.get("kind") == "fly" and number is not None:
            self._fly(number)
        elif message.get("kind") == "remove":
            self._remove(number)


def as_csv(subject: Subject, vertices: Sequence[int]) -> str:
    """All that is known of vertices, as CSV: number, place [mm], and the value of every layer, empty where it is not known."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    named = [f"{layer.title} [{layer.unit}]" if layer.unit else layer.title for layer in subject.layers]
    table.writerow(["number", "x [mm]", "y [mm]", "z [mm]", *named])
    for number, vertex in enumerate(vertices, start=1):
        values = [*subject.mesh.vertices[vertex], *(layer.values[vertex] for layer in subject.layers)]
        table.writerow([number, *(f"{value:.6g}" if np.isfinite(value) else "" for value in values)])
    return text.getvalue()


def _place(subject: Subject, vertex: int) -> str:
    return ", ".join(f"{value:.1f}" for value in subject.mesh.vertices[vertex])


def _value(subject: Subject, name: str, vertex: int) -> str:
    layer = subject.layer(name)
    return "–" if layer is None or not np.isfinite(layer.values[vertex]) else f"{layer.values[vertex]:.3g}"
