"""What a run will do and how long it will take: when its relief is dropped, how many falls there are, and the seconds of each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from mechstyle.fea.explicit import cores as cores_allowed
from mechstyle.loop.schedule import Progress, due
from mechstyle.records import Recipe
from mechstyle.records.material import LIBRARY
from mechstyle.records.written import written
from mechstyle.simulation.part import TETS
from mechstyle.simulation.simulator import STEERING
from mechstyle.styling.dimensions import NOMINAL, SHARE

SECONDS_PER_STEP = {"tet10": 50e-9, "tet4": 12e-9}
"""Time of one core for one tetrahedron and one step [s]: 47 to 59 ns were measured for tet10 of six parts of 2000 vertices, which yield;
tet4 is a guess."""
STEP, STEPS = 1.1e-4, 12_500
"""Time step [ms], and steps until an impact has ended: 680 to 10 000 flat and 3700 to 23 600 nearly flat were counted of eight parts."""
TETRAHEDRA = 1.25 * TETS
"""Of a part, in the mean of the plain one and one whose relief takes more: 8 000 and 12 000 to 16 000 were counted."""
NEARLY_FLAT = 8
"""Landings on the corners and sides of what a part stands on: eight of a box, six of a round base."""
MESHING = 45.0
"""Time of one core to fill a styled part, while another fills the plain one [s]: 35 to 50 s of two parts."""
PREPARING, STYLING = 2.5e-4, 6e-7
"""Time of one core for each vertex to even a surface, measure it and draw a style, and for an iteration without a fall [s]."""

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
class Estimate:
    """Falls and time of a run that has not begun.

    Attributes:
        height: Height of the falls [mm].
        falls: How many there will be, about.
        seconds: How long it will take, about [s].
    """

    height: float
    falls: int
    seconds: float

    @property
    def words(self) -> str:
        """The test and its time, to one or two figures, in one sentence."""
        step = 5.0 if self.seconds < 90 else 60.0
        about = duration(max(step * round(self.seconds / step), step))
        return f"We let it fall from {written(self.height)}, in simulation, about {self.falls} times: about {about}."


def duration(seconds: float) -> str:
    """A time for people: 40 s, 3 min, 2 h."""
    if seconds < 90:
        return f"{max(round(seconds), 1)} s"
    return f"{round(seconds / 60)} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def estimated(recipe: Recipe, vertices: int, *, fall: float | None = None, cores: int | None = None) -> Estimate:
    """Estimate of a run with one correction.

    Plain part and finished relief fall in all landings, a relief that grows in those that steer. A load counts as a fall.

    Args:
        recipe: What is asked for.
        vertices: Of the standardised surface.
        fall: What a fall of this part took on one core of this machine [s]; None to estimate it.
        cores: Cores of this machine, each of which takes a fall; None for those that this process may use.
    """
    cores, test, schedule = cores or cores_allowed(), recipe.test, recipe.schedule
    every = falls_of_a_test(recipe.settings)
    steering, plan = 1 + STEERING * test.nearly_flat + len(test.loads), plan_of(recipe.settings)
    on_the_way = 0 if plan is None else len(plan.places) - 1
    thorough = 2 + recipe.restraint.guarantee
    if fall is None:
        fall = seconds_of_a_fall(TETRAHEDRA, element=test.element, window=test.window)
    rounds = thorough * math.ceil(every / cores) + on_the_way * math.ceil(steering / cores)
    seconds = rounds * fall + MESHING + (PREPARING + schedule.iterations * STYLING) * vertices
    return Estimate(test.height, thorough * every + on_the_way * steering, seconds)


def seconds_of_a_fall(tetrahedra: float, *, element: str = "tet10", window: float | None = None) -> float:
    """Time of one core for a fall [s]: tetrahedra times steps times the time of one.

    Args:
        tetrahedra: How many the part has.
        element: Their kind.
        window: Simulated time [ms]; None until the impact has ended.
    """
    steps = STEPS if window is None else window / STEP
    return tetrahedra * steps * SECONDS_PER_STEP[element]


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


def falls_of_a_test(settings: Mapping[str, Any]) -> int:
    """Falls of the plain part and of a finished one, about; a load counts as one."""
    nearly_flat = NEARLY_FLAT if settings.get("nearly_flat", True) else 0
    return int(settings.get("orientations", 1)) + nearly_flat + len(settings.get("loads", ()))


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
