"""Taking a part out of a run: the file, what is known of that very surface, and what to look at before printing it."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np

from mechstyle._files import write_whole
from mechstyle.geometry.files import check_holds_fields, save
from mechstyle.geometry.glb import DULL, Sheen
from mechstyle.geometry.print_quality import Quality, quality
from mechstyle.loop.objects import to_json
from mechstyle.loop.store import Entry, Store
from mechstyle.pictures.fields import Known, known
from mechstyle.records import Checkpoint, Recipe, Simulation, Verdict, sentences
from mechstyle.runs.printing import Printing, PrintPlan, wishes_of, write_for_printing
from mechstyle.simulation.part import Workpiece
from mechstyle.simulation.printed import plastic_share
from mechstyle.styling.drawing.colours import finish_of

AS_USUAL = Printing()
"""A strict file in the colours of a usual changer."""


class Exported(msgspec.Struct, frozen=True, kw_only=True):
    """A file that was written; the same is kept beside it as `FILE.json`.

    Attributes:
        file: Name of the file.
        lane: Lane of the run.
        iteration: Iteration the surface is of.
        recipe: Digest of its recipe.
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
    verdict: Verdict | None
    quality: Quality
    warnings: tuple[str, ...]
    fields: dict[str, str] = {}
    printing: PrintPlan | None = None


def exported(
    store: Store, lane: str, part: Workpiece, entry: Entry, path: Path, *,
    name: str = "", fields: bool = False, printing: Printing = AS_USUAL,
) -> Exported:  # fmt: skip
    """Write the surface of a checkpoint to a file, whose suffix decides the format, and what is known of it to `FILE.json`.

    `fields` puts every field that is known, such as stress, into GLB and PLY; `name` is what the part is called in the file.

    Raises:
        BadInput: If the file cannot be written.
    """
    state, recipe = store.checkpoint(entry.digest), store.recipe(entry.recipe)
    if fields:
        check_holds_fields(path)
    printing.check(path)
    untested, verdict = unsimulated(entry), state.verdict
    styled = part.surface.displaced(state.displacement).coloured(state.colour)
    known, plan, words = known_fields(store, lane, part, state) if fields else (), None, dict[str, str]()
    for one in known:
        label = f"{one.quantity.label} [{one.quantity.unit}]" if one.quantity.unit else one.quantity.label
        words[one.quantity.name] = "; ".join(filter(None, (label, one.note)))
    if path.suffix.lower() == ".3mf":
        plan = write_for_printing(path, styled, part, recipe, printing, name=name)
    else:
        sheen = sheen_of(recipe) if entry.iteration else DULL
        save(styled, path, name=name, fields={one.quantity.name: one.values.astype(np.float32) for one in known}, sheen=sheen)
    measured = quality(part.surface, styled, recipe.test.material.density * plastic_share(part.tets, recipe))
    record = Exported(
        file=path.name, lane=lane, iteration=entry.iteration, recipe=entry.recipe, verdict=verdict,
        quality=measured, warnings=(*([untested] if untested else ()), *of_the_test(verdict), *measured.warnings),
        fields=words, printing=plan,
    )  # fmt: skip
    write_whole(sidecar(path), msgspec.json.format(to_json(record), indent=2))
    return record


def sheen_of(recipe: Recipe) -> Sheen:
    """How the part of a recipe reflects: as a metal, if all of its style is asked for in that metal."""
    found = {finish_of(wish.colour) for wish in wishes_of(recipe) if wish.style}
    only = found.pop() if len(found) == 1 else None
    return DULL if only is None else only[0].sheen


def sidecar(path: Path) -> Path:
    """Path of the sidecar that describes an exported file."""
    return path.with_name(f"{path.name}.json")


def unsimulated(entry: Entry) -> str:
    """That the surface of a checkpoint was not simulated, "" if it was."""
    return "" if entry.verdict else f"{sentences.untested(entry.simulated_at)}: this surface was not dropped"


def of_the_test(verdict: Verdict | None) -> tuple[str, ...]:
    """Warnings where the surface that was written fails, and where its verdict leaves a doubt."""
    return () if verdict is None else tuple(filter(None, ("" if verdict.passes else verdict.head, verdict.doubt)))


def known_fields(store: Store, lane: str, part: Workpiece, state: Checkpoint) -> tuple[Known, ...]:
    """Every field that is known of a checkpoint, in the order in which they are offered."""
    simulation = store.objects.get_record(state.simulation, Simulation) if state.simulation else None
    newest, verdict = store.checkpoint(store.lane(lane).head), store.verdict(state)
    return known(store.recipe(state.recipe), state, simulation, part.thickness, newest, verdict)
