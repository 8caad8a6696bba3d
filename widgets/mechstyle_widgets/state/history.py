"""The light records of a run that timelines and tables show: a row for each iteration, a line for each lane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.loop.store import Entry, Store
from mechstyle.records import Recipe
from mechstyle.records.material import Material


@dataclass(frozen=True)
class Row:
    """One iteration of one lane.

    Attributes:
        iteration: Its number; the back-off rounds at the end share one and leave their last.
        digest: Digest of its checkpoint.
        parent: Digest of the checkpoint before, "" for the first.
        reason: Why it was simulated, "" if it was not.
        outcome: VIABLE, FAILS, UNKNOWN, or "" if it was not simulated.
        words: The verdict in one sentence, or "".
        peak: Stress that decides [MPa], None if it was not simulated or not to an answer.
        limit: What it may at most be [MPa], None as above.
        style_loss: Loss against the style's target.
        travel: Largest displacement since the last simulation over the schedule's threshold.
        seconds: How long it took [s], None for an iteration made before this notebook looked on.
    """

    iteration: int
    digest: str
    parent: str
    reason: str
    outcome: str
    words: str
    peak: float | None
    limit: float | None
    style_loss: float
    travel: float
    seconds: float | None


@dataclass(frozen=True)
class Branch:
    """One lane.

    Attributes:
        lane: Its name.
        parent: Lane it was branched from, "" for an original one.
        forked_at: Iteration it was branched at, None for an original one.
        iteration: Where it stands.
        iterations: Where it is to end.
        finished: Whether it has.
        outcome: Its newest verdict, "" before the first.
        changes: What its recipe has different from its parent's: name of the setting, theirs, its own.
    """

    lane: str
    parent: str
    forked_at: int | None
    iteration: int
    iterations: int
    finished: bool
    outcome: str
    changes: tuple[tuple[str, Any, Any], ...]


class _Moved(msgspec.Struct):
    """What of a stored checkpoint says how far it is from the last simulation [mm], shape [vertex_count]."""

    displacement: NDArray[np.float32]
    anchor: NDArray[np.float32]


def rows_of(
    store: Store, lane: str, thickness: NDArray[np.float32], known: Mapping[str, Row], seconds: Mapping[str, float]
) -> list[Row]:
    """One row for each iteration of a lane, oldest first.

    Args:
        store: The run directory.
        lane: Name of the lane.
        thickness: Local wall thickness [mm], shape [vertex_count].
        known: Rows read before, by digest; they are not read again.
        seconds: How long the making of checkpoints took [s], by digest, as far as it is known.
    """
    past: list[Row] = []
    digest = store.lane(lane).head
    while digest:
        past.append(known.get(digest) or _row(store, store.entry(digest), thickness, seconds.get(digest)))
        digest = past[-1].parent
    return list({row.iteration: row for row in reversed(past)}.values())


def _row(store: Store, entry: Entry, thickness: NDArray[np.float32], seconds: float | None) -> Row:
    moved = store.objects.get_record(entry.digest, _Moved)
    travel = np.abs(moved.displacement - moved.anchor) / thickness
    decides = entry.verdict.deciding if entry.verdict is not None and entry.verdict.outcome != "UNKNOWN" else None
    return Row(
        iteration=entry.iteration,
        digest=entry.digest,
        parent=entry.parent,
        reason=entry.reason,
        outcome="" if entry.verdict is None else entry.verdict.outcome,
        words="" if entry.verdict is None else entry.verdict.words,
        peak=None if decides is None else decides.value,
        limit=None if decides is None else decides.limit,
        style_loss=entry.style_loss,
        travel=float(travel.max()) / store.recipe(entry.recipe).travel,
        seconds=seconds,
    )


def branches_of(store: Store, histories: Mapping[str, list[Row]]) -> list[Branch]:
    """One line for each lane, in the order of `histories`.

    Args:
        store: The run directory.
        histories: The rows of every lane, by its name.
    """
    return [_branch(store, lane, histories) for lane in histories]


def _branch(store: Store, lane: str, histories: Mapping[str, list[Row]]) -> Branch:
    stands, rows = store.lane(lane), histories[lane]
    recipe = store.recipe(stands.recipe)
    fork = store.entry(stands.forked_from) if stands.forked_from else None
    return Branch(
        lane=lane,
        parent="" if fork is None else _parent(store, fork.digest, histories),
        forked_at=None if fork is None else fork.iteration,
        iteration=rows[-1].iteration if rows else 0,
        iterations=recipe.iterations,
        finished=store.is_finished(lane),
        outcome=next((row.outcome for row in reversed(rows) if row.outcome), ""),
        changes=() if fork is None else differences(store.recipe(fork.recipe), recipe),
    )


def _parent(store: Store, forked_from: str, histories: Mapping[str, list[Row]]) -> str:
    """The lane that made a checkpoint: the one that holds it after the place where it was branched itself."""
    for lane, rows in histories.items():
        own = [row.digest for row in rows]
        start = store.lane(lane).forked_from
        if forked_from in own and (start not in own or own.index(start) < own.index(forked_from)):
            return lane
    return ""


def differences(theirs: Recipe, ours: Recipe) -> tuple[tuple[str, Any, Any], ...]:
    """The settings two recipes do not share: name, theirs, ours; a material is told by its fields."""
    changed: list[tuple[str, Any, Any]] = []
    for name in Recipe.__struct_fields__:
        before, after = getattr(theirs, name), getattr(ours, name)
        if before == after:
            continue
        if isinstance(before, Material):
            fields = [field for field in Material.__struct_fields__ if field != "source"]
            changed += [(field, getattr(before, field), getattr(after, field)) for field in fields]
        else:
            changed.append((name, before, after))
    return tuple(one for one in changed if one[1] != one[2])
