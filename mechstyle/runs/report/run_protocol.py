"""The run as a report sees it: a protocol, so that runs can write reports without reports importing runs."""

from __future__ import annotations

from typing import Protocol

from mechstyle.errors import BadInput
from mechstyle.loop.history import Row, rows
from mechstyle.loop.store import Store
from mechstyle.pictures.panels import Picture
from mechstyle.records import Recipe
from mechstyle.runs.folders import PartRecord
from mechstyle.runs.summary import Summary
from mechstyle.simulation.part import Workpiece
from mechstyle.simulation.simulator import DropSimulator


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
    def record(self) -> PartRecord:
        """The part as stored."""

    @property
    def part(self) -> Workpiece:
        """The prepared part."""

    @property
    def finished(self) -> bool:
        """Whether the lane is at the end of its recipe."""

    @property
    def summary(self) -> Summary:
        """Summary of a finished lane."""

    def simulator(self, recipe: Recipe) -> DropSimulator:
        """The drop test of the part under a recipe."""

    def show(self, iteration: int | None = None) -> Picture:
        """Styled part, stress, what stays bent and mask at an iteration, None for the last."""


def begun(run: LaneOfRun) -> list[Row]:
    """A row for each checkpoint of a lane, or BadInput if there is none yet."""
    history = rows(run.store, run.lane)
    if not history:
        raise BadInput(f"lane {run.lane!r} of {run.store.root} has no checkpoint yet, so there is nothing to show: carry the run on first")
    return history
