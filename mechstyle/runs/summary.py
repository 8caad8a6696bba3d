"""The result of a run in figures: the object behind `--json`, the log and the reports."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field

import msgspec

from mechstyle.loop.engine import Engine, Event, SimulationStarted
from mechstyle.loop.history import SimulationLine, simulations
from mechstyle.records import Doubt, Landing, LoadResult, Row, Simulation, Verdict
from mechstyle.simulation.more_walls import shell_words, with_more_walls
from mechstyle.simulation.simulator import DropSimulator

LITTLE = 0.7
"""Share of the style's relief below which it is said how more of it may be had."""
CUTS = 0.1
"""Least share of what can be seen of a style that cuts in, for it to be worth having it go outwards."""
OUTWARDS = " of the style is left: cuts into a wall weaken it, so try relief that only goes outwards (--side outwards)"


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """Result of a lane.

    Attributes:
        outcome: HOLDS, NO WORSE, FAILS or UNKNOWN.
        doubts: Why the outcome is not sure; none if it is.
        tolerance: The most that may stay bent [mm].
        rows: The tests, each with what stays bent of the part and of its original, and what may.
        words: The verdict in sentences.
        landings: What each drop of the last simulation did, flat first.
        loads: What each load case did then.
        plain: The verdict on the unstylized part by itself.
        simulations: Every simulation of the lane with its reason.
        style_loss: Loss of the delivered surface.
        style_loss_ratio: style_loss over the loss of the unstylized part.
        kept: Share of the style's relief that is left, by what can be seen of it.
        iterations: Stylization iterations.
        meshing: How the tetrahedra of the last simulation followed the surface.
        carried: Share of the relief that the tetrahedra of the last simulation follow.
        level_share: Share of the flat faces the part stands on that the relief leaves on the floor, None if it stands on none.
        backed_off: Share of the surface the tetrahedra could not follow in the last simulation.
        seconds: Wall time per stage of the process that finished the run [s].
        notes: What the user should know, one sentence each.
        lane: Name of the lane.
        recipe: Digest of its recipe.
        device: Where it was simulated.
        files: What was written, by what it is.
    """

    outcome: str
    doubts: tuple[Doubt, ...]
    tolerance: float = 0.0
    rows: tuple[Row, ...]
    words: str
    landings: tuple[Landing, ...]
    loads: tuple[LoadResult, ...]
    plain: Verdict
    simulations: tuple[SimulationLine, ...]
    style_loss: float
    style_loss_ratio: float
    kept: float
    iterations: int
    meshing: str
    backed_off: float
    level_share: float | None = None
    carried: float = 1.0
    seconds: dict[str, float]
    notes: tuple[str, ...]
    lane: str
    recipe: str
    device: str
    files: dict[str, str]


def little_left(kept: float, cuts: float) -> str:
    """What to try where little of a relief is left, "" where enough is left or hardly any of it cuts in; both are shares."""
    return f"only {kept:.0%}{OUTWARDS}" if kept < LITTLE and cuts >= CUTS else ""


def on_little(notes: Iterable[str]) -> str:
    """The note of `little_left` among those of a summary, "" if there is none."""
    return next((note for note in notes if note.endswith(OUTWARDS)), "")


def summarise(engine: Engine, *, device: str, notes: tuple[str, ...], seconds: dict[str, float], files: dict[str, str]) -> Summary:
    """The summary of a lane its engine has just finished."""
    history = engine.store.history(engine.lane)
    last = engine.store.checkpoint(history[-1].digest)
    verdict = last.verdict
    assert verdict is not None, "a finished lane ends with a simulated checkpoint"
    simulation = engine.store.objects.get_record(last.simulation, Simulation)
    start, kept = history[0].style_loss, engine.kept(last)
    little = little_left(kept, engine.cuts()) if engine.recipe.restraint.guarantee else ""
    shell = shell_words(engine.surface.displaced(simulation.displacement), engine.recipe)
    walls = with_more_walls(engine.simulator, simulation, verdict) if isinstance(engine.simulator, DropSimulator) else ""
    return Summary(
        outcome=verdict.outcome, doubts=verdict.doubts, tolerance=verdict.tolerance, rows=verdict.rows, words=verdict.words,
        landings=simulation.landings, loads=simulation.loads, plain=engine.simulator.judge(engine.simulator.baseline, alone=True),
        simulations=simulations(history), style_loss=last.style_loss, style_loss_ratio=last.style_loss / start if start else 0.0,
        kept=kept, iterations=last.iteration, meshing=simulation.meshing, carried=simulation.carried,
        level_share=simulation.level_share, backed_off=simulation.backed_off, seconds=seconds,
        notes=(*notes, *filter(None, (little, shell, walls))), lane=engine.lane,
        recipe=engine.recipe.digest, device=device, files=files,
    )  # fmt: skip


@dataclass(eq=False)
class Clock:
    """Wall seconds per stage."""

    _seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the time inside the block towards a stage."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.add({name: time.perf_counter() - start})

    @contextmanager
    def stages(self, tell: Callable[[str], None]) -> Iterator[Callable[[str], None]]:
        """A function that tells of a stage and counts the time until the next one, or until the block ends, towards it."""
        with ExitStack() as current:

            def begin(name: str) -> None:
                current.close()
                tell(name)
                current.enter_context(self.stage(name))

            yield begin

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
            self._seconds[name] = self._seconds.get(name, 0.0) + value

    def seconds(self) -> dict[str, float]:
        """Seconds per stage so far, in the order the stages began [s]."""
        return {name: round(value, 3) for name, value in self._seconds.items()}
