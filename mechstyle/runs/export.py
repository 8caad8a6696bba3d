"""Taking a part out of a run: the file, what is known of that very surface, and what to look at before printing it."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np

from mechstyle._files import write_whole
from mechstyle.geometry.files import check_texture, save
from mechstyle.geometry.print_quality import Quality, quality
from mechstyle.loop.objects import to_json
from mechstyle.loop.store import Entry, Store
from mechstyle.records import Recipe, Verdict
from mechstyle.runs.refine import Refinement
from mechstyle.runs.texture import Delivered, texture_of
from mechstyle.simulation.part import Workpiece

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
    """

    file: str
    lane: str
    iteration: int
    recipe: str
    fine: bool
    verdict: Verdict | None
    quality: Quality
    warnings: tuple[str, ...]


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
    textured: bool = False,
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
        textured: Whether its colours are to be a texture, finer than its vertices; in GLB and OBJ.

    Raises:
        BadInput: If the file cannot be written, or the style cannot be drawn anew.
    """
    state, recipe = store.checkpoint(entry.digest), store.recipe(entry.recipe)
    was_tested = drawn_finer(recipe, entry)
    check_texture(path, textured=textured)
    cut = None
    if refinement is None:
        original, styled = part.surface, part.surface.displaced(state.displacement).coloured(state.colour)
        words = tuple(filter(None, [COARSE if was_tested else unsimulated(store, entry)]))
        verdict = None if words else state.verdict
    else:
        found = refinement.of(entry.digest, drop=drop or was_tested)
        original, styled, cut = found.original, found.styled, found.cut
        verdict = state.verdict if was_tested else refinement.verdict(found)
        words = (*(() if was_tested else _of_the_fine_surface(verdict, state.verdict)), *found.notes)
    measured = quality(original, styled, recipe.material.density)
    save(styled, path, name=name, texture=texture_of(store, part, entry, Delivered(cut, styled)) if textured else None)
    record = Exported(
        file=path.name,
        lane=lane,
        iteration=entry.iteration,
        recipe=entry.recipe,
        fine=refinement is not None,
        verdict=verdict,
        quality=measured,
        warnings=(*words, *measured.warnings),
    )
    write_whole(sidecar(path), msgspec.json.format(to_json(record), indent=2))
    return record


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


def _of_the_fine_surface(verdict: Verdict | None, coarse: Verdict | None) -> tuple[str, ...]:
    """A warning if the finer surface was not dropped, or does not keep what the coarse one promised."""
    if verdict is None:
        return (NOT_DROPPED,)
    if verdict.viable:
        return ()
    was = f", though the surface of the run was {coarse.outcome}" if coarse is not None else ""
    return (f"the fine surface is {verdict.outcome}{was}: export it with --coarse, or branch with a smaller amplitude",)
