"""A styled surface as a 3MF file for a slicer: of one filament, painted in a few, or as two bodies, and what that costs to print."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np

from mechstyle.errors import BadInput
from mechstyle.geometry.bodies import shell_and_rest
from mechstyle.geometry.filaments import (
    MOST,
    USUAL,
    Palette,
    PrintCost,
    banded,
    cheaper,
    clustered,
    code_of,
    in_bands,
    painted,
    palette_of,
    print_cost,
)
from mechstyle.geometry.files import write_file
from mechstyle.geometry.threemf import Body, bodies_bytes, check_slicer, threemf_bytes, together
from mechstyle.records import Recipe
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.simulation.part import Workpiece, bounds_for
from mechstyle.styling.prompt import Wish, reading_of

FILAMENT_TYPES = ("PLA", "PETG", "ABS", "TPU")
"""Materials that slicers have a filament for by that name; of others the file speaks as of the first."""
MOST_ASKED = 3
"""Most filaments that a prompt alone brings, however many colours it names: two changes a layer."""


class Printing(msgspec.Struct, frozen=True, kw_only=True):
    """How a part is to be printed in colour.

    Attributes:
        slicer: Whose file it is, one of `geometry.threemf.SLICERS`: standard and prusa are one strict file, bambu and orca another.
        palette: Colours of the filaments in the printer, the first in slot 1: "#111111, #f4f1e8", or one by one; "" to choose them.
        colours: How many to choose, where there is no palette: 1 to 16. None for those that the prompt asks for, at most MOST_ASKED, or
            two of a style's own.
        bands: Whether the filaments lie one above the other, instead of where the style has its colours.
        bodies: Whether the part is written as a styled shell and the rest, of one filament each, instead of painted.

    Example:
        >>> ms.Printing(slicer="prusa", palette="#111111, #f4f1e8").palette
        '#111111, #f4f1e8'
    """

    slicer: str = "standard"
    palette: str | Sequence[str] = ""
    colours: int | None = None
    bands: bool = False
    bodies: bool = False

    def check(self, path: Path) -> None:
        """Refuse what contradicts itself, or another format than 3MF, before anything is drawn, with BadInput."""
        check_slicer(self.slicer)
        if path.suffix.lower() != ".3mf" and self != Printing():
            raise BadInput(f"{path.name}: slicer, filaments and bodies are said in 3MF only; call the file {path.with_suffix('.3mf').name}")
        if self.palette and self.colours is not None:
            raise BadInput("palette and colours contradict each other: name the filaments, or say how many to choose")
        if self.bodies and self.bands:
            raise BadInput("bodies and bands contradict each other: a body is of one filament")
        if self.bodies and (self.colours == 1 or (self.palette and len(palette_of(self.palette)) == 1)):
            raise BadInput("bodies and one filament contradict each other: name those of both in the palette")
        if self.palette:
            palette_of(self.palette)
        elif self.colours is not None and not 1 <= self.colours <= MOST:
            raise BadInput(f"{self.colours} colours: choose 1 to {MOST}, as many as the printer has filaments")

    def filaments(self, mesh: SurfaceMesh, asked: Palette = ()) -> Palette:
        """The palette that was given, the colours that were asked for, or some for the surface's colours."""
        assert mesh.colours is not None, "what leaves a run is coloured"
        found = palette_of(self.palette) if self.palette else clustered(mesh.colours, self.colours or USUAL)
        unsaid, needed = not self.palette and self.colours is None, 2 if self.bodies or self.bands else 1
        if unsaid and len(asked) >= needed and len(found) > 1:  # the unstylized part has one colour, and not the prompt's
            return asked if len(asked) <= MOST_ASKED else clustered(mesh.colours, MOST_ASKED)
        if self.bodies and len(found) < 2:
            raise BadInput("the part has one colour only: name the filaments of its two bodies with a palette")
        return found


def wishes_of(recipe: Recipe) -> tuple[Wish, ...]:
    """What the prompt of a recipe asks for; none where another stylizer or CLIP reads it in its own way."""
    return () if recipe.style.stylizer or recipe.style.guidance == "clip" else reading_of(recipe).wishes


def asked_for(recipe: Recipe) -> Palette:
    """The colours that a prompt asks for, if it does so wherever it asks for anything; else none, and styles bring their own."""
    wishes = wishes_of(recipe)
    if any(wish.colour is None and wish.style for wish in wishes):
        return ()
    colours = (colour for wish in wishes for colour in (wish.colour, wish.second) if colour is not None)
    return tuple(dict.fromkeys(code_of(colour) for colour in colours))


class PrintPlan(msgspec.Struct, frozen=True, kw_only=True):
    """What a file tells a slicer, and what it costs.

    Attributes:
        slicer: Whose file it is.
        palette: Colours of the filaments, that of slot 1 first.
        merged: Islands of colour that were narrower than two lines and went to their neighbours.
        cost: An estimate of the print.
        offers: What it would cost with fewer of the filaments, and last with all of them in bands; those with fewer changes only.
    """

    slicer: str
    palette: Palette
    merged: int
    cost: PrintCost
    offers: tuple[PrintCost, ...] = ()

    @property
    def words(self) -> str:
        """What a run says of its file, in one sentence, the cost first."""
        slots = ", ".join(self.palette)
        painted_in = f"is painted in {len(self.palette)} filaments, {slots}" if len(self.palette) > 1 else f"is of one filament, {slots}"
        return f"{self.cost.words} (estimate): the 3MF {painted_in}; `mechstyle export` takes others with --palette, more with --colours"


def write_for_printing(
    path: Path, styled: SurfaceMesh, part: Workpiece, recipe: Recipe, printing: Printing, *, name: str = ""
) -> PrintPlan:
    """Write the styled, coloured surface of a part as a 3MF file, which slicers call `name`."""
    mesh, kind = styled, recipe.test.material.name if recipe.test.material.name in FILAMENT_TYPES else FILAMENT_TYPES[0]
    palette, called = printing.filaments(mesh, asked_for(recipe)), name or "part"
    if printing.bodies:
        bounds = bounds_for(part, recipe)[0]
        shell, rest = shell_and_rest(part.surface, mesh, (bounds.freedom > 0.0) & ~np.asarray(bounds.plain), part.thickness)
        bodies = (Body("styled shell", shell, 0), Body("rest", rest, 1))
        paint, content = together(bodies, palette), bodies_bytes(bodies, palette, called, slicer=printing.slicer, filament_type=kind)
    else:
        paint = in_bands(mesh, palette) if printing.bands else painted(mesh, palette)
        content = threemf_bytes(mesh, called, paint=paint, slicer=printing.slicer, filament_type=kind)
    write_file(path, content)
    layer = recipe.printed.layer_height
    cost = print_cost(paint, layer)
    offers = (*([] if printing.bands else cheaper(paint, layer)), *([] if printing.bands or printing.bodies else [banded(paint, layer)]))
    fewer = tuple(offer for offer in offers if offer.changes < cost.changes)
    return PrintPlan(slicer=printing.slicer, palette=palette, merged=paint.merged, cost=cost, offers=fewer)
