"""Taking a part out of a run: the file, what is known of that very surface, and what to look at before printing it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle._files import write_whole
from mechstyle.geometry.files import check_holds_fields, save
from mechstyle.geometry.glb import DULL, Sheen
from mechstyle.geometry.print_quality import Quality, quality
from mechstyle.loop.objects import to_json
from mechstyle.loop.store import Entry, Store
from mechstyle.pictures.fields import Known
from mechstyle.records import Checkpoint, Recipe, Verdict, sentences
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.runs.known_fields import known_fields
from mechstyle.runs.printing import Delivered, Printing, PrintPlan, wishes_of, write_for_printing
from mechstyle.runs.refine import Refined, Refinement
from mechstyle.simulation.part import Workpiece
from mechstyle.styling.drawing.finishes import finish_of

AS_USUAL = Printing()
"""A strict file in the colours of a usual changer."""
COARSE = "what was simulated last is the surface drawn finer, not this one in the faces of the run: leave out --coarse to have that"
"""Said of the loop's own surface where another is delivered."""
NOT_DROPPED = "this surface was drawn finer than the run has it, and not simulated: only the last iteration is; with --fine it is dropped"
"""Said of an iteration before the last."""


class Exported(msgspec.Struct, frozen=True, kw_only=True):
    """A file that was written; the same is kept beside it as `FILE.json`.

    Attributes:
        file: Name of the file.
        lane: Lane of the run.
        iteration: Iteration the surface is of.
        recipe: Digest of its recipe.
        fine: Whether it was drawn again on more and smaller faces than the run has.
        verdict: Verdict on this very surface, None if it was not simulated.
        quality: What the relief did to the surface.
        warnings: What a user should know before printing it, one sentence each.
        fields: What the fields in it are, with their unit, by name; empty if it holds none.
        printing: What a 3MF file tells a slicer and what it costs to print; None in other formats.
    """

    file: str
    lane: str
    iteration: int
    recipe: str
    fine: bool
    verdict: Verdict | None
    quality: Quality
    warnings: tuple[str, ...]
    fields: dict[str, str] = {}
    printing: PrintPlan | None = None


class _Leaving(NamedTuple):
    """A surface that leaves a run: without and with its style, the verdict on it, words of warning, and how it was drawn finer."""

    original: SurfaceMesh
    styled: SurfaceMesh
    verdict: Verdict | None
    words: tuple[str, ...]
    found: Refined | None


def exported(
    store: Store,
    lane: str,
    part: Workpiece,
    entry: Entry,
    path: Path,
    *,
    refinement: Refinement | None = None,
    drop: bool = False,
    name: str = "",
    fields: bool = False,
    printing: Printing = AS_USUAL,
) -> Exported:
    """Write the surface of a checkpoint to a file, and what is known of it beside it.

    Args:
        store: The run.
        lane: Its lane.
        part: Its part.
        entry: The checkpoint.
        path: The file; its suffix decides the format.
        refinement: What draws it again on smaller faces, under the checkpoint's recipe; None for the faces of the run.
        drop: Whether to drop what was drawn again, if that was not done by the run.
        name: What the part is called in the file.
        fields: Whether it is to hold every field that is known of it, such as stress; in GLB and PLY.
        printing: Filaments and slicer of a 3MF file.

    Raises:
        BadInput: If the file cannot be written, or the style cannot be drawn anew.
    """
    state, recipe = store.checkpoint(entry.digest), store.recipe(entry.recipe)
    was_tested = drawn_finer(recipe, entry)
    if fields:
        check_holds_fields(path)
    printing.check(path)
    if refinement is None:
        original, styled, verdict, words, found = _in_its_own_faces(store, part, entry, state, was_tested=was_tested)
    else:
        original, styled, verdict, words, found = _on_smaller_faces(refinement, entry, state, drop=drop, was_tested=was_tested)
    known = known_fields(store, lane, part, state) if fields else ()
    plan = None
    if path.suffix.lower() == ".3mf":
        delivered = Delivered(None if found is None else found.cut, styled)
        plan = write_for_printing(path, delivered, original, part, recipe, printing, name=name)
    else:
        sheen = sheen_of(recipe) if entry.iteration else DULL
        save(styled, path, name=name, fields={one.quantity.name: _at_vertices(one, found) for one in known}, sheen=sheen)
    measured = quality(original, styled, recipe.material.density)
    record = Exported(
        file=path.name, lane=lane, iteration=entry.iteration, recipe=entry.recipe, fine=refinement is not None, verdict=verdict,
        quality=measured, warnings=(*words, *_of_the_test(verdict), *measured.warnings),
        fields={one.quantity.name: _in_words(one) for one in known}, printing=plan,
    )  # fmt: skip
    write_whole(sidecar(path), msgspec.json.format(to_json(record), indent=2))
    return record


def sheen_of(recipe: Recipe) -> Sheen:
    """How the part of a recipe reflects: as a metal, if all of its style is asked for in that metal."""
    found = {finish_of(wish.colour) for wish in wishes_of(recipe) if wish.style}
    only = found.pop() if len(found) == 1 else None
    return DULL if only is None else only[0].sheen


def _in_its_own_faces(store: Store, part: Workpiece, entry: Entry, state: Checkpoint, *, was_tested: bool) -> _Leaving:
    """A checkpoint's surface in the faces of the run; `was_tested` if its test is that of a finer one."""
    words = tuple(filter(None, [COARSE if was_tested else unsimulated(store, entry)]))
    styled = part.surface.displaced(state.displacement).coloured(state.colour)
    return _Leaving(part.surface, styled, None if words else state.verdict, words, None)


def _on_smaller_faces(refinement: Refinement, entry: Entry, state: Checkpoint, *, drop: bool, was_tested: bool) -> _Leaving:
    """The same drawn finer; `was_tested` if that is what the test of the checkpoint is of, else dropped if `drop`."""
    found = refinement.of(entry.digest, drop=drop or was_tested)
    verdict = state.verdict if was_tested else refinement.verdict(found)
    words = (*(() if was_tested else _of_the_fine_surface(verdict, state.verdict)), *found.notes)
    return _Leaving(found.original, found.styled, verdict, words, found)


def _at_vertices(known: Known, found: Refined | None) -> NDArray[np.float32]:
    """A field at the vertices of what leaves a run; where that is finer than the run, as its own test says, else interpolated."""
    if found is None:
        return known.values.astype(np.float32)
    holder = next((one for one in (found.simulation, found) if one is not None and known.quantity.is_in(one)), None)
    if holder is not None:
        return known.quantity.of(holder).astype(np.float32)
    return np.asarray(found.cut.interpolation @ known.values.astype(np.float32), np.float32)


def _in_words(known: Known) -> str:
    """What a field is, with its unit and what should be known of its values."""
    unit = f" [{known.quantity.unit}]" if known.quantity.unit else ""
    return f"{known.quantity.label}{unit}" + (f"; {known.note}" if known.note else "")


def drawn_finer(recipe: Recipe, entry: Entry) -> bool:
    """Whether the test of a checkpoint is that of the surface drawn finer: it is the last iteration's of a recipe that delivers such."""
    return recipe.delivered != 0 and entry.verdict is not None and entry.iteration == recipe.iterations


def sidecar(path: Path) -> Path:
    """Path of the sidecar that describes an exported file."""
    return path.with_name(f"{path.name}.json")


def unsimulated(store: Store, entry: Entry) -> str:
    """Why the surface of a checkpoint was not simulated, "" if it was."""
    if entry.simulated_at != entry.iteration:
        return f"this iteration was not simulated; the last simulation was at {entry.simulated_at}"
    if entry.parent and not np.array_equal(store.checkpoint(entry.digest).share, store.checkpoint(entry.parent).share):
        return "the relief was reduced right after this iteration's simulation, so this very surface was not simulated"
    return ""


def _of_the_test(verdict: Verdict | None) -> tuple[str, ...]:
    """Warnings where the surface that was written fails, and where its verdict leaves a doubt."""
    if verdict is None:
        return ()
    return tuple(filter(None, ("" if verdict.passes else verdict.head, verdict.doubt)))


def _of_the_fine_surface(verdict: Verdict | None, coarse: Verdict | None) -> tuple[str, ...]:
    """A warning if the finer surface was not dropped, or does not pass where the coarse one may have."""
    if verdict is None:
        return (NOT_DROPPED,)
    return () if verdict.passes else (sentences.delivered(verdict, coarse),)
