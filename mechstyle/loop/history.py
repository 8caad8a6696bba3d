"""The history of a run: a row for each iteration of a lane, the state of each lane."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.loop.store import Entry, Store
from mechstyle.records import Recipe, Verdict
from mechstyle.records.checkpoint import restrained

E = TypeVar("E", bound=Entry)
NONE: Mapping[str, Any] = MappingProxyType({})


class Row(Entry, frozen=True, kw_only=True):
    """A checkpoint in figures; other fields as in `Entry`.

    Attributes:
        mask: Digest of its mask.
        restrained: Vertices that count as restrained.
        vertices: Vertices of the part.
        travel: Largest displacement since the last simulation over the schedule's threshold, None if it was not asked for.
        seconds: How long it took [s], None if that is not known.
    """

    mask: str
    restrained: int
    vertices: int
    travel: float | None = None
    seconds: float | None = None

    @property
    def share(self) -> float:
        """Share of the vertices that count as restrained."""
        return self.restrained / self.vertices

    @property
    def outcome(self) -> str:
        """Outcome of its verdict, "" if it was not simulated."""
        return "" if self.verdict is None else self.verdict.outcome

    @property
    def words(self) -> str:
        """The verdict in sentences, "" if it was not simulated."""
        return "" if self.verdict is None else self.verdict.words


class Step(Row, frozen=True, kw_only=True):
    """A simulated checkpoint in figures; other fields as in `Row`.

    Attributes:
        verdict: What it meant.
        added: How many of the restrained vertices were not restrained at the simulation before.
    """

    verdict: Verdict
    added: int


class _Stored(Entry, frozen=True, kw_only=True):
    """An entry with the digests of the arrays a row is worked out from."""

    mask: str
    displacement: str
    anchor: str


def rows(
    store: Store, lane: str = "main", *,
    known: Mapping[str, Row] = NONE, thickness: NDArray[np.float32] | None = None, seconds: Mapping[str, float] = NONE,
) -> list[Row]:  # fmt: skip
    """A row for each checkpoint of a lane, its inherited past included, oldest first; each mask is read once.

    Args:
        store: The run directory.
        lane: Name of the lane.
        known: Rows read before, by digest; neither they nor their masks are read again.
        thickness: Local wall thickness [mm], shape [vertex_count], if `travel` is wanted: it takes two more arrays of each checkpoint.
        seconds: How long the making of checkpoints took [s], by digest, as far as it is known.
    """
    counts = {row.mask: (row.restrained, row.vertices) for row in known.values()}
    past: list[Row] = []
    digest = store.lane(lane).head
    while digest:
        row = known.get(digest)
        if row is None:
            stored, travel = store.record(digest, _Stored), None
            if stored.mask not in counts:
                held = restrained(store.objects.get_array(stored.mask))
                counts[stored.mask] = (int(held.sum()), len(held))
            if thickness is not None:
                moved = store.objects.get_array(stored.displacement) - store.objects.get_array(stored.anchor)
                travel = float((np.abs(moved) / thickness).max()) / store.recipe(stored.recipe).schedule.travel
            count, vertices = counts[stored.mask]
            fields = {**{name: getattr(stored, name) for name in Entry.__struct_fields__}, "digest": digest}
            row = Row(**fields, mask=stored.mask, restrained=count, vertices=vertices, travel=travel, seconds=seconds.get(digest))
        past.append(row)
        digest = row.parent
    return past[::-1]


def per_iteration(history: Iterable[E]) -> list[E]:
    """The newest checkpoint of each iteration, oldest first: the corrections at the end and the closing copy share one."""
    return list({entry.iteration: entry for entry in history}.values())


def simulated(history: Iterable[E]) -> Iterator[tuple[E, Verdict]]:
    """The simulated checkpoints with their verdicts, oldest first; the closing copy of the last is left out."""
    for entry in history:
        if entry.verdict is not None and not entry.final:
            yield entry, entry.verdict


def standing(history: Sequence[E]) -> tuple[E, Verdict]:
    """What a lane has come to, with its verdict: of what is delivered once it has ended, which need not be what was simulated last.

    Its history is oldest first; the first is simulated always.
    """
    return next((entry, entry.verdict) for entry in reversed(history) if entry.verdict is not None)


def measured_at(history: Iterable[Entry], digest: str) -> int | None:
    """Iteration of the last drop up to a checkpoint that gave an answer, None if there is none; history is oldest first."""
    measured = None
    for entry in history:
        if entry.verdict is not None and entry.verdict.outcome != "UNKNOWN":
            measured = entry.iteration
        if entry.digest == digest:
            break
    return measured


def steps(store: Store, history: Iterable[Row]) -> list[Step]:
    """The simulations of a lane, the unstylized part's first."""
    before, found = None, []
    for row, _ in simulated(history):
        held = restrained(store.objects.get_array(row.mask))
        added = held if before is None else held & ~before
        found.append(Step(**msgspec.structs.asdict(row), added=int(added.sum())))
        before = held
    return found


def largest_mask_change(found: Sequence[Step]) -> Step | None:
    """The simulation of a styled surface that restrained most vertices anew, None if none did."""
    later = [step for step in found[1:] if step.added]
    return max(later, key=lambda step: step.added) if later else None


class SimulationLine(msgspec.Struct, frozen=True, kw_only=True):
    """One simulation of a lane, and its verdict.

    What stays bent and what may [mm], or of the published rule alone stress and limit [MPa], are of the worst test; None without an answer.
    """

    iteration: int
    reason: str
    outcome: str
    permanent_set: float | None = None
    allowed: float | None = None
    stress: float | None = None
    limit: float | None = None
    words: str
    sure: bool

    @classmethod
    def of(cls, entry: Entry, verdict: Verdict) -> SimulationLine:
        """The line of a simulated checkpoint and its verdict."""
        row, names = verdict.deciding, ("permanent_set", "allowed")
        if row is not None and row.test == "published rule":
            names = ("stress", "limit")
        return cls(
            iteration=entry.iteration, reason=entry.reason, outcome=verdict.outcome, words=verdict.words, sure=verdict.sure,
            **({} if row is None else {name: getattr(row, name) for name in names}),
        )  # fmt: skip


def simulations(history: Iterable[Entry]) -> tuple[SimulationLine, ...]:
    """The simulations of a lane, the unstylized part's and the closing copy left out."""
    return tuple(SimulationLine.of(entry, verdict) for entry, verdict in simulated(history) if entry.iteration > 0)


class LaneSummary(msgspec.Struct, frozen=True, kw_only=True):
    """One lane of a run directory: its recipe in force, the iteration it stands at, and whether that is its end.

    Simulations include those of its inherited past; `forked_at` is None for an original line.
    """

    lane: str
    recipe: Recipe
    iteration: int
    finished: bool
    forked_at: int | None
    simulations: tuple[SimulationLine, ...]

    @classmethod
    def of(cls, store: Store, name: str, history: Sequence[Entry]) -> LaneSummary:
        """Summary of a lane as it stands, of its checkpoints or their rows, oldest first."""
        lane = store.lane(name)
        return cls(
            lane=name, recipe=store.recipe(lane.recipe), iteration=history[-1].iteration if history else 0,
            finished=store.is_finished(name), simulations=simulations(history),
            forked_at=store.entry(lane.forked_from).iteration if lane.forked_from else None,
        )  # fmt: skip


class Branch(LaneSummary, frozen=True, kw_only=True):
    """A lane and what sets it apart from the one it was branched from; other fields as in `LaneSummary`.

    Attributes:
        parent: Lane it was branched from, "" for an original one.
        outcome: Its newest verdict, "" before the first.
        changes: What its recipe has different from its parent's: name of the setting, theirs, its own.
    """

    parent: str
    outcome: str
    changes: tuple[tuple[str, Any, Any], ...]

    @property
    def iterations(self) -> int:
        """Iterations of its recipe."""
        return self.recipe.schedule.iterations


def lanes(store: Store, histories: Mapping[str, Sequence[Entry]]) -> list[Branch]:
    """The lanes of a run in the order of `histories`: every checkpoint of each lane, or its row, by the name of the lane."""
    found = []
    for lane, of_lane in histories.items():
        summary, forked_from, parent = LaneSummary.of(store, lane, of_lane), store.lane(lane).forked_from, ""
        for name, history in histories.items() if forked_from else ():  # that which holds it after the place where it was branched itself
            own, start = [entry.digest for entry in history], store.lane(name).forked_from
            if forked_from in own and (start not in own or own.index(start) < own.index(forked_from)):
                parent = name
                break
        outcome = next((entry.verdict.outcome for entry in reversed(of_lane) if entry.verdict is not None), "")
        changes = store.recipe(store.entry(forked_from).recipe).differences(summary.recipe, by_figure=True) if forked_from else ()
        found.append(Branch(**msgspec.structs.asdict(summary), parent=parent, outcome=outcome, changes=changes))
    return found
