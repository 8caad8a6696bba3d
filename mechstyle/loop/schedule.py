"""When a simulation is worth its cost: pure functions of the iteration and of how far the surface has travelled.

Every rule answers with the reason, in words shown to the user, or "" for no simulation. The last iteration is always
simulated by the engine, whatever the schedule.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mechstyle.records import Recipe

if TYPE_CHECKING:
    from collections.abc import Callable

LATE_CHECK = 0.75
"""Geometry and stress schedules look once more after this share of the iterations: their triggers come early."""

SOFTEST = 0.1
"""The stress schedule lowers a vertex's threshold to no less than this share, or it would simulate at every iteration."""


@dataclass(frozen=True)
class Progress:
    """State of a run on which a schedule decides.

    Attributes:
        iteration: Current iteration, from 1.
        simulated_at: Iteration of the last simulation, 0 if there was none.
        travelled: Displacement since the last simulation [mm], shape [vertex_count].
        thickness: Wall thickness around a vertex [mm], shape [vertex_count].
        demand: s_norm of the last simulation, shape [vertex_count].
    """

    iteration: int
    simulated_at: int
    travelled: NDArray[np.float32]
    thickness: NDArray[np.float32]
    demand: NDArray[np.float32]


def every(recipe: Recipe, progress: Progress) -> str:
    """Every k iterations: the paper's control condition."""
    return f"every {recipe.schedule.every} iterations" if progress.iteration % recipe.schedule.every == 0 else ""


def quadratic(_recipe: Recipe, progress: Progress) -> str:
    """At 1, 4, 9, 16 …: dense early, when the surface moves most."""
    root = round(progress.iteration**0.5)
    return f"quadratic step {root}² = {progress.iteration}" if root * root == progress.iteration else ""


def exponential(_recipe: Recipe, progress: Progress) -> str:
    """At 2, 4, 8, 16 …: each interval twice the one before."""
    i = progress.iteration
    return f"exponential step 2^{i.bit_length() - 1} = {i}" if i > 1 and i & (i - 1) == 0 else ""


def _late_check(recipe: Recipe, progress: Progress) -> str:
    late = round(LATE_CHECK * recipe.schedule.iterations)
    return f"late check after {LATE_CHECK:.0%} of the iterations" if progress.iteration >= late > progress.simulated_at else ""


def geometry(recipe: Recipe, progress: Progress) -> str:
    """When some vertex has moved more than `travel` of its local thickness since the last simulation."""
    ratio = np.abs(progress.travelled) / progress.thickness
    worst = int(np.argmax(ratio))
    if ratio[worst] > recipe.schedule.travel:
        return _moved(progress, worst, recipe.schedule.travel)
    return _late_check(recipe, progress)


def _moved(progress: Progress, vertex: int, most: float) -> str:
    moved, wall = abs(progress.travelled[vertex]), progress.thickness[vertex]
    return f"the relief has moved {moved:.2f} mm on a wall of {wall:.1f} mm: more than {most:.1%} of it"


def stress(recipe: Recipe, progress: Progress) -> str:
    """As `geometry`, each vertex's threshold lowered in proportion to its demand."""
    threshold = recipe.schedule.travel * np.clip(1.0 - progress.demand, SOFTEST, 1.0)
    ratio = np.abs(progress.travelled) / progress.thickness
    worst = int(np.argmax(ratio / threshold))
    if ratio[worst] > threshold[worst]:
        return _moved(progress, worst, threshold[worst])
    return _late_check(recipe, progress)


RULES: dict[str, Callable[[Recipe, Progress], str]] = {
    "every": every,
    "quadratic": quadratic,
    "exponential": exponential,
    "geometry": geometry,
    "stress": stress,
    "never": lambda _recipe, _progress: "",
}


def due(recipe: Recipe, progress: Progress) -> str:
    """Why this iteration is to be simulated under the recipe's schedule, "" if it is not."""
    return RULES[recipe.schedule.when](recipe, progress)
