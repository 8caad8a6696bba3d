"""Places that are kept: a numbered list with what is known of each, to save as a table."""

from __future__ import annotations

import base64
import csv
import io
import math
from collections.abc import Callable, Sequence
from functools import partial

import ipywidgets
import numpy as np

from mechstyle_widgets.jupyter.language import word
from mechstyle_widgets.jupyter.looks import close_family, lean, show
from mechstyle_widgets.viewer.layers import Layer, Subject

COLUMNS = (("stress", "stress [MPa]"), ("stays_bent", "stays bent [mm]"), ("thickness", "wall [mm]"))
"""Layers the list shows, and what it calls them."""
WIDTHS = "30px minmax(104px, 152px) repeat(3, minmax(44px, 96px)) 40px"
BOM = "\ufeff"
"""Spreadsheets take a file without it for Latin-1."""


class Places(ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """The list under the view, nothing while it is empty; as text in `rows`, a place and a value for each of COLUMNS, as CSV in `table`."""

    def __init__(self, fly: Callable[[int], None], remove: Callable[[int | None], None]) -> None:
        """An empty list; `fly` is called with the place, counted from 0, to look at, `remove` with the one to take away, None for all."""
        self.rows: list[list[str]] = []
        self.table = ""
        self._fly, self._remove = fly, remove
        self._save = lean(ipywidgets.HTML)
        clear = lean(ipywidgets.Button, description="clear", tooltip="Take all places away", layout={"width": "auto"})
        clear.on_click(lambda _: remove(None))
        self._head = [lean(ipywidgets.HTML, word(title)) for title in ("", "place [mm]", *(title for _, title in COLUMNS), "")]
        for title in self._head:
            title.add_class("mechstyle-place-head")
        self._lines: list[list[ipywidgets.Widget]] = []  # made when they are first wanted and kept, so that none is made twice
        self._grid = lean(ipywidgets.GridBox, self._head, layout={"grid_template_columns": WIDTHS, "overflow": "visible"})
        above = lean(ipywidgets.HBox, [lean(ipywidgets.HTML, f"<b>{word('Places')}</b>"), self._save, clear])
        super().__init__([above, self._grid], layout={"display": "none"})
        self.add_class("mechstyle-places")

    def show(self, subject: Subject, vertices: Sequence[int]) -> None:
        """List vertices of a subject with their values in it."""
        fewer = len(vertices) < len(self.rows)
        self.rows = [_row(subject, vertex) for vertex in vertices]
        self.table = as_csv(subject, vertices) if vertices else ""
        while len(self._lines) < len(self.rows):
            self._lines.append(self._line(len(self._lines)))
        for line, row in zip(self._lines, self.rows, strict=False):
            for cell, text in zip(line[1:-1], row, strict=True):
                cell.value = text
        self._grid.children = [*self._head, *(widget for line in self._lines[: len(vertices)] for widget in line)]
        data = base64.b64encode((BOM + self.table).encode()).decode("ascii")
        tip, what = word("Save the places as CSV"), word("save {}").format("CSV")
        link = f'<a download="mechstyle-places.csv" title="{tip}" href="data:text/csv;base64,{data}">{what}</a>'
        self._save.value = link if vertices else ""
        show(self, vertices)
        if fewer and vertices:
            self._lines[len(vertices) - 1][-1].focus()  # what had the focus may be gone, and keys would go to the page

    def close(self) -> None:
        """Close it and the lines that are out of sight."""
        close_family(self, *(widget for line in self._lines for widget in line))
        super().close()

    def _pressed(self, act: Callable[[int], None], number: int, _button: object) -> None:
        if number < len(self.rows):  # the line may be gone by now
            act(number)

    def _line(self, number: int) -> list[ipywidgets.Widget]:
        pin = lean(ipywidgets.Button, description=str(number + 1), tooltip=word("Look at place {}").format(number + 1))
        pin.add_class("mechstyle-pin")
        away = lean(ipywidgets.Button, icon="times", tooltip=word("Take place {} away").format(number + 1), layout={"width": "28px"})
        for button, act in ((pin, self._fly), (away, self._remove)):
            button.on_click(partial(self._pressed, act, number))
        return [pin, *(lean(ipywidgets.HTML) for _ in range(1 + len(COLUMNS))), away]


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


def _row(subject: Subject, vertex: int) -> list[str]:
    place = ", ".join(f"{value:.1f}" for value in subject.mesh.vertices[vertex])
    return [place, *("–" if (layer := subject.layer(name)) is None else _figure(layer, vertex) for name, _ in COLUMNS)]


def _figure(layer: Layer, vertex: int) -> str:
    """A value without its unit, as what tells it elsewhere has it; the heading of the column names the unit."""
    value = float(layer.values[vertex])
    if not math.isfinite(value):
        return "–"
    return f"{value:.3g}" if layer.said is None else layer.said(value).removesuffix(f" {layer.unit}")
