"""What happened in a run: the figures of a verdict, the simulations of a lane, what each lane has come to."""

from __future__ import annotations

import math

import msgspec

from mechstyle.loop.store import Entry, Store
from mechstyle.records import Recipe, Verdict


class Strength(msgspec.Struct, frozen=True, kw_only=True):
    """What a verdict says in figures.

    Attributes:
        verdict: VIABLE, FAILS or UNKNOWN.
        peak_stress: Stress that decides as placed [MPa].
        allowable: What it may at most be [MPa].
        safety_factor: allowable / peak_stress, None if the peak is not known.
        maximum: Literal maximum over the elements [MPa].
        all_orientations: p99 over all orientations relative to the unstylized part, None if not run.
        words: The verdict in one sentence.
    """

    verdict: str
    peak_stress: float
    allowable: float
    safety_factor: float | None
    maximum: float
    all_orientations: float | None
    words: str

    @classmethod
    def of(cls, verdict: Verdict) -> Strength:
        """The figures of a verdict."""
        decides = verdict.deciding
        return cls(
            verdict=verdict.outcome,
            peak_stress=decides.value,
            allowable=decides.limit,
            safety_factor=decides.safety_factor if math.isfinite(decides.safety_factor) else None,
            maximum=verdict.literal.value,
            all_orientations=None if verdict.all_orientations is None else verdict.all_orientations.value,
            words=verdict.words,
        )


class SimulationLine(msgspec.Struct, frozen=True, kw_only=True):
    """One simulation of a lane; `peak_stress` [MPa]."""

    iteration: int
    reason: str
    verdict: str
    peak_stress: float
    words: str

    @classmethod
    def of(cls, entry: Entry) -> SimulationLine:
        """The line of a simulated checkpoint."""
        verdict = entry.verdict
        assert verdict is not None, "only simulated checkpoints have a line"
        return cls(
            iteration=entry.iteration,
            reason=entry.reason,
            verdict=verdict.outcome,
            peak_stress=verdict.deciding.value,
            words=verdict.words,
        )


def simulations(history: list[Entry]) -> tuple[SimulationLine, ...]:
    """The simulations of a lane, the unstylized part's and the closing copy left out."""
    return tuple(SimulationLine.of(entry) for entry in history if entry.verdict is not None and entry.iteration > 0 and not entry.final)


class LaneSummary(msgspec.Struct, frozen=True, kw_only=True):
    """One lane of a run directory, finished or not.

    Attributes:
        lane: Its name.
        recipe: The recipe in force.
        iteration: Iteration it stands at.
        finished: Whether that is its end.
        forked_at: Iteration it was branched at, None for an original line.
        simulations: Every simulation, its inherited past included.
    """

    lane: str
    recipe: Recipe
    iteration: int
    finished: bool
    forked_at: int | None
    simulations: tuple[SimulationLine, ...]

    @classmethod
    def of(cls, store: Store, name: str) -> LaneSummary:
        """What a lane has come to so far."""
        lane, history = store.lane(name), store.history(name)
        return cls(
            lane=name,
            recipe=store.recipe(lane.recipe),
            iteration=history[-1].iteration if history else 0,
            finished=store.is_finished(name),
            forked_at=store.entry(lane.forked_from).iteration if lane.forked_from else None,
            simulations=simulations(history),
        )
