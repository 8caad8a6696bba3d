"""Estimate of the falls and the time of a run before it begins, from the size of its mesh, or from what falls took on this machine."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mechstyle.fea.explicit import cores as cores_allowed
from mechstyle.records import Recipe, sentences
from mechstyle.simulation.part import TETS
from mechstyle.simulation.simulator import STEERING

SECONDS_PER_STEP = {"tet10": 50e-9, "tet4": 12e-9}
"""Time of one core for one tetrahedron and one step [s]: 47 to 59 ns were measured for tet10 of six parts of 2000 vertices, which yield;
tet4 is a guess."""
STEP, STEPS = 1.1e-4, 12_500
"""Time step [ms], and steps until an impact has ended: 680 to 10 000 flat and 3700 to 23 600 nearly flat were counted of eight parts."""
FINEST = 25_000
"""Vertices of a surface from which on meshing takes the same time: its faces are cut smaller."""
NEARLY_FLAT = 8
"""Landings on the corners and sides of what a part stands on: eight of a box, six of a round base."""
USUAL_TESTS = 5
"""Tests on the way of a schedule that heeds shape or stress, in the middle of the runs of docs/why-these-defaults.md."""
MESHING = 0.8e-3
"""Time of one core to mesh a part, for each vertex of its surface [s]."""
STYLING = 4e-6
"""Time of an iteration without a fall, for each vertex [s]."""


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
        """The test and its time, in one sentence."""
        return sentences.planned(self.height, self.falls, self.seconds)


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
    every = test.orientations + NEARLY_FLAT * test.nearly_flat + len(test.loads)
    steering = 1 + STEERING * test.nearly_flat + len(test.loads)
    on_the_way = {"never": 0, "every": (schedule.iterations - 1) // schedule.every}.get(schedule.when, USUAL_TESTS)
    thorough = 2 + recipe.restraint.guarantee
    if fall is None:
        fall = seconds_of_a_fall(TETS, element=test.element, window=test.window)
    rounds = thorough * math.ceil(every / cores) + on_the_way * math.ceil(steering / cores)
    seconds = rounds * fall + 2 * MESHING * min(vertices, FINEST) + schedule.iterations * STYLING * vertices
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
