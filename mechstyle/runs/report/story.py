"""What happened in a lane, simulation by simulation: why, what came out, and how many vertices were held back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import msgspec

from mechstyle.loop.store import Entry
from mechstyle.records import Verdict
from mechstyle.runs.report.run_protocol import LaneOfRun, simulated

RESTRAINED_BELOW = 0.5
"""A vertex counts as restrained where the mask lets less than half of its movement through."""


@dataclass(frozen=True)
class Step:
    """One simulation.

    Attributes:
        iteration: When.
        reason: Why.
        verdict: What it meant.
        restrained: Vertices restrained after it.
        added: How many of them were not before.
        vertices: Vertices of the part.
    """

    iteration: int
    reason: str
    verdict: Verdict
    restrained: int
    added: int
    vertices: int

    @property
    def share(self) -> float:
        """Share of the vertices restrained after it."""
        return self.restrained / self.vertices


class _Mask(msgspec.Struct, frozen=True):
    mask: str


def steps(run: LaneOfRun, history: Sequence[Entry]) -> list[Step]:
    """Every simulation of a lane, the unstylized part's first."""
    before, told = None, []
    for entry, verdict in simulated(history):
        digest = run.store.objects.get_record(entry.digest, _Mask).mask
        held = run.store.objects.get_array(digest) < RESTRAINED_BELOW
        added = int(held.sum() if before is None else (held & ~before).sum())
        told.append(Step(entry.iteration, entry.reason, verdict, int(held.sum()), added, len(held)))
        before = held
    return told


def largest_mask_change(told: Sequence[Step]) -> Step | None:
    """The simulation of a styled surface that restrained most vertices anew, None if none did."""
    later = [step for step in told[1:] if step.added]
    return max(later, key=lambda step: step.added) if later else None

