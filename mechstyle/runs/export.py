"""Taking a part out of a run: the file, what is known of that very surface, and what to look at before printing it."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np

from mechstyle._files import write_whole
from mechstyle.geometry.files import save
from mechstyle.geometry.print_quality import Quality, quality
from mechstyle.loop.objects import to_json
from mechstyle.loop.store import Entry, Store
from mechstyle.records import Verdict
from mechstyle.runs.refine import refined
from mechstyle.simulation.part import Workpiece


class Exported(msgspec.Struct, frozen=True, kw_only=True):
    """A file that was written; the same is kept beside it as `FILE.json`.

    Attributes:
        file: Name of the file.
        lane: Lane of the run.
        iteration: Iteration the surface is of.
        recipe: Digest of its recipe.
        fine: Whether it was drawn again on four times as many faces.
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


def exported(store: Store, lane: str, part: Workpiece, entry: Entry, path: Path, *, fine: bool, device: str) -> Exported:
    """Write the surface of a checkpoint to a file, and what is known of it beside it.

    Args:
        store: The run.
        lane: Its lane.
        part: Its part.
        entry: The checkpoint.
        path: The file; its suffix decides the format.
        fine: Whether to draw the style again on four times as many faces, and to drop the result.
        device: Where to drop it, `cpu` or `cuda`.

    Raises:
        BadInput: If the file cannot be written, or the style cannot be drawn anew.
    """
    state, recipe = store.checkpoint(entry.digest), store.recipe(entry.recipe)
    verdict: Verdict | None
    if fine:
        found = refined(store, part, entry.digest, device=device)
        original, styled, verdict = found.original, found.styled, found.verdict
        words = (*_of_the_fine_surface(found.verdict, state.verdict), *found.notes)
    else:
        original, styled = part.surface, part.surface.displaced(state.displacement).coloured(state.colour)
        words = tuple(filter(None, [unsimulated(store, entry)]))
        verdict = None if words else state.verdict
    measured = quality(original, styled, recipe.material.density)
    save(styled, path)
    record = Exported(
        file=path.name,
        lane=lane,
        iteration=entry.iteration,
        recipe=entry.recipe,
        fine=fine,
        verdict=verdict,
        quality=measured,
        warnings=(*words, *measured.warnings),
    )
    write_whole(sidecar(path), msgspec.json.format(to_json(record), indent=2))
    return record


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


def _of_the_fine_surface(verdict: Verdict, coarse: Verdict | None) -> tuple[str, ...]:
    """A warning if the finer surface does not keep what the coarse one promised."""
    if verdict.viable:
        return ()
    was = f", though the surface of the run was {coarse.outcome}" if coarse is not None else ""
    return (f"the fine surface is {verdict.outcome}{was}: export it without --fine, or branch with a smaller amplitude",)
