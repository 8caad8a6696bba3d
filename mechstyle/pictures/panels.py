"""Panels of a checkpoint: styled surface, stress, restraint."""

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
from mechstyle.records import Checkpoint, Recipe, Verdict, sentences
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
        quantity.judged, quantity.most,
    )  # fmt: skip


def checkpoint_panels(
    original: SurfaceMesh, state: Checkpoint, recipe: Recipe, measured: Verdict | None, measured_at: int | None
) -> list[Panel]:
    """Styled look, stress of the last test that gave an answer, and mask of a checkpoint, side by side.

    `measured` is the verdict of that test, at an iteration, None if none gave an answer; if a later one failed, the picture says so.
    """
    from mechstyle.pictures.figure import Panel  # noqa: PLC0415 — as above

    styled = original.displaced(state.displacement).coloured(state.colour)
    when = "" if measured_at in (None, state.iteration) else f" (iteration {measured_at})"
    row = None if measured is None else measured.deciding
    note = "" if row is None else sentences.figures(row)
    if state.verdict is not None:
        note = sentences.note(state.verdict)
    elif measured_at != state.simulated_at:
        note = f"UNKNOWN: the later test at iteration {state.simulated_at} gave no answer"
    stress = fields.quantities(recipe, measured)[0]
    return [
        Panel(styled, f"“{recipe.style.prompt}”"), field_panel(styled, stress, stress.of(state), title=f"stress{when}", note=note),
        field_panel(styled, fields.RESTRAINT, fields.RESTRAINT.of(state), note=f"{state.restrained.mean():.0%} restrained"),
    ]  # fmt: skip


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


def comparison(original: SurfaceMesh, start: Checkpoint, finals: Sequence[tuple[str, Checkpoint, Recipe]]) -> Picture:
    """The plain part next to several results of one prompt: look above, stress of the test that decides below and from underneath.

    Each result has a name, its last checkpoint and its recipe; `start` is the checkpoint of the plain part.
    """
    from mechstyle.pictures.figure import Panel  # noqa: PLC0415 — as above

    rows: list[list[Panel]] = [[], [], []]
    shown = [("plain part", start, finals[0][2]), *finals]
    stresses = [fields.quantities(recipe, state.verdict)[0] for _, state, recipe in shown]
    highest = max(high for stress, (_, state, _) in zip(stresses, shown, strict=True) for high in (stress.limits(stress.of(state)) or ()))
    for stress, (name, state, _) in zip(stresses, shown, strict=True):
        styled = original.displaced(state.displacement).coloured(state.colour)
        rows[0].append(Panel(styled, name))
        for row, view, title in ((1, "three_quarter", "stress"), (2, "below", "from below")):
            note = sentences.note(state.verdict) if row == 1 and state.verdict is not None else ""
            panel = field_panel(styled, stress, stress.of(state), title=title, note=note, view=view)
            rows[row].append(replace(panel, limits=(0.0, highest)))
    return picture([panel for row in rows for panel in row], title=f"“{finals[0][2].style.prompt}”", columns=len(shown))
