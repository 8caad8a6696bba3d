"""A run done again from its recipe, and where it comes to something else."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

import msgspec

from mechstyle._files import write_whole
from mechstyle.errors import BadInput
from mechstyle.loop.engine import Checkpointed, Event
from mechstyle.loop.objects import MESH_FOR, UNDEFORMED
from mechstyle.loop.store import Entry, Lane, Store
from mechstyle.records import Verdict, sentences
from mechstyle.runs import images
from mechstyle.runs.run import Run
from mechstyle.simulation.meshes import KeptMesh

CLOSE = 1e-5
"""Relative difference of what stays bent, or stress, that another processor may make …"""
LEAST = 1e-3
"""… of what is at least this large [mm, MPa]."""


class Difference(msgspec.Struct, frozen=True, kw_only=True):
    """A test that came to something else.

    Attributes:
        iteration: When.
        test: The test in which the two differ most, "" where neither gave an answer.
        before: What stayed bent in it then [mm]; by the published rule the stress [MPa]; NaN without an answer.
        again: The same in the repetition [MPa].
        verdict: Outcome then.
        verdict_again: Outcome in the repetition.
    """

    iteration: int
    test: str
    before: float
    again: float
    verdict: str
    verdict_again: str


class Rerun(msgspec.Struct, frozen=True, kw_only=True):
    """What a run done again came to.

    Attributes:
        folder: Where it is.
        same_bytes: Whether every iteration has the bytes it had.
        first_other: The first iteration that has not, None if there is none.
        drops: Simulations compared.
        largest: Largest relative difference of what stays bent.
        differences: Simulations whose outcome is another, or of which what stays bent is further off than CLOSE.
    """

    folder: str
    same_bytes: bool
    first_other: int | None
    drops: int
    largest: float
    differences: tuple[Difference, ...]

    @property
    def equal(self) -> bool:
        """Whether all outcomes are the same and nothing is further off than CLOSE."""
        return not self.differences

    @property
    def words(self) -> str:
        """The result in one sentence."""
        drops = f"{self.drops} drop tests"
        if self.same_bytes:
            return f"equal: every iteration and all {drops} have the same bytes"
        if self.equal:
            close = f"the outcomes of {drops} are the same, what stays bent within {self.largest:.1e}"
            return f"equal: {close}; other bytes from iteration {self.first_other} on"
        first = self.differences[0]
        unit = "MPa" if first.test == "published rule" else "mm"
        figures = f"{first.verdict_again}, {first.again:.4g} {unit}, instead of {first.verdict}, {first.before:.4g} {unit}"
        found = f"{figures} ({first.test})" if first.test else figures
        return f"differs: {len(self.differences)} of {drops}, the first at iteration {first.iteration}: {found}"


def rerun(run: Run, out: Path, on_event: Callable[[Event], None] = lambda _: None) -> Rerun:
    """Repeat a lane in a folder of its own, from the part, tetrahedra and recipes that its run directory holds; nothing remembered is used.

    It is repeated up to where it stands, finished or not, through the recipes of all lanes it was branched from.

    Raises:
        BadInput: If the folder is taken, or the lane has no checkpoint yet.
    """
    history = run.history
    if not history:
        raise BadInput(f"lane {run.lane!r} of {run.store.root} has no iteration to repeat yet")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise BadInput(f"{out} is taken: give a free folder with --out")
    again = _begun(run, out)
    for recipe, entries in itertools.groupby(history, key=lambda entry: entry.recipe):
        fields, store, checkpoints = run.store.recipe(recipe), again.store, len(list(entries))
        with store.branching():
            if fields.style.image:
                _copy(run.store, store, fields.style.image)
                images.keep(fields, store)
            head = store.lane().head if store.lanes() else ""
            store.move("main", Lane(recipe=store.put_recipe(fields), head=head))
        with closing(again.events()) as events:  # as many checkpoints as the lane has under the recipe, or as many as come
            for event in events:
                on_event(event)
                checkpoints -= isinstance(event, Checkpointed)
                if not checkpoints and not (isinstance(event, Checkpointed) and event.checkpoint.final):
                    break
    return compared(history, again.history, str(out))


def _begun(run: Run, out: Path) -> Run:
    """A run directory with the part and the tetrahedra of another, and no results."""
    store, record, file = Store(out), run.record, run.store.root / "part.json"
    part = record.droppable(record.part(run.store.objects, file), file)
    write_whole(out / "part.json", msgspec.json.encode(type(record).kept(part, record.name, record.origin, store.objects)))
    for name in (*run.store.memo.named(UNDEFORMED), *run.store.memo.named(MESH_FOR)):
        memo = run.store.memo
        kept = memo.recall(name, str) if name.startswith(UNDEFORMED) else memo.recall(name, KeptMesh)
        if kept is not None:
            for digest in (kept,) if isinstance(kept, str) else (kept.tets, kept.at):
                _copy(run.store, store, digest)
            store.memo.remember(name, kept)
    return Run(store, "main", run.device, trusting=False)


def _copy(source: Store, target: Store, digest: str) -> None:
    """Copy an object, and those that a mesh is made of."""
    content = source.objects.get(digest)
    target.objects.put(content)
    if content.startswith(b"{"):
        for part in msgspec.json.decode(content, type=dict[str, str]).values():
            target.objects.put(source.objects.get(part))


def compared(before: Sequence[Entry], again: Sequence[Entry], folder: str) -> Rerun:
    """The difference of two histories, oldest first."""
    aligned = itertools.zip_longest(before, again[: len(before)])
    first_other = next((old.iteration for old, new in aligned if new is None or old.digest != new.digest), None)
    found = []
    for old, new in zip(before, again, strict=False):
        if old.verdict is None:
            continue
        earlier, later = _figures(old.verdict), _figures(new.verdict)
        apart = {test: _share(earlier.get(test, math.nan), later.get(test, math.nan)) for test in {**earlier, **later} or ("",)}
        worst = max(apart, key=apart.__getitem__)
        found.append(
            Difference(
                iteration=old.iteration, test=worst, before=earlier.get(worst, math.nan), again=later.get(worst, math.nan),
                verdict=old.verdict.outcome, verdict_again="not simulated" if new.verdict is None else new.verdict.outcome,
            )
        )  # fmt: skip
    shares = [_share(one.before, one.again) for one in found]
    other = tuple(one for one, share in zip(found, shares, strict=True) if share > CLOSE or one.verdict != one.verdict_again)
    return Rerun(
        folder=folder, same_bytes=first_other is None, first_other=first_other,
        drops=len(found), largest=max(shares, default=0.0), differences=other,
    )  # fmt: skip


def _figures(verdict: Verdict | None) -> dict[str, float]:
    """What stays bent in each test [mm], or its stress [MPa], by its name."""
    rows = () if verdict is None else verdict.rows
    return {sentences.label(row): row.permanent_set if row.stress is None else row.stress for row in rows}


def _share(before: float, again: float) -> float:
    """Relative difference of two figures, 0 where neither gave an answer and infinite where one did."""
    if math.isnan(before) or math.isnan(again):
        return 0.0 if math.isnan(before) and math.isnan(again) else math.inf
    return abs(again - before) / max(abs(before), LEAST)
