"""Panels of a part: styled surface, stress, what stays bent, restraint."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mechstyle._files import write_whole
from mechstyle.errors import BadInput, unknown
from mechstyle.pictures import fields
from mechstyle.pictures.fields import Known, Quantity
from mechstyle.records import Checkpoint, Recipe, Row, Simulation, Verdict, sentences
from mechstyle.records.mesh import SurfaceMesh


def as_png(path: str | Path) -> Path:
    """The path of a picture; BadInput, with a better one, if it is not called PNG."""
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise BadInput(f"pictures are written as PNG: give {target.with_suffix('.png')} instead of {target}")
    return target


if TYPE_CHECKING:
    from collections.abc import Sequence

    from mechstyle.pictures.figure import Panel


@dataclass(frozen=True)
class Picture:
    """A PNG a notebook displays."""

    png: bytes

    def __repr__(self) -> str:
        """Its size; the bytes would stand in every notebook a second time."""
        return f"Picture({len(self.png) / 1000:.0f} kB)"

    def _repr_png_(self) -> bytes:
        return self.png

    def save(self, path: str | Path) -> Path:
        """Write the PNG to a file, and return its path; BadInput for one that is called something else."""
        target = as_png(path)
        write_whole(target, self.png)
        return target


def field_panel(
    mesh: SurfaceMesh, quantity: Quantity, values: NDArray[Any], *, title: str = "", note: str = "", view: str = "three_quarter"
) -> Panel:
    """A part coloured by a field, shape [vertex_count], as the table of quantities has it; its name is the title by default."""
    from mechstyle.pictures.figure import Panel  # noqa: PLC0415 — matplotlib is loaded when a picture is wanted

    return Panel(
        mesh, title or quantity.name, values, quantity.unit, quantity.label, quantity.limits(values), quantity.threshold, view, note,
        quantity.edge, said=quantity.said,
    )  # fmt: skip


DRAWN = 0.06
"""What stays bent is drawn about this large, over the size of the part …"""
FACTORS = (1, 2, 5, 10, 20, 50, 100)
"""… by one of these factors …"""
EDGE = 0.4
"""… or, where little of it is off by far more than is judged, this share of that."""


def exaggeration(bend: float, size: float) -> int:
    """Factor by which a bend [mm] of a part of this size [mm] is drawn."""
    return 1 if bend < sentences.NOTHING else max(factor for factor in FACTORS if factor == 1 or factor * bend <= DRAWN * size)


def exaggerated(surface: SurfaceMesh, simulation: Simulation, row: Row) -> int:
    """Factor by which what stays bent of a part after the test of a row is drawn."""
    most = np.linalg.norm(simulation.set_of(landing=row.landing, load=row.load), axis=1).max()
    return exaggeration(max(row.permanent_set, EDGE * float(most)), surface.size)


def bent_panel(
    surface: SurfaceMesh, simulation: Simulation, row: Row, *, title: str = "what stays bent", factor: int | None = None
) -> Panel:
    """A part in the shape that it keeps after the test of a row, exaggerated, coloured by how far it is off [mm]."""
    bend, quantity = simulation.set_of(landing=row.landing, load=row.load), fields.stays_bent(row)
    values, factor = quantity.values_in(simulation), factor or exaggerated(surface, simulation, row)
    shape = surface.moved(surface.vertices + np.float32(factor) * bend)
    drawn = f", drawn × {factor}" if factor > 1 else ""
    note = f"{sentences.figures(row)}; shown is the last shape that bore the load" if row.collapses else sentences.figures(row)
    panel = field_panel(shape, quantity, values, title=title + drawn, note=note)
    return replace(panel, peak=fields.most_bent(surface.vertices, row, simulation))


def stress_note(surface: SurfaceMesh, stress: NDArray[Any], strength: float, row: Row | None) -> str:
    """Of which test a picture of stress [MPa] is, shape [vertex_count], and how much of the surface yields in it."""
    share = float(surface.vertex_areas @ (stress > strength) / surface.vertex_areas.sum())
    test = "as placed" if row is None or row.test == "published rule" else sentences.label(row)
    return f"{test}: {f'{max(share, 0.001):.1%} of the surface yields' if share else 'nothing yields at the surface'}"


def styled_panel(styled: SurfaceMesh, recipe: Recipe, note: str = "") -> Panel:
    """A styled part in its colours, under its prompt."""
    from mechstyle.pictures.figure import Panel  # noqa: PLC0415 — as above

    return Panel(styled, f"“{recipe.style.prompt}”", note=note)


def checkpoint_panels(
    original: SurfaceMesh, state: Checkpoint, recipe: Recipe,
    measured: Verdict | None, measured_at: int | None, simulation: Simulation | None,
) -> list[Panel]:  # fmt: skip
    """Styled look with its outcome, stress and what stays bent in the worst test, and mask of a checkpoint, side by side.

    `measured` is the verdict of the last test that gave an answer, `simulation`, at an iteration; None if none gave one. If a later one
    failed, the picture says so.
    """
    styled = original.displaced(state.displacement).coloured(state.colour)
    when = "" if measured_at in (None, state.iteration) else f" (iteration {measured_at})"
    row, note = None if measured is None else measured.deciding, ""
    if state.verdict is not None:
        note = sentences.note(state.verdict) if state.verdict.deciding is None else sentences.title(state.verdict)
    elif measured_at != state.simulated_at:
        note = f"UNKNOWN: the later test at iteration {state.simulated_at} gave no answer"
    stress = fields.quantities(recipe, measured)[0]
    of_stress = stress_note(styled, state.stress, recipe.test.material.yield_strength, row)
    panels = [styled_panel(styled, recipe, note)]
    panels.append(field_panel(styled, stress, state.stress, title=f"stress{when}", note=of_stress))
    if row is not None and row.test != "published rule" and simulation is not None:
        panels.append(bent_panel(styled, simulation, row, title=f"what stays bent{when}"))
    held = f"{state.restrained.mean():.0%} restrained"
    return [*panels, field_panel(styled, fields.RESTRAINT, fields.RESTRAINT.values_in(state), note=held)]


def chosen_panels(styled: SurfaceMesh, found: Sequence[Known], wanted: Sequence[str]) -> list[Panel]:
    """The fields of some names, in their order, of all that are known.

    Raises:
        BadInput: If one is not known there.
    """
    by_name = {known.quantity.name: known for known in found}
    for name in wanted:
        if name not in by_name:
            raise unknown("field", name, list(by_name))
    chosen = [by_name[name] for name in wanted]
    panels = [field_panel(styled, known.quantity, known.values, title=known.quantity.title, note=known.note) for known in chosen]
    return [replace(panel, limits=known.quantity.limits(known.seen)) for panel, known in zip(panels, chosen, strict=True)]


def with_protected(panel: Panel, protected: np.ndarray) -> Panel:
    """A field with the protected vertices in hatched grey, shape [vertex_count], and their share in the note."""
    if not protected.any():
        return panel
    share = panel.mesh.vertex_areas @ protected / panel.mesh.vertex_areas.sum()
    note = f"{panel.note}; {share:.0%} protected (grey)" if panel.note else f"{share:.0%} protected (grey)"
    return replace(panel, values=np.where(protected, np.nan, np.asarray(panel.values)), note=note)


def picture(panels: Sequence[Panel], *, title: str = "", columns: int | None = None) -> Picture:
    """Panels side by side as one PNG."""
    from mechstyle.pictures.figure import figure_png  # noqa: PLC0415 — as above

    return Picture(figure_png(panels, title=title, columns=columns))
