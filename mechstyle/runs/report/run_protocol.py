"""What a report needs of a run, declared here so that runs can write reports without reports knowing runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

from mechstyle.errors import BadInput
from mechstyle.loop.store import Entry, Store
from mechstyle.pictures.panels import Picture
from mechstyle.records import Recipe, Verdict
from mechstyle.runs.summary import Summary
from mechstyle.simulation.part import Origin, Workpiece


class Part(Protocol):
    """The record of a part."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def origin(self) -> Origin:
        """Where it came from."""


class LaneOfRun(Protocol):
    """One lane of a run directory; members as in `mechstyle.Run`."""

    @property
    def store(self) -> Store:
        """The run directory."""

    @property
    def lane(self) -> str:
        """Name of the lane."""

    @property
    def recipe(self) -> Recipe:
        """The recipe in force."""

    @property
    def record(self) -> Part:
        """The part as stored."""

    @property
    def part(self) -> Workpiece:
        """The prepared part."""

    @property
    def history(self) -> list[Entry]:
        """Every checkpoint without its arrays, oldest first."""

    @property
    def finished(self) -> bool:
        """Whether the lane is at the end of its recipe."""

    @property
    def summary(self) -> Summary:
        """What a finished lane came to."""

    def show(self, iteration: int | None = None) -> Picture:
        """Styled part, stress and mask at an iteration, None for the last."""


def begun(run: LaneOfRun) -> list[Entry]:
    """The history of a lane, or BadInput if there is none yet."""
    history = run.history
    if not history:
        raise BadInput(f"lane {run.lane!r} of {run.store.root} has no checkpoint yet, so there is nothing to show: carry the run on first")
    return history


def simulated(history: Sequence[Entry]) -> Iterator[tuple[Entry, Verdict]]:
    """The simulated checkpoints with their verdicts, oldest first; the closing copy of the last is left out."""
    for entry in history:
        if entry.verdict is not None and not entry.final:
            yield entry, entry.verdict
