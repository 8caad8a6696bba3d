"""Forecast of a schedule: iterations that will be simulated, as far as is known before the run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from mechstyle.loop.schedule import Progress, due
from mechstyle.records import Recipe
from mechstyle.records.material import LIBRARY
from mechstyle.simulation.simulator import STEERING
from mechstyle.styling.dimensions import NOMINAL, SHARE

APPROACH = 40.0
"""Iterations in which the style comes nearer to its target by a factor of e."""
RELIEF = 1.2
"""Highest relief of a style over amplitude and wall thickness."""
SUPPOSED_WALL = 3.0
"""What is taken for the wall of a part that is not measured yet [mm]."""
SUPPOSED_DEMAND = 0.5
"""What is taken for the demand of the vertex that moves most, where the schedule heeds it."""
DECIDES = ("schedule", "every", "travel", "iterations", "relief", "amplitude")
"""Fields of a recipe the plan depends on."""


@dataclass(frozen=True)
class Plan:
    """Forecast of a schedule.

    Attributes:
        places: Iterations to be simulated, the last of them the last of the run; the unstylized part is simulated besides.
        certain: Whether that is settled beforehand, or depends on how the surface moves.
    """

    places: tuple[int, ...]
    certain: bool

    @property
    def count(self) -> str:
        """Number of drop tests, in words."""
        number = len(self.places)
        return f"{'' if self.certain else 'about '}{number} simulation{'s' if number > 1 else ''}"


def plan_of(settings: Mapping[str, Any]) -> Plan | None:
    """The plan of settings, None if they do not tell all it depends on."""
    if not all(name in settings for name in DECIDES):
        return None
    return plan(*(settings[name] for name in DECIDES))


def landings_on_the_way(settings: Mapping[str, Any]) -> int:
    """Landings of a test while the relief grows; the last test has all there are."""
    return 1 + (STEERING if settings.get("nearly_flat", True) else 0)


@lru_cache(maxsize=8)
def plan(schedule: str, every: int, travel: float, iterations: int, relief: float | None, amplitude: float | None) -> Plan:
    """Iterations a schedule simulates if nothing is restrained; arguments as in a recipe.

    The rules are the engine's own, asked about one vertex whose relief approaches its full height exponentially.
    """
    recipe = Recipe.of(prompt="", material=LIBRARY["PLA"], schedule=schedule, every=every, travel=travel,
                    iterations=iterations)  # fmt: skip
    demand = np.full(1, SUPPOSED_DEMAND if schedule == "stress" else 0.0, np.float32)
    share = relief / (NOMINAL * SUPPOSED_WALL) if relief is not None else SHARE if amplitude is None else amplitude
    found, anchor, wall = [0], 0.0, np.ones(1, np.float32)
    for iteration in range(1, iterations):
        height = RELIEF * share * (1.0 - np.exp(-iteration / APPROACH))
        moved = np.full(1, height - anchor, np.float32)
        if due(recipe, Progress(iteration, found[-1], moved, wall, demand)):
            found.append(iteration)
            anchor = height
    return Plan((*found[1:], iterations), certain=schedule not in ("geometry", "stress"))
