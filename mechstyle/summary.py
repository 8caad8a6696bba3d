"""What a run came to, in figures: the object behind `--json`, the log and the reports."""

from __future__ import annotations

import math
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager

import msgspec

from mechstyle.engine import Engine, kept
from mechstyle.events import Event, SimulationStarted
from mechstyle.records import Loaded, Recipe, Verdict
from mechstyle.store import Entry, Store


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


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """What a lane came to.

    Attributes:
        verdict: VIABLE, FAILS or UNKNOWN.
        peak_stress: Stress that decides as placed [MPa].
        allowable: What it may at most be [MPa].
        safety_factor: allowable / peak_stress, None if the peak is not known.
        words: The verdict in one sentence.
        result: The figures of the delivered part in full.
        baseline: The same of the unstylized part.
        simulations: Every simulation of the lane with its reason.
        style_loss: Loss of the delivered surface.
        style_loss_ratio: style_loss over the loss of the unstylized part.
        kept: Share of the freestyle displacement that was kept.
        iterations: Stylization iterations.
        meshing: How the tetrahedra of the last simulation followed the surface.
        backed_off: Share of the surface the tetrahedra could not follow in the last simulation.
        loads: What each load case did to the delivered part.
        failure_probability: Probability that a random drop takes the delivered part beyond the yield strength, over the orientations of the
            recipe; None if one orientation was dropped, or none gave an answer.
        seconds: Wall time per stage of the process that finished the run [s].
        notes: What the user should know, one sentence each.
        lane: Name of the lane.
        recipe: Digest of its recipe.
        device: Where it was simulated.
        files: What was written, by what it is.
    """

    verdict: str
    peak_stress: float
    allowable: float
    safety_factor: float | None
    words: str
    result: Strength
    baseline: Strength
    simulations: tuple[SimulationLine, ...]
    style_loss: float
    style_loss_ratio: float
    kept: float
    iterations: int
    meshing: str
    backed_off: float
    loads: tuple[Loaded, ...] = ()
    failure_probability: float | None = None
    seconds: dict[str, float]
    notes: tuple[str, ...]
    lane: str
    recipe: str
    device: str
    files: dict[str, str]


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


def summarise(engine: Engine, *, device: str, notes: tuple[str, ...], seconds: dict[str, float], files: dict[str, str]) -> Summary:
    """The summary of a lane its engine has just finished."""
    history = engine.store.history(engine.lane)
    last = engine.store.checkpoint(history[-1].digest)
    assert last.verdict is not None, "a finished lane ends with a simulated checkpoint"
    result = Strength.of(last.verdict)
    simulation = engine.simulator.simulate(last.displacement, thorough=True)
    start = history[0].style_loss
    return Summary(
        verdict=result.verdict,
        peak_stress=result.peak_stress,
        allowable=result.allowable,
        safety_factor=result.safety_factor,
        words=result.words,
        result=result,
        baseline=Strength.of(engine.simulator.judge(engine.simulator.baseline)),
        simulations=simulations(history),
        style_loss=last.style_loss,
        style_loss_ratio=last.style_loss / start if start else 0.0,
        kept=kept(last.displacement, engine.stylizer.proposal().displacement, engine.surface.vertex_areas),
        iterations=last.iteration,
        meshing=simulation.meshing,
        backed_off=simulation.backed_off,
        loads=simulation.loaded,
        failure_probability=None if simulation.overall is None or simulation.failure else simulation.failure_probability,
        seconds=seconds,
        notes=notes,
        lane=engine.lane,
        recipe=engine.recipe.digest,
        device=device,
        files=files,
    )


class Clock:
    """Wall seconds per stage."""

    def __init__(self) -> None:
        """Start with no stage."""
        self._seconds: defaultdict[str, float] = defaultdict(float)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the time inside the block towards a stage."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self._seconds[name] += time.perf_counter() - start

    def timed(self, events: Iterator[Event]) -> Iterator[Event]:
        """Pass events on, counting the time each took to come: after SimulationStarted `simulate`, else `stylize`."""
        name = "stylize"
        while True:
            with self.stage(name):
                event = next(events, None)
            if event is None:
                return
            name = "simulate" if isinstance(event, SimulationStarted) else "stylize"
            yield event

    def add(self, seconds: dict[str, float]) -> None:
        """Count stages measured elsewhere."""
        for name, value in seconds.items():
            self._seconds[name] += value

    def seconds(self) -> dict[str, float]:
        """Seconds per stage so far, in the order the stages began [s]."""
        return {name: round(value, 3) for name, value in self._seconds.items()}
